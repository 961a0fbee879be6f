// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mean opacity of a voxel's footprint in each matte, and the k-th smallest over the
// views: the start of opacity estimation, "the minimum of the average opacity values in
// the respective images" [Reche04 §5]; k > 1 keeps voxels that a few bad mattes miss
// [Cabral11 §7.1].

#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/volume/extinction_grid.h"

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

// For each voxel of `grid` (its extinctions are not looked at): the k-th smallest over
// the views of the mean alpha in the square that the voxel's cube projects to. Beyond a
// frame's border the matte goes on as at the border where that is empty; where the tree
// is cut off there the view is passed over, as when the voxel is behind the camera. A
// voxel that fewer than k views know takes the smallest there is, one that none knows 0.
// Throws InputError when a matte's size is not its camera's, or alpha is not in [0, 1].
std::vector<float> FootprintOpacity(const ExtinctionGrid& grid,
                                    std::span<const MatteView> views,
                                    int kth_smallest,
                                    const Progress& progress = {});

// Throws InputError unless each matte has its camera's size and alpha in [0, 1].
void RequireUsable(std::span<const MatteView> views);

}  // namespace relight
