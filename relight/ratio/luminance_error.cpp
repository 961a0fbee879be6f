// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/luminance_error.h"

#include <algorithm>
#include <cmath>

namespace relight {

cv::Mat1f LuminanceError(const RelightingPictures& pictures,
                         const RelightingScore& score,
                         const RelightingScoreOptions& options) {
  const cv::Mat1b inside = ScoredInside(pictures);
  const cv::Vec3d luminance(0.2126, 0.7152, 0.0722);
  const cv::Vec3d gain(score.result.gain[0], score.result.gain[1], score.result.gain[2]);
  cv::Mat1f error(inside.size(), 0.0f);
  for (int y = 0; y < error.rows; ++y) {
    for (int x = 0; x < error.cols; ++x) {
      if (inside(y, x) == 0) continue;
      const cv::Vec3d result = pictures.result.color(y, x);
      const cv::Vec3d truth = pictures.truth.color(y, x);
      // D = (Y(g result) - Y(truth)) / p                                        (E7)
      const double difference =
          luminance.dot(gain.mul(result) * (1.0 / options.scale) - truth);
      error(y, x) = static_cast<float>(difference / score.peak);
    }
  }
  return error;
}

cv::Mat3b LuminanceErrorPicture(const cv::Mat1f& error, const cv::Mat1b& inside) {
  const cv::Vec3d white(245, 245, 245), red(178, 24, 43), blue(33, 102, 172);
  cv::Mat3b picture(error.size(), cv::Vec3b(48, 48, 46));
  for (int y = 0; y < error.rows; ++y) {
    for (int x = 0; x < error.cols; ++x) {
      if (inside(y, x) == 0) continue;
      const double value = std::clamp(error(y, x) / kFullColorError, -1.0, 1.0);
      const cv::Vec3d& end = value > 0.0 ? red : blue;
      const cv::Vec3d color = white + std::abs(value) * (end - white);
      for (int c = 0; c < 3; ++c)
        picture(y, x)[c] = static_cast<uchar>(std::lround(color[c]));
    }
  }
  return picture;
}

}  // namespace relight
