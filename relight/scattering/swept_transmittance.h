// SPDX-License-Identifier: Apache-2.0
#pragma once

// Transmittance from every non-empty voxel of a grid along many directions, projected on
// functions of the direction, in one add or two for each voxel and direction instead of a
// ray's whole way:
//
//   p_c(u) = sum over directions d of b_c(d) tau(u, d)                    (S5)
//
// For one direction, parallel lines one voxel apart fill the grid, and each voxel is met
// by exactly one of them on the plane through its centre that is most across the
// direction. Plane by plane from where the direction leaves the grid, each line carries
// the optical depth A behind it. What it adds in a plane is its exact length in each of
// the at most five voxels that it crosses there, the same for all lines of the plane; of
// its own plane a voxel has the half edge l / 2 from its centre, l = cell / max |d_a|:
//
//   D(u) = A + sigma(u) l / 2,   A <- A + sum of lengths sigma            (S6)
//
// so that nothing is interpolated and no depth is blurred on its way: tau(u, d) =
// exp(-D(u)) is that of an exact ray which leaves the voxel's plane at most half a voxel
// off the way from the centre (transmittance.h), along each axis; over many directions
// evenly to all sides. Counted from the outermost plane t = 0, in voxel edges from the
// voxel's lower corner, the line is at fract(1/2 - t d_a / |d_s|) in the voxel's middle,
// along the two axes a that are not the planes' s.
//
// Time grows with the rows' extents of non-empty voxels, not with the length of rays.

#include "relight/base/progress.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <functional>
#include <span>
#include <vector>

namespace relight {

// p_c of (S5): result[c][voxel], voxels in the order of `occupied`. `basis` has as many
// values a direction as there are functions: basis[d * functions + c]. `direction`: unit
// vectors, away from the voxel. `further`, where given, adds what else is on the way
// along a direction to the optical depths of the voxels, from any thread. The result does
// not depend on the threads. `clumping`: k of (S9), arriving_light.h, of the grid's own
// depths. Throws Cancelled.
using FurtherDepth =
    std::function<void(const Eigen::Vector3d& direction, std::span<float> depth)>;
std::vector<std::vector<float>> ProjectSwept(const ExtinctionGrid& grid,
                                             const OccupiedVoxels& occupied,
                                             std::span<const Eigen::Vector3d> directions,
                                             std::span<const float> basis,
                                             const Progress& progress = {},
                                             const FurtherDepth& further = {},
                                             double clumping = 0.0);

// tau(u, direction) of (S6) for each non-empty voxel.
std::vector<float> TransmittanceSwept(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const Eigen::Vector3d& direction);

}  // namespace relight
