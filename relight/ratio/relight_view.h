// SPDX-License-Identifier: Apache-2.0
#pragma once

// One view of the tree, relit: light images of both hours at the resolution at which the
// voxels can show anything, their ratio at full resolution, applied to the tree's
// colours.

#include "relight/base/progress.h"
#include "relight/ratio/correction.h"
#include "relight/ratio/mean_light.h"
#include "relight/ratio/ratio_image.h"
#include "relight/scattering/single_scattering.h"

#include <opencv2/core.hpp>

#include <optional>

namespace relight {

struct RelightViewOptions {
  double pixels_per_voxel = 4.0;  // Light images are no finer than this.
  bool smooth = false;  // Blur light by half a voxel even where it is computed at
                        // the photo's own resolution.
  RatioOptions ratio = {};
};

// Light of both hours over one view, at the lights' own resolution.
struct ViewLight {
  Camera camera;                        // Of these images: the view's, perhaps resized.
  ScatteringImages images;              // lights[0]: input, lights[1]: target.
  cv::Mat1b inside;                     // The matte's pixels, and
  double smoothing_px = 0.0;            // their light's blur, at this resolution.
  bool is_smaller = false;              // Than the photo.
  cv::Mat3f input_light, target_light;  // (R2); outside the matte 0, or continued when
                                        // smaller.
  cv::Vec3f floor;                      // Of the ratio.
  Correction correction;                // Times its factor; without patches: none.
  double weak_share =
      0.0;  // Pixels of the matte (alpha > 0.5) whose ray meets no volume.
};

// `alpha` has the camera's size. Throws Cancelled.
ViewLight LightOfView(const ExtinctionGrid& grid,
                      const OccupiedVoxels& occupied,
                      const ArrivingLight& input,
                      const ArrivingLight& target,
                      const Camera& camera,
                      const cv::Mat1f& alpha,
                      const RelightViewOptions& options = {},
                      const Progress& progress = {});

// The same view under another target; all that belongs to the input is kept. The same
// bits as LightOfView's. Throws Cancelled.
ViewLight UnderTarget(const ViewLight& light,
                      const ExtinctionGrid& grid,
                      const OccupiedVoxels& occupied,
                      const ArrivingLight& target,
                      const Progress& progress = {});

// The ratio for rows [row_begin, row_end) of the view at its full size.
cv::Mat3f RatioRows(const ViewLight& light,
                    cv::Size full_size,
                    int row_begin,
                    int row_end);

// `colors` (linear, straight) times the ratio times `gain`, in bands of rows; NaN and
// negative colours become 0.
cv::Mat3f ApplyRatio(const ViewLight& light,
                     const cv::Mat3f& colors,
                     double gain = 1.0,
                     const Progress& progress = {});

}  // namespace relight
