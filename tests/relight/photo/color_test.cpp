// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/color.h"

#include "relight/photo/read_photo.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

double SrgbInDouble(double l) {
  return l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

TEST(Color, SrgbIsItsClosedForm) {
  // A power in floats: some roundings of 6e-8
  constexpr double kFloatPower = 3e-7;
  for (int i = -100; i <= 4000; ++i) {
    const double linear = i / 1000.0;
    EXPECT_NEAR(SrgbFromLinear(static_cast<float>(linear)),
                SrgbInDouble(linear),
                kFloatPower * (1 + SrgbInDouble(std::abs(linear))));
  }
  EXPECT_EQ(SrgbFromLinear(0.f), 0.f);
  EXPECT_NEAR(SrgbFromLinear(1.f), 1.f, 1.2e-7f);  // One step of a float
}

TEST(Color, LinearUndoesDisplay) {
  cv::Mat3f linear(64, 64);
  cv::RNG(3).fill(linear, cv::RNG::UNIFORM, -0.1, 3.0);
  const cv::Mat3f back = LinearFromDisplay(DisplayFromLinear(linear));
  // IEC 61966-2-1 rounds its two breaks, which part by 1e-7; the rest is float powers
  EXPECT_LT(cv::norm(back, linear, cv::NORM_INF), 3e-6);
}

TEST(Color, CameraCurveRisesKeepsItsFixedPointsAndComesBack) {
  for (const double fixed : {-0.5, 0.0, 0.5, 1.0, 1.5}) {
    EXPECT_DOUBLE_EQ(CameraFromDisplay(fixed), fixed);
    EXPECT_DOUBLE_EQ(DisplayFromCamera(fixed), fixed);
  }
  double last = -1.0;
  for (int i = 0; i <= 1000; ++i) {
    const double camera = CameraFromDisplay(i / 1000.0);
    EXPECT_GT(camera, last);
    EXPECT_NEAR(
        DisplayFromCamera(camera), i / 1000.0, 1e-12);  // Newton, to the last digits
    last = camera;
  }
  EXPECT_LT(CameraFromDisplay(0.25), 0.25);
  EXPECT_GT(CameraFromDisplay(0.75), 0.75);
}

// How far two pictures' logarithms of luminance part after the best gain, over what
// neither has clipped.
double LogResidual(const cv::Mat3f& a, const cv::Mat3f& b) {
  const auto luminance = [](const cv::Vec3f& p) {
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
  };
  double sum = 0, squares = 0, count = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const double l = luminance(a(y, x)), m = luminance(b(y, x));
      if (l < 0.02 || l > 0.8 || m < 0.02 || m > 0.8) continue;
      const double d = std::log(l / m);
      sum += d;
      squares += d * d;
      ++count;
    }
  }
  return std::sqrt(squares / count - sum / count * (sum / count));
}

TEST(Color, CameraToneBringsACamerasPhotoNearerToLinearLight) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/photos_camera");
  for (const char* view : {"view_00", "view_04"}) {
    const cv::Mat3f linear =
        ReadPhoto(tests::SharedPath("data/maple/linear") / (std::string(view) + ".exr"))
            .pixels;
    const auto jpeg =
        tests::SharedPath("data/maple/photos_camera") / (std::string(view) + ".jpg");
    const double as_srgb = LogResidual(ReadPhoto(jpeg).pixels, linear);
    const double as_camera =
        LogResidual(ReadPhoto(jpeg, {.tone = Tone::kCamera}).pixels, linear);
    EXPECT_LT(as_camera, 0.85 * as_srgb) << view;  // Noise and chroma are left
  }
}

TEST(Color, OwnSpacesHaveNames) {
  const std::vector<std::string> names = ColorSpaceNames();
  for (const char* name : {"sRGB", "Linear Rec.709", "Linear Rec.2020", "ACEScg"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
}

}  // namespace
}  // namespace relight
