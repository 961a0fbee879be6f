// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the tree is: the box around all that no matte calls empty.

#include "relight/base/progress.h"
#include "relight/volume/footprint_opacity.h"

#include <Eigen/Geometry>

#include <span>

namespace relight {

struct HullOptions {
  int kth_smallest = 1;       // k - 1 mattes may miss a part (footprint_opacity.h).
  double least_alpha = 0.02;  // Footprints below are empty.
};

// Box in the world of the voxels whose k-th smallest footprint is at least `least_alpha`,
// found coarse to fine, grown by one fine voxel. Starts from the sphere that the mattes'
// outlines leave around the point nearest to the rays through their centres.
// Throws InputError with the remedy when a matte is empty or no voxel remains.
Eigen::AlignedBox3d HullBounds(std::span<const MatteView> views,
                               const HullOptions& options = {},
                               const Progress& progress = {});

}  // namespace relight
