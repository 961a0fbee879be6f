// SPDX-License-Identifier: Apache-2.0
#pragma once

// Leaves do not scatter evenly to all sides: seen from the side that the light comes from
// they show the half of them that is lit. Flat leaves of two faces, turned to all
// directions alike, which reflect and transmit as Lambert says, send towards the eye, at
// the angle b between the light's way on and the way to the eye,
//
//   p(b) = 8 / (3 pi) (sin b - b cos b) + 8 / 3 t cos b        [Ross81]     (S11)
//
// times what leaves that scatter evenly would send; t is the share of the scattered light
// that has gone through the leaf. The mean over the sphere is 1, whatever t, and light
// and eye may change places.
//
// Of the sun the eye is where it is; for the sky it is taken to be far away, so that each
// direction of the sky has one p for the whole tree.

#include "relight/scattering/arriving_light.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

namespace relight {

// p of (S11), at least 0. `cosine`: between the directions to the light and to the eye.
double LeafPhase(double cosine, double transmitted_share);

// Makes sun and sky of `light`, which was made for `daylight`, what leaves scatter
// towards `eye` (ENU, m); a uniform sky of the full sphere is not changed but for
// rounding.
void ScatterTowards(const Eigen::Vector3d& eye,
                    double transmitted_share,
                    const ExtinctionGrid& grid,
                    const OccupiedVoxels& occupied,
                    const SkyTransmittance& sky_transmittance,
                    const Daylight& daylight,
                    ArrivingLight& light);

}  // namespace relight
