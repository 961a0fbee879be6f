// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/frame_preview.h"

#include "relight/base/parallel.h"
#include "relight/photo/color.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

constexpr float kGrey = 0.6f;  // Linear; 0.8 of white on a screen.

cv::Size Fitted(cv::Size size, cv::Size into) {
  const double scale = std::min({1.0,
                                 static_cast<double>(into.width) / size.width,
                                 static_cast<double>(into.height) / size.height});
  return {std::max(1, static_cast<int>(std::lround(size.width * scale))),
          std::max(1, static_cast<int>(std::lround(size.height * scale)))};
}

}  // namespace

cv::Mat3b PreviewOf(const Photo& photo, int longest_px) {
  cv::Mat3f pixels = photo.pixels;
  if (!photo.alpha.empty()) {
    pixels = cv::Mat3f(photo.pixels.size());
    ParallelRanges(pixels.rows, 16, [&](int begin, int end) {
      for (int row = begin; row < end; ++row) {
        for (int column = 0; column < pixels.cols; ++column) {
          const float a = photo.alpha(row, column);
          const cv::Vec3f grey = cv::Vec3f::all((1 - a) * kGrey);
          pixels(row, column) = a > 0 ? a * photo.pixels(row, column) + grey : grey;
        }
      }
    });
  }
  const cv::Size size = Fitted(pixels.size(), {longest_px, longest_px});
  cv::Mat3f small = pixels;
  if (size != pixels.size()) cv::resize(pixels, small, size, 0, 0, cv::INTER_AREA);
  cv::Mat3b preview(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      for (int c = 0; c < 3; ++c) {
        const float linear = std::clamp(small(row, column)[c], 0.f, 1.f);
        preview(row, column)[c] =
            static_cast<unsigned char>(std::lround(255 * SrgbFromLinear(linear)));
      }
    }
  }
  return preview;
}

cv::Mat3b Smaller(const cv::Mat3b& preview, cv::Size size) {
  const cv::Size fitted = Fitted(preview.size(), size);
  if (fitted == preview.size()) return preview;
  cv::Mat3b small;
  cv::resize(preview, small, fitted, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace relight
