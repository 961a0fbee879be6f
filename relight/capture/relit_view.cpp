// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/relit_view.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/capture/sky_in_photo.h"
#include "relight/photo/read_photo.h"
#include "relight/scattering/ground_bounce.h"
#include "relight/scattering/hot_spot.h"
#include "relight/scattering/leaf_phase.h"
#include "relight/scattering/multiple_scattering.h"
#include "relight/sh/sky_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace relight {
namespace {

double Luminance(const cv::Vec3f& c) {
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

// Alpha-weighted mean luminance of the tree.
double MeanLuminance(const cv::Mat3f& colors, const cv::Mat1f& alpha) {
  double sum = 0, weight = 0;
  for (int row = 0; row < colors.rows; ++row) {
    for (int column = 0; column < colors.cols; ++column) {
      const double a = alpha(row, column);
      if (a <= 0) continue;
      sum += a * Luminance(colors(row, column));
      weight += a;
    }
  }
  return weight > 0 ? sum / weight : 0.0;
}

// The correction has learned from clear days: one sky of Preetham's for both hours.
bool SkyIsLearned(const RunLight& light) {
  return light.one_sky && light.target.model == SkyModel::kPreetham &&
         light.target.cloud == 0;
}

// Of the leaves, as green as the photo shows them, with `green` of that channel.
Eigen::Array3f LeafAlbedo(const PreparedView& view, double green) {
  const cv::Scalar mean = cv::mean(view.cut.foreground, view.cut.alpha > 0.5f);
  Eigen::Array3f albedo;
  for (int c = 0; c < 3; ++c) {
    const double share = mean[1] > 0 ? mean[c] / mean[1] : 1.0;
    albedo[c] = static_cast<float>(std::clamp(green * share, 0.0, 0.95));
  }
  return albedo;
}

}  // namespace

double ExposureStops(const std::string& exposure, double mean_ratio) {
  if (exposure == "same") return 0.0;
  if (exposure == "auto") return mean_ratio > 0 ? -std::log2(mean_ratio) : 0.0;
  return std::stod(exposure);
}

RelitView::RelitView(const PreparedView& view,
                     const CaptureOptions& options,
                     const SolarPosition& input,
                     std::optional<double> lowest_sun_rad)
    : view_(view),
      options_(options),
      input_(input),
      input_luminance_(MeanLuminance(view.cut.foreground, view.cut.alpha)) {
  static_cast<void>(TransportOf(options.light.method, options.transport));
  if (!options_.light.turbidity && view.air && view.air->sure) {
    options_.light.turbidity = view.air->turbidity;
  }
  light_ = LightOfRun(
      options_.light,
      std::min(input.elevation_rad, lowest_sun_rad.value_or(input.elevation_rad)),
      options_.transport.bounce);
}

Daylight RelitView::DaylightUnder(const SolarPosition& sun) const {
  return MakeDaylight(sun, light_.target);
}

Daylight RelitView::DaylightOfPhoto() const { return MakeDaylight(input_, light_.input); }

std::vector<std::string> RelitView::NotesOfPanoramas(const SolarPosition& target) const {
  std::vector<std::string> notes = PanoramaNotes(input_, light_.input);
  for (const std::string& note : PanoramaNotes(target, light_.target)) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) {
      notes.push_back(note);
    }
  }
  return notes;
}

std::vector<Eigen::Array3f> RelitView::Bounce(const Tree& tree,
                                              const Daylight& daylight) const {
  constexpr double kGroundAlbedo = 0.2;
  GroundShadowOptions options = options_.shadow;
  options.sky_directions = 64;  // The light of the ground is soft
  options.sky_level = 1;        // All of it counts
  const GroundShadow shadow =
      MakeGroundShadow(tree.grid, daylight, options, {}, tree.occluder.get());
  const double sine = std::max(0.0, daylight.sun_direction.z());
  const Eigen::Array3d unshadowed =
      options_.light.ground_albedo.value_or(kGroundAlbedo) / std::numbers::pi *
      (sine * daylight.sun_irradiance + HorizontalSkyIrradiance(daylight)).max(0.0);
  return GroundBounce(
      tree.grid,
      tree.occupied,
      unshadowed,
      [&](const Eigen::Vector2d& ground_m) -> Eigen::Array3f {
        const cv::Vec3f left = shadow.At(ground_m);
        return {left[0], left[1], left[2]};
      },
      options.ground_z_m);
}

