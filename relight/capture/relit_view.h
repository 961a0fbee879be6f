// SPDX-License-Identifier: Apache-2.0
#pragma once

// A prepared view under the sun and sky of one hour after another. What belongs to the
// photo's own hour is computed once, so that a further hour is cheap.

#include "relight/base/progress.h"
#include "relight/capture/prepared_view.h"
#include "relight/composite/ground_shadow.h"
#include "relight/composite/old_shadow.h"
#include "relight/ratio/correction.h"
#include "relight/ratio/light_fit.h"
#include "relight/ratio/relight_view.h"
#include "relight/sky/daylight.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// The tree's colours under another hour.
struct RelitTree {
  cv::Mat3f colors;             // Linear, straight, of the photo's size.
  ViewLight light;              // Of both hours.
  CorrectionFeatures features;  // Of both hours; without planes where none were wanted.
  double mean_ratio = 1.0;      // Of the mean luminance inside the matte.
};

// A photo to put the tree on. Throws InputError when its size is another.
cv::Mat3f ReadBackdrop(const std::filesystem::path& file,
                       cv::Size size,
                       const ReadPhotoOptions& options);

// Stops of an exposure "same", "auto" (the tree as bright as in the photo) or a number of
// them, as RequireExposure takes them.
double ExposureStops(const std::string& exposure, double mean_ratio);

class RelitView {
 public:
  // Keeps a reference to `view`, which is not to change. `lowest_sun_rad`: of all targets
  // (light_options.h); left out, the photo's own. Throws OptionError.
  RelitView(const PreparedView& view,
            const CaptureOptions& options,
            const SolarPosition& input,
            std::optional<double> lowest_sun_rad = {});

  // `with_features`: what the learned correction reads, even where it is not used. Throws
  // Cancelled.
  RelitTree TreeUnder(const SolarPosition& target,
                      const Progress& progress = {},
                      bool with_features = false);

  // What the tree leaves of the light on the ground; where the photo shows its own ground
  // and the target is its own hour, as the photo shows it (old_shadow.h). RGB of the
  // photo's size, in [0, 1]. Throws InputError when there is no ground.
  cv::Mat3f ShadowUnder(const SolarPosition& target, const Progress& progress = {});

  // The photo with the old shadow taken off its ground, and the new one cast. What is
  // seen to be sky is no ground, wherever the camera's horizon is. Without a ground, and
  // for a photo with alpha, the photo as it is.
  cv::Mat3f GroundUnder(const SolarPosition& target, const Progress& progress = {});

  // The tree over a picture of its size that shows the tree as it was: P + a (F' - F), so
  // that an unchanged tree leaves every pixel as it is.
  cv::Mat3f Whole(const cv::Mat3f& ground, const RelitTree& tree) const;

  bool GroundMoves() const;  // GroundUnder changes the photo.
  // Of a wanted hour, and of the photo's own.
  Daylight DaylightUnder(const SolarPosition& sun) const;
  Daylight DaylightOfPhoto() const;

  // How panoramas are taken for the photo's hour and a wanted one (daylight.h).
  std::vector<std::string> NotesOfPanoramas(const SolarPosition& target) const;

  // What the photo's own shading says, once TreeUnder has asked it (--fit-light).
  const std::optional<LightFit>& fit() const { return fit_; }

  // The skies of the run, with the turbidity that is used.
  const RunLight& light() const { return light_; }

 private:
  std::vector<Eigen::Array3f> Bounce(const Tree& tree, const Daylight& daylight) const;
  ArrivingLight Arriving(const Tree& tree, const Daylight& daylight) const;
  const LightFit& FitLight(const Progress& progress);
  GroundShadow ShadowOnGround(const Daylight& daylight) const;
  const PhotoShadow& ShadowOfPhoto(const Progress& progress);
  const cv::Mat1f& SkyOfPhoto();

  const PreparedView& view_;
  CaptureOptions options_;
  SolarPosition input_;
  RunLight light_;
  double input_luminance_ = 0.0;  // Of the tree, the mean.
  std::optional<LightFit> fit_;
  std::optional<Tree> fitted_tree_;  // Of the density that was fitted.
  std::optional<ArrivingLight> input_light_;
  std::optional<ViewLight> view_light_;  // Of any target: the input's part is kept.
  std::optional<CorrectionView> correction_view_;
  std::optional<CorrectionModel> model_;
  std::optional<PhotoShadow> photo_shadow_;
  cv::Mat1f sky_;  // Share of each pixel, once it is asked for.
};

}  // namespace relight
