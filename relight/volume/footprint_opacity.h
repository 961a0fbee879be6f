// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mean opacity of a voxel's footprint in each matte, and the k-th smallest over the
// views: the start of opacity estimation, "the minimum of the average opacity values in
// the respective images" [Reche04 §5]; k > 1 keeps voxels that a few bad mattes miss
// [Cabral11 §7.1].

#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/volume/brick_voxels.h"

#include <opencv2/core.hpp>

#include <span>
#include <string>
#include <vector>

namespace relight {

// One photograph, reduced to what tomography needs.
struct MatteView {
  std::string name;
  Camera camera;
  cv::Mat1f alpha;  // camera.height_px x width_px, in [0, 1]; 1 is tree.
};

struct FootprintOptions {
  int kth_smallest = 1;
  double least_alpha = 0.0;  // What is below takes no memory, as what is 0.
};

struct Footprints {
  BrickVoxels voxels;          // Those that are not empty, and others of their bricks.
  std::vector<float> opacity;  // voxels.Size() of them; 0 of the others.
};

// For each voxel of `box` (its bricks are not looked at): the k-th smallest over the
// views of the mean alpha in the square that the voxel's cube projects to. Beyond a
// frame's border the matte goes on as at the border where that is empty; where the tree
// is cut off there the view is passed over, as when the voxel is behind the camera. A
// voxel that fewer than k views know takes the smallest there is, one that none knows 0.
// Bricks are in the order of their first voxels. Throws OptionError, Cancelled;
// InputError when a matte's size is not its camera's, or alpha is not in [0, 1].
Footprints FootprintOpacity(const BrickVoxels& box,
                            std::span<const MatteView> views,
                            const FootprintOptions& options = {},
                            const Progress& progress = {});

// Throws InputError unless each matte has its camera's size and alpha in [0, 1].
void RequireUsable(std::span<const MatteView> views);

}  // namespace relight
