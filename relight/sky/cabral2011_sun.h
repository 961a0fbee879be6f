// SPDX-License-Identifier: Apache-2.0
#pragma once

// Irradiance of the sun as [Cabral11] has it: one exponential of the air mass a channel.
//
//   [Cabral11] docs/bibliography.md#cabral11
//
//   L_sun = alpha N_max exp(-beta m(omega_sun)^k)                       [Cabral11, Eq.
//   10]
//
// The paper takes alpha and beta from a source we do not have. Ours are fitted to
// [Preetham99]'s own sun at turbidity 4.2: they err by at most 0.4 % from the zenith to
// 15 degrees above the horizon (air mass 3.8; 0.3 % at the air masses they were fitted
// to), by 1.8 % at air mass 5, and by more below. k is 1, or the sunset heuristic of
// section 7.1 of the paper: 2.5 for red, 2 for green and blue.

#include "relight/base/field.h"

#include <Eigen/Core>

namespace relight {

struct Cabral2011SunOptions {
  bool sunset_correction = false;
};

template <class Visitor>
void Describe(Cabral2011SunOptions& o, Visitor&& field) {
  field(
      o.sunset_correction,
      {"sunset-correction", "", "a sun that fades faster when low, as the paper has it"});
}

// Linear Rec.709 [lx] on a plane that faces the sun. Throws InputError for a sun at or
// below the horizon.
Eigen::Array3d Cabral2011SunIrradiance(const Eigen::Vector3d& sun_in_world,
                                       const Cabral2011SunOptions& options = {});

// The same for a given air mass.
Eigen::Array3d Cabral2011SunIrradianceAtAirMass(double air_mass,
                                                const Cabral2011SunOptions& options = {});

}  // namespace relight
