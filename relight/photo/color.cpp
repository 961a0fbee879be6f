// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/color.h"

#include "relight/base/parallel.h"

#include <algorithm>

namespace relight {
namespace {

constexpr int kRowsAtOnce = 32;

template <class Curve>
cv::Mat3f PerChannel(const cv::Mat3f& image, Curve curve) {
  cv::Mat3f out(image.size());
  ParallelRanges(image.rows, kRowsAtOnce, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      const cv::Vec3f* from = image[y];
      cv::Vec3f* to = out[y];
      for (int x = 0; x < image.cols; ++x) {
        to[x] = {curve(from[x][0]), curve(from[x][1]), curve(from[x][2])};
      }
    }
  });
  return out;
}

}  // namespace

cv::Mat3f DisplayFromLinear(const cv::Mat3f& linear) {
  return PerChannel(linear, SrgbFromLinear);
}

cv::Mat3f LinearFromDisplay(const cv::Mat3f& display) {
  return PerChannel(display, LinearFromSrgb);
}

// C(D) = (1 - k) D + k (3 D^2 - 2 D^3)                                  (P1)
double CameraFromDisplay(double display) {
  if (!(display > 0.0 && display < 1.0)) return display;
  const double k = kCameraContrast;
  return (1.0 - k) * display + k * display * display * (3.0 - 2.0 * display);
}

// Inverse of (P1), by bisection and then Newton: C' >= 1 - k > 0.
double DisplayFromCamera(double camera) {
  if (!(camera > 0.0 && camera < 1.0)) return camera;
  const double k = kCameraContrast;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (low + high);
    (CameraFromDisplay(middle) < camera ? low : high) = middle;
  }
  double display = 0.5 * (low + high);
  for (int i = 0; i < 4; ++i) {
    const double slope = 1.0 - k + 6.0 * k * display * (1.0 - display);
    display -= (CameraFromDisplay(display) - camera) / slope;
  }
  return std::clamp(display, 0.0, 1.0);
}

}  // namespace relight
