// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that goes from leaf to leaf. Leaves that scatter the share a of the light E that
// arrives, evenly to all sides, light each other by
//
//   E_0 = sun + sky + indirect
//   E_n+1(u) = a / (4 pi) integral over the sphere and the way s of
//              tau(u, u + s w) sigma(u + s w) E_n(u + s w) ds dw                 (S12)
//
// The sum of all E_n from n = 1 on is added, to where an order is below 1/1000 of the
// light. With a = 1 nothing is lost: under the same radiance L from everywhere the sum
// with E_0 is 4 pi L at every leaf, however dense the tree.
//
// The light of (S12) is soft: it is found on voxels so large that 24 of them are the
// grid's longest side, of the mean extinction and the mean light of their leaves, along
// 128 directions from their centres, and interpolated between these.

#include "relight/scattering/arriving_light.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <vector>

namespace relight {

// The sum of (S12) without E_0 for each non-empty voxel; `albedo`: a of each channel, in
// [0, 1]. The result does not depend on the threads.
std::vector<Eigen::Array3f> MultipleScattering(const ExtinctionGrid& grid,
                                               const OccupiedVoxels& occupied,
                                               const ArrivingLight& light,
                                               const Eigen::Array3f& albedo);

}  // namespace relight
