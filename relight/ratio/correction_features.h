// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the stages know about a view under two lights, averaged over patches of the crown:
// the input of the learned correction (correction.h), by one code for training and use.
//
// A patch is a cell of a grid over the matte's box, 1/40 of the crown's height. Means
// over a patch are of two sizes: "fine" is blurred by a Gaussian of 0.8 cells, "wide" by
// one of 3. Photo figures weigh each pixel by alpha, volume figures each sample u of a
// view ray by its share tau sigma du, as (R1) does. Lengths are relative to the crown, so
// that a tree whose size is only assumed gives the same figures; all are even under a
// mirrored scene.

#include "relight/cameras/camera.h"
#include "relight/scattering/arriving_light.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <opencv2/core.hpp>

#include <optional>
#include <string>
#include <vector>

namespace relight {

// Where the patches are in the picture.
struct PatchGrid {
  int columns = 0, rows = 0;
  double left_px = 0, top_px = 0;  // Of the first patch's outer corner.
  double patch_px = 0;             // Edge of a patch.
};

struct CorrectionFeatures {
  PatchGrid grid;
  cv::Mat1f cover;         // rows x columns: share of each patch that is tree, in [0, 1].
  cv::Mat1f volume_share;  // Mean of 1 - tau of the patch's rays, in [0, 1].
  std::vector<cv::Mat1f> planes;  // One per name, finite everywhere.
};

// Names of the planes, in their order. A change here asks for new weights.
const std::vector<std::string>& CorrectionFeatureNames();

// How the photo's luminance varies over the crown.
struct PhotoContrast {
  // Mean over patches of the standard deviation inside one, over its mean: high where
  // leaves glisten, or catch the sun singly.
  double inside_patches = 0;
  // Standard deviation of ln(fine / wide mean): high where leaves, or what they are
  // clustered in, are larger than a patch.
  double between_patches = 0;
};
// Patches count by their cover; nothing without patches.
std::optional<PhotoContrast> ContrastOfPhoto(const CorrectionFeatures& features);

// One hour's light as the stages computed it.
struct FeatureLight {
  const ArrivingLight& arriving;
  const Daylight& daylight;
};

// What belongs to the view, whatever the hours.
class CorrectionView {
 public:
  // `colors` linear and straight, `alpha` in [0, 1], both of the camera's size. Keeps
  // references to `grid` and `occupied`. A matte without any tree gives no patches.
  CorrectionView(const ExtinctionGrid& grid,
                 const OccupiedVoxels& occupied,
                 const Camera& camera,
                 const cv::Mat3f& colors,
                 const cv::Mat1f& alpha);

  // The result does not depend on the threads.
  CorrectionFeatures Under(const FeatureLight& input, const FeatureLight& target) const;

 private:
  struct PhotoSums {
    cv::Mat1f alpha, red, green, blue, square, dark, bright;
  };
  // Of the crown around a voxel, by a coarse grid that is blurred.
  struct Surroundings {
    Eigen::Vector3f outward_near, outward_far;  // Unit vectors, or 0 inside a plain.
    float near_per_m = 0, far_per_m = 0;
  };

  const ExtinctionGrid& extinction_;
  const OccupiedVoxels& occupied_;
  Camera camera_;
  PatchGrid patches_;
  PhotoSums photo_;
  double mean_luminance_ = 0;
  Eigen::Vector3d crown_center_ = Eigen::Vector3d::Zero();
  double crown_radius_m_ = 1, crown_low_m_ = 0, crown_height_m_ = 1;
  double mean_extinction_per_m_ = 1;        // Of the occupied voxels.
  std::vector<Surroundings> surroundings_;  // Per occupied voxel.
};

}  // namespace relight
