// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that level ground sends up into a tree: the ground's radiance at the point p that
// a way from the voxel u meets, over all ways down,
//
//   indirect(u) = sum over directions d of w tau(u, d) L s(p(u, d))              (S10)
//
// L is the radiance of ground that nothing shades, A (S sin e + E_h) / pi for the albedo
// A under the sun S at the elevation e and the sky's E_h, and s what the tree leaves of
// its light (relight/composite/ground_shadow.h): unshadowed, the ground below a crown
// would send far too much. The ground scatters evenly; the tree's leaves send nothing
// down to it.

#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace relight {

// s of (S10) at a point of the ground (ENU), each channel in [0, 1]; from any thread.
using ShareOfGroundLight = std::function<Eigen::Array3f(const Eigen::Vector2d& ground_m)>;

// For each non-empty voxel, in the unit of `unshadowed` times sr; 0 for voxels below the
// ground. The result does not depend on the threads.
std::vector<Eigen::Array3f> GroundBounce(const ExtinctionGrid& grid,
                                         const OccupiedVoxels& occupied,
                                         const Eigen::Array3d& unshadowed,
                                         const ShareOfGroundLight& share,
                                         double ground_z_m = 0.0);

}  // namespace relight