ArrivingLight RelitView::Arriving(const Tree& tree, const Daylight& daylight) const {
  const ArrivingLightOptions transport =
      TransportOf(options_.light.method, options_.transport);
  ArrivingLight light = LightArriving(tree.grid,
                                      tree.occupied,
                                      tree.sky_transmittance,
                                      daylight,
                                      transport,
                                      tree.occluder.get());
  if (transport.bounce) light.indirect = Bounce(tree, daylight);
  if (transport.multiple_scattering > 0) {
    const std::vector<Eigen::Array3f> scattered =
        MultipleScattering(tree.grid,
                           tree.occupied,
                           light,
                           LeafAlbedo(view_, transport.multiple_scattering));
    for (std::size_t v = 0; v < scattered.size(); ++v) light.indirect[v] += scattered[v];
  }
  const Eigen::Vector3d eye = view_.camera.PositionInWorld();
  AddHotSpot(tree.grid, tree.occupied, daylight, eye, transport.gap_length_m, light);
  if (transport.leaf_transmission) {
    ScatterTowards(eye,
                   *transport.leaf_transmission,
                   tree.grid,
                   tree.occupied,
                   tree.sky_transmittance,
                   daylight,
                   light);
  }
  if (fit_) {
    const auto rest = static_cast<float>(std::exp(fit_->sky.log_value));
    for (Eigen::Array3f& color : light.sky) color *= rest;
    for (Eigen::Array3f& color : light.indirect) color *= rest;
  }
  return light;
}

const LightFit& RelitView::FitLight(const Progress& progress) {
  constexpr double kStep = 0.35;  // Of ln s; the prior's deviation is 0.3
  const Daylight daylight = DaylightOfPhoto();
  const auto scaled = [&](double log_scale) {
    Tree tree = view_.tree;
    for (float& sigma : tree.grid.sigma_per_m) {
      sigma *= static_cast<float>(std::exp(log_scale));
    }
    tree.sky_transmittance = ProjectTransmittance(tree.grid,
                                                  tree.occupied,
                                                  options_.sky_transmittance,
                                                  {},
                                                  tree.occluder.get(),
                                                  options_.transport.clumping);
    return tree;
  };
  const auto judged = [&](const Tree& tree) {
    const ArrivingLight light = Arriving(tree, daylight);
    const ViewLight seen = LightOfView(
        tree.grid, tree.occupied, light, light, view_.camera, view_.cut.alpha);
    return FitSky(
        ShadingOf(seen.images.lights[0], view_.cut.foreground, view_.cut.alpha));
  };
  std::vector<double> log_scales, costs;
  LightFit fit;
  for (int i = -2; i <= 2; ++i) {
    const SkyFit here = judged(i == 0 ? view_.tree : scaled(i * kStep));
    log_scales.push_back(i * kStep);
    costs.push_back(here.least);
    if (i == 0) fit.unfitted = here.unfitted;
    progress.Report((i + 3) / 6.0);
  }
  fit.density = FitScale(log_scales, costs);
  fitted_tree_ = scaled(fit.density.log_value);
  const SkyFit sky = judged(*fitted_tree_);
  fit.sky = sky.sky;
  fit.spread = sky.spread;
  fit_ = fit;
  return *fit_;
}

RelitTree RelitView::TreeUnder(const SolarPosition& target,
                               const Progress& progress,
                               bool with_features) {
  const bool ours = options_.light.method == Method::kDefault;
  if (options_.fit.fit_light && !fit_) FitLight(progress.Part(0, 0.25));
  const Tree& tree = fitted_tree_ ? *fitted_tree_ : view_.tree;
  RelitTree relit;
  const Daylight input_daylight = DaylightOfPhoto();
  const Daylight target_daylight = DaylightUnder(target);
  if (!input_light_) input_light_ = Arriving(tree, input_daylight);
  const ArrivingLight target_light = Arriving(tree, target_daylight);
  progress.Report(0.3);
  if (view_light_) {
    relit.light = UnderTarget(
        *view_light_, tree.grid, tree.occupied, target_light, progress.Part(0.3, 0.7));
  } else {
    relit.light = LightOfView(tree.grid,
                              tree.occupied,
                              *input_light_,
                              target_light,
                              view_.camera,
                              view_.cut.alpha,
                              {.smooth = ours, .ratio = {}},
                              progress.Part(0.3, 0.7));
    view_light_ = relit.light;
  }
  const bool corrects =
      ours && !options_.correction.no_correction && SkyIsLearned(light_);
  if (corrects || with_features) {
    if (!correction_view_) {
      correction_view_.emplace(
          tree.grid, tree.occupied, view_.camera, view_.cut.foreground, view_.cut.alpha);
    }
    relit.features = correction_view_->Under({*input_light_, input_daylight},
                                             {target_light, target_daylight});
  }
  relit.light.correction = {};
  if (corrects) {
    if (!model_) model_ = ReadCorrectionModel();
    relit.light.correction = PredictCorrection(
        *model_, relit.features, AngleBetween(input_.direction, target.direction));
  }
  relit.colors =
      ApplyRatio(relit.light, view_.cut.foreground, 1.0, progress.Part(0.7, 1));
  if (input_luminance_ > 0) {
    relit.mean_ratio = MeanLuminance(relit.colors, view_.cut.alpha) / input_luminance_;
  }
  return relit;
}

