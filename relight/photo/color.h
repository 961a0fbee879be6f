// SPDX-License-Identifier: Apache-2.0
#pragma once

// Display values and linear light.
//
//   [sRGB] IEC 61966-2-1
//
// With linear light L and display value D, both 1 at white, per channel,
//
//   D = 12.92 L                      for L <= 0.0031308,
//   D = 1.055 L^(1/2.4) - 0.055      above                            [sRGB]
//
// and the inverse with the break at D = 0.04045. Below 0 the straight part goes on, above
// 1 the power, so that nothing is lost in between.
//
// The tone of a camera. A camera's JPEG is brighter and harder than [sRGB] of linear
// light. No two cameras agree; this smooth S-curve on display values stands for all of
// them, and it is approximate:
//
//   C(D) = (1 - k) D + k (3 D^2 - 2 D^3),   k = 0.3, for 0 <= D <= 1    (P1)
//
// C leaves 0, 1/2 and 1 alone and rises everywhere. k is fitted, together with one gain,
// to a rendered tree developed with a camera's curve; what remains is 0.010 rms in D.

#include <opencv2/core.hpp>

#include <cmath>
#include <string>
#include <vector>

namespace relight {

inline float SrgbFromLinear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear
                              : 1.055f * std::pow(linear, 1.f / 2.4f) - 0.055f;
}
inline float LinearFromSrgb(float display) {
  return display <= 0.04045f ? display / 12.92f
                             : std::pow((display + 0.055f) / 1.055f, 2.4f);
}

// The same for whole images, of any size.
cv::Mat3f DisplayFromLinear(const cv::Mat3f& linear);
cv::Mat3f LinearFromDisplay(const cv::Mat3f& display);

inline constexpr double kCameraContrast = 0.3;  // k of (P1).

// C of (P1) and its inverse; outside [0, 1] a value is returned as it is.
double CameraFromDisplay(double display);
double DisplayFromCamera(double camera);

// Names that ReadPhotoOptions::color_space may have: those of the config that the
// environment variable OCIO names, else of our own. Throws InputError when that config
// cannot be used.
std::vector<std::string> ColorSpaceNames();

}  // namespace relight
