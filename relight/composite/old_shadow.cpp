// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/old_shadow.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace relight {
namespace {

constexpr int kRowsAtOnce = 16;

float Luminance(const cv::Vec3f& c) {
  return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

// Values known with some weight, spread to where there is none: from each level of a
// pyramid as much as the level below lacks.
cv::Mat1f Spread(const cv::Mat1f& weighted, const cv::Mat1f& weight) {
  constexpr float kEnough = 0.25f;
  if (std::min(weight.rows, weight.cols) <= 2) {
    const double sum = cv::sum(weight)[0];
    const double mean = sum > 0 ? cv::sum(weighted)[0] / sum : 0.0;
    return cv::Mat1f(weight.size(), static_cast<float>(mean));
  }
  cv::Mat1f weighted_below, weight_below, filled;
  cv::pyrDown(weighted, weighted_below);
  cv::pyrDown(weight, weight_below);
  cv::pyrUp(Spread(weighted_below, weight_below), filled, weight.size());
  for (int row = 0; row < filled.rows; ++row) {
    for (int column = 0; column < filled.cols; ++column) {
      const float w = weight(row, column);
      const float known = std::min(1.f, w / kEnough);
      if (w > 0) {
        filled(row, column) += known * (weighted(row, column) / w - filled(row, column));
      }
    }
  }
  return filled;
}

// B of (G6): the ground's luminance as it is without a shadow, smooth.
cv::Mat1f GroundLevel(const cv::Mat3f& photo,
                      const cv::Mat1f& alpha,
                      const cv::Mat1f& sun_left,
                      const cv::Mat3f& shadow,
                      const cv::Mat1b& ground) {
  cv::Mat1f weighted(photo.size()), weight(photo.size());
  for (int row = 0; row < photo.rows; ++row) {
    for (int column = 0; column < photo.cols; ++column) {
      const float clear =
          std::max(0.f, 10 * sun_left(row, column) - 9) * (1 - alpha(row, column));
      const float w = ground(row, column) != 0 ? clear * clear : 0.f;
      weight(row, column) = w;
      weighted(row, column) = w * Luminance(photo(row, column)) /
                              std::max(0.05f, Luminance(shadow(row, column)));
    }
  }
  // Grass and gravel are finer than a level may be: start from means over a few pixels
  constexpr int kFinest_px = 256;
  cv::Mat1f level, small_weighted = weighted, small_weight = weight;
  while (std::max(small_weight.rows, small_weight.cols) > kFinest_px) {
    cv::Mat1f half_weighted, half_weight;
    cv::pyrDown(small_weighted, half_weighted);
    cv::pyrDown(small_weight, half_weight);
    small_weighted = half_weighted;
    small_weight = half_weight;
  }
  cv::resize(
      Spread(small_weighted, small_weight), level, photo.size(), 0, 0, cv::INTER_LINEAR);
  return level;
}

}  // namespace

// T' = clamp(((I / B - d) / (l - d) - u) / (v - u), 0, 1)                       (G6)
PhotoShadow ShadowInPhoto(const cv::Mat3f& photo,
                          const cv::Mat1f& alpha,
                          const GroundShadow& input,
                          const Camera& camera,
                          const OldShadowOptions& options,
                          const Progress& progress) {
  CheckFields(options);
  Require(photo.rows == camera.height_px && photo.cols == camera.width_px &&
              alpha.size() == photo.size(),
          "a photo and its matte of the camera's size");
  const cv::Mat3f shadow = ShadowImage(input, camera, progress.Part(0, 0.4));
  if (options.volume_only || input.sun.values.empty()) return {shadow, shadow};

  // T alone, and where there is ground at all
  GroundShadow sun_alone = input;
  sun_alone.sun_share.setOnes();
  std::vector<cv::Mat1f> channels;
  cv::split(ShadowImage(sun_alone, camera, progress.Part(0.4, 0.7)), channels);
  const cv::Mat1f sun_left = channels[0];
  cv::Mat1b ground(photo.size(), 0);
  const double height_m = input.ground_z_m - camera.PositionInWorld().z();
  ParallelRanges(photo.rows, kRowsAtOnce, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < photo.cols; ++column) {
        const double z = camera.RayInWorld({column + 0.5, row + 0.5}).z();
        ground(row, column) = z * height_m > 0 ? 1 : 0;
      }
    }
  });
  progress.Report(0.75);
  const cv::Mat1f level = GroundLevel(photo, alpha, sun_left, shadow, ground);

  // Near by: within 1 % of the picture's height, for the volume errs by about a voxel
  cv::Mat1f least_sun_near;
  const int reach_px = 1 + photo.rows / 100;
  cv::erode(
      sun_left,
      least_sun_near,
      cv::getStructuringElement(cv::MORPH_RECT, {2 * reach_px + 1, 2 * reach_px + 1}));

  constexpr float kShade = 0.05f, kSun = 0.85f;
  cv::Mat3f seen = shadow.clone();
  for (int row = 0; row < photo.rows; ++row) {
    for (int column = 0; column < photo.cols; ++column) {
      const float near_shadow =
          std::clamp(10 * (1 - least_sun_near(row, column)), 0.f, 1.f);
      const float b = level(row, column);
      if (ground(row, column) == 0 || near_shadow <= 0 || !(b > 0)) continue;
      cv::Vec3f share(input.sun_share[0], input.sun_share[1], input.sun_share[2]);
      const cv::Vec3f shade = shadow(row, column) - sun_left(row, column) * share;
      const float d = Luminance(shade), range = Luminance(share);
      const float i = Luminance(photo(row, column)) / b;
      const float sun =
          std::clamp(((i - d) / range - kShade) / (kSun - kShade), 0.f, 1.f);
      const float taken =
          sun_left(row, column) + near_shadow * (sun - sun_left(row, column));
      for (int c = 0; c < 3; ++c) {
        seen(row, column)[c] = std::clamp(shade[c] + taken * share[c], 0.f, 1.f);
      }
    }
  }
  progress.Report(1.0);
  return {shadow, seen};
}