GroundShadow RelitView::ShadowOnGround(const Daylight& daylight) const {
  return MakeGroundShadow(
      view_.tree.grid, daylight, options_.shadow, {}, view_.tree.occluder.get());
}

const cv::Mat1f& RelitView::SkyOfPhoto() {
  if (!sky_.empty()) return sky_;
  const cv::Mat1f ends = SkyEnds(view_.photo.pixels, view_.cut.alpha);
  sky_.create(view_.photo.pixels.size());
  sky_.forEach([&](float& share, const int* at) {
    share = std::clamp(ends(at[1]) - static_cast<float>(at[0]), 0.0f, 1.0f);
  });
  return sky_;
}

const PhotoShadow& RelitView::ShadowOfPhoto(const Progress& progress) {
  if (!photo_shadow_) {
    photo_shadow_ = ShadowInPhoto(view_.photo.pixels,
                                  cv::max(view_.cut.alpha, SkyOfPhoto()),
                                  ShadowOnGround(DaylightOfPhoto()),
                                  view_.camera,
                                  options_.old_shadow,
                                  progress);
  }
  return *photo_shadow_;
}

bool RelitView::GroundMoves() const {
  return view_.ground_fault.empty() && view_.photo.alpha.empty();
}

cv::Mat3f RelitView::ShadowUnder(const SolarPosition& target, const Progress& progress) {
  if (!view_.ground_fault.empty()) throw InputError(view_.ground_fault);
  cv::Mat3f shadow = ShadowImage(
      ShadowOnGround(DaylightUnder(target)), view_.camera, progress.Part(0, 0.5));
  const double turns = DegFromRad(AngleBetween(input_.direction, target.direction));
  const auto own = static_cast<float>(std::exp(-turns * turns));
  if (!GroundMoves() || own < 1e-3f || !light_.one_sky) return shadow;
  const PhotoShadow& in_photo = ShadowOfPhoto(progress.Part(0.5, 1));
  return shadow + own * (in_photo.seen - in_photo.cast);
}

cv::Mat3f RelitView::GroundUnder(const SolarPosition& target, const Progress& progress) {
  if (!GroundMoves()) return view_.photo.pixels;
  const PhotoShadow& input = ShadowOfPhoto(progress.Part(0, 0.5));
  cv::Mat3f ratio = GroundRatio(input,
                                ShadowOnGround(DaylightUnder(target)),
                                view_.camera,
                                AngleBetween(input_.direction, target.direction),
                                options_.old_shadow,
                                progress.Part(0.5, 1));
  const cv::Mat1f& sky = SkyOfPhoto();
  ratio.forEach([&](cv::Vec3f& r, const int* at) {
    const float share = sky(at[0], at[1]);
    if (share > 0) r += share * (cv::Vec3f::all(1) - r);
  });
  return ReshadowedPhoto(
      view_.photo.pixels, view_.cut.alpha, view_.cut.foreground, ratio);
}

cv::Mat3f RelitView::Whole(const cv::Mat3f& ground, const RelitTree& tree) const {
  const cv::Mat1f& alpha = view_.cut.alpha;
  Require(ground.size() == alpha.size() && tree.colors.size() == alpha.size(),
          "pictures of the photo's size");
  cv::Mat3f whole(ground.size());
  ParallelRanges(whole.rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < whole.cols; ++column) {
        const float a = alpha(row, column);
        cv::Vec3f color = ground(row, column);
        if (a > 0) {
          color += a * (tree.colors(row, column) - view_.cut.foreground(row, column));
          for (int c = 0; c < 3; ++c) color[c] = std::max(0.0f, color[c]);
        }
        whole(row, column) = color;
      }
    }
  });
  return whole;
}

cv::Mat3f ReadBackdrop(const std::filesystem::path& file,
                       cv::Size size,
                       const ReadPhotoOptions& options) {
  cv::Mat3f backdrop = ReadPhoto(file, options).pixels;
  if (backdrop.size() == size) return backdrop;
  throw InputError(file.string() + ": is " + std::to_string(backdrop.cols) + " x " +
                   std::to_string(backdrop.rows) + " pixels, the photo " +
                   std::to_string(size.width) + " x " + std::to_string(size.height) +
                   "; give a backdrop of the photo's size");
}

}  // namespace relight
