// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/ratio_image.h"

#include "relight/base/error.h"

#include <algorithm>

namespace relight {

cv::Vec3f RatioFloor(const cv::Mat3f& input_light, const RatioOptions& options) {
  cv::Vec3d sum(0, 0, 0);
  std::size_t count = 0;
  for (const cv::Vec3f& light : input_light) {
    if (light[0] + light[1] + light[2] <= 0) continue;
    sum += cv::Vec3d(light);
    ++count;
  }
  if (count == 0) return {0, 0, 0};
  return cv::Vec3f(sum * (options.floor / static_cast<double>(count)));
}

cv::Mat3f RatioImage(const cv::Mat3f& input_light,
                     const cv::Mat3f& target_light,
                     const cv::Vec3f& floor) {
  Require(input_light.size() == target_light.size(), "both lights have one size");
  cv::Mat3f ratio(input_light.size());
  for (int row = 0; row < ratio.rows; ++row) {
    for (int column = 0; column < ratio.cols; ++column) {
      const cv::Vec3f& in = input_light(row, column);
      const cv::Vec3f& target = target_light(row, column);
      for (int c = 0; c < 3; ++c) {
        const float divisor = std::max(in[c], floor[c]);
        ratio(row, column)[c] = in[c] + target[c] > 0 && divisor > 0
                                    ? std::max(target[c], floor[c]) / divisor
                                    : 1.0f;
      }
    }
  }
  return ratio;
}

}  // namespace relight
