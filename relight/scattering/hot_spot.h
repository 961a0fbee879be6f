// SPDX-License-Identifier: Apache-2.0
#pragma once

// Leaves that are seen are lit more often than leaves at large: a gap that the eye looks
// through lets the sun through as well, where both look through the same leaves. Two ways
// from a point u, to the eye and to the sun, are t d apart at the distance t, with
// d = 2 sin(gamma / 2), gamma the angle between them. Gaps that lie s apart are taken to
// be correlated by exp(-s / l), so that what is seen at u is lit with
//
//   tau(u, w_sun | seen) = min(1, tau(u, w_sun) exp(sigma(u) l / d))              (S4)
//
// the hot spot of [Kuusk91], for ways longer than l / d and with the voxel's extinction
// sigma on both. Discs of radius r that face both ways have l = 8 r / (3 pi), a third to
// a half of a leaf's width. With the sun behind the eye all that is seen is lit.

#include "relight/scattering/arriving_light.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

namespace relight {

// Brightens the sun's part of `light`, which was made for `daylight`, for an eye at `eye`
// (ENU, m). Nothing changes for `gap_length_m` 0, nor where there is no sun.
void AddHotSpot(const ExtinctionGrid& grid,
                const OccupiedVoxels& occupied,
                const Daylight& daylight,
                const Eigen::Vector3d& eye,
                double gap_length_m,
                ArrivingLight& light);

}  // namespace relight