// r = (t + e) / (i + e),   e = i max(0, f / Y(i) - 1)                            (G4)
//
// Black has no colour of its own: e tends to a grey f there.
cv::Mat3f GroundRatio(const PhotoShadow& input,
                      const GroundShadow& target,
                      const Camera& camera,
                      double sun_turn_rad,
                      const OldShadowOptions& options,
                      const Progress& progress) {
  CheckFields(options);
  const double turns = DegFromRad(sun_turn_rad);
  const auto flecks = static_cast<float>(1 - std::exp(-turns * turns));
  const auto f = static_cast<float>(options.floor);
  cv::Mat3f ratio(input.cast.size());
  ParallelRanges(
      ratio.rows,
      kRowsAtOnce,
      [&](int begin, int end) {
        const cv::Mat3f after = ShadowRows(target, camera, begin, end);
        for (int row = begin; row < end; ++row) {
          for (int column = 0; column < ratio.cols; ++column) {
            const cv::Vec3f& cast = input.cast(row, column);
            const cv::Vec3f i = cast + flecks * (input.seen(row, column) - cast);
            constexpr float kBlack = 1e-3f, kLeast = 1e-6f;
            const float lift = std::max(0.f, f / (Luminance(i) + kBlack) - 1);
            for (int c = 0; c < 3; ++c) {
              const float e = lift * (i[c] + kBlack) + kLeast;
              ratio(row, column)[c] = (after(row - begin, column)[c] + e) / (i[c] + e);
            }
          }
        }
      },
      progress);
  return ratio;
}

// I' = I + (r - 1) max(0, I - a F)                                              (G5)
cv::Mat3f ReshadowedPhoto(const cv::Mat3f& photo,
                          const cv::Mat1f& alpha,
                          const cv::Mat3f& foreground,
                          const cv::Mat3f& ratio) {
  Require(alpha.size() == photo.size() && foreground.size() == photo.size() &&
              ratio.size() == photo.size(),
          "images of one size");
  cv::Mat3f result = photo.clone();
  ParallelRanges(photo.rows, kRowsAtOnce, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < photo.cols; ++column) {
        const float a = std::clamp(alpha(row, column), 0.f, 1.f);
        for (int c = 0; c < 3; ++c) {
          const float tree = a > 0 ? a * foreground(row, column)[c] : 0.f;
          const float ground = std::max(0.f, photo(row, column)[c] - tree);
          result(row, column)[c] += (ratio(row, column)[c] - 1) * ground;
        }
      }
    }
  });
  return result;
}

}  // namespace relight
