// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/mean_light.h"

#include "relight/base/error.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

// Sums of 2 x 2 pixels; an odd last row or column stands alone.
template <class Image>
Image HalfSums(const Image& image) {
  cv::Mat padded, half;
  cv::copyMakeBorder(
      image, padded, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_CONSTANT);
  cv::resize(padded, half, {padded.cols / 2, padded.rows / 2}, 0, 0, cv::INTER_AREA);
  return Image(half * 4.0);
}

// N of (R2): at each level the light of the level's own rays, and of the coarser level
// where they weigh little.
cv::Mat3f Neighbours(const cv::Mat3f& sums, const cv::Mat1f& weights) {
  constexpr float kOwn =
      0.05f;  // Weight at which own rays count as much as the coarser level
  cv::Mat3f coarser(sums.size(), cv::Vec3f::all(0));
  if (sums.rows > 1 || sums.cols > 1) {
    const cv::Mat3f half = Neighbours(HalfSums(sums), HalfSums(weights));
    cv::Mat up;
    cv::resize(half, up, {2 * half.cols, 2 * half.rows}, 0, 0, cv::INTER_LINEAR);
    coarser = up(cv::Rect(0, 0, sums.cols, sums.rows));
  } else if (weights(0, 0) > 0) {
    coarser(0, 0) = sums(0, 0) / weights(0, 0);
  }
  cv::Mat3f light(sums.size());
  for (int row = 0; row < sums.rows; ++row) {
    for (int column = 0; column < sums.cols; ++column) {
      light(row, column) = (sums(row, column) + kOwn * coarser(row, column)) /
                           (weights(row, column) + kOwn);
    }
  }
  return light;
}

}  // namespace

cv::Mat3f MeanLight(const cv::Mat3f& irradiance,
                    const cv::Mat1f& weight,
                    const cv::Mat1b& inside,
                    const MeanLightOptions& options) {
  Require(irradiance.size() == weight.size() && weight.size() == inside.size(),
          "irradiance, weight and matte have one size");
  cv::Mat3f sums(irradiance.size(), cv::Vec3f::all(0));
  cv::Mat1f weights(weight.size(), 0.0f);
  irradiance.copyTo(sums, inside);
  weight.copyTo(weights, inside);
  if (options.smoothing_px > 0) {
    cv::GaussianBlur(sums, sums, {}, options.smoothing_px, 0, cv::BORDER_CONSTANT);
    cv::GaussianBlur(weights, weights, {}, options.smoothing_px, 0, cv::BORDER_CONSTANT);
  }
  const cv::Mat3f neighbours = Neighbours(sums, weights);

  cv::Mat3f light(sums.size(), cv::Vec3f::all(0));
  const auto full = static_cast<float>(options.full_weight);
  for (int row = 0; row < light.rows; ++row) {
    for (int column = 0; column < light.cols; ++column) {
      if (inside(row, column) == 0) continue;
      const float w = weights(row, column);
      const float a = std::min(1.0f, w / full);
      cv::Vec3f& m = light(row, column);
      if (w > 0) m = a * sums(row, column) / w;
      if (a < 1) m += (1 - a) * neighbours(row, column);
    }
  }
  return light;
}

}  // namespace relight
