// SPDX-License-Identifier: Apache-2.0
#pragma once

// Relative optical air mass: the length of the way through the atmosphere, in units of
// the way straight up.
//
//   [KastenYoung89] docs/bibliography.md#kastenyoung89
//
//   m(z) = 1 / (cos z + 0.50572 (96.07995 - z)^-1.6364),   z in degrees  [KastenYoung89]
//
// z is the zenith angle. The paper means the apparent one; we have no refraction and give
// the true one, as [Cabral11] and [Preetham99] do: at 85 degrees m is then 1.6 % larger.

#include <Eigen/Core>

namespace relight {

// Defined for z in [0, 91] degrees; throws InputError beyond, where the sun has set and
// the formula turns back (it has a maximum near 91.7, and ends at 96.08).
double AirMass(double zenith_rad);

// Of the sun in that direction; throws InputError when it is at or below the horizon and
// gives no light.
double AirMassOfSun(const Eigen::Vector3d& sun_in_world);

}  // namespace relight
