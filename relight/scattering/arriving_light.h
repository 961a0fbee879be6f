// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that arrives at each voxel of the tree at one moment, per channel: the brackets
// of
//
//   L_ss(u) = S tau(u, w_sun) + integral of L_sky(w) tau(u, w) dw         [Cabral11, Eq.
//   8]
//
// with S the sun's irradiance on a plane facing it, and the sky's integral as a product
// of spherical-harmonic coefficients, sum_lm L_lm c_lm(u)                    [Cabral11,
// Eq. 17]

#include "relight/scattering/sky_transmittance.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <vector>

namespace relight {

// One value per non-empty voxel, in the order of FindOccupied; in the unit of the
// Daylight.
struct ArrivingLight {
  std::vector<Eigen::Array3f> sun;
  std::vector<Eigen::Array3f> sky;
  std::vector<Eigen::Array3f> indirect;  // From the ground (ground_bounce.h); else 0.
};

// The sky's light is floored at 0: a few bands may overshoot in the darkest voxels.
ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight);

}  // namespace relight
