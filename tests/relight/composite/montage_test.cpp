// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/montage.h"

#include "relight/photo/color.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

const cv::Vec3f kTree(0.2f, 0.4f, 0.1f), kShadow(0.3f, 0.35f, 0.5f),
    kBackdrop(0.5f, 0.6f, 0.2f);

Montage OnePixel(float alpha) {
  return {cv::Mat3f(1, 1, kTree),
          cv::Mat1f(1, 1, alpha),
          cv::Mat3f(1, 1, kShadow),
          cv::Mat3f(1, 1, kBackdrop)};
}

constexpr float kFloat = 1e-5f;  // Rounding of the curve, there and back

TEST(Montage, AnOpaqueTreeHidesAllBelow) {
  const cv::Mat3f flat = FlatPicture(OnePixel(1));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(flat(0, 0)[c], kTree[c], kFloat);
}

TEST(Montage, WithoutTreeAndShadowItIsTheBackdrop) {
  Montage montage = OnePixel(0);
  montage.shadow.release();
  const cv::Mat3f flat = FlatPicture(montage);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(flat(0, 0)[c], kBackdrop[c], kFloat);
}

TEST(Montage, BlendsEncodedValues) {
  const float a = 0.3f;
  const cv::Mat3f display = FlatDisplay(OnePixel(a));
  for (int c = 0; c < 3; ++c) {
    const float below = SrgbFromLinear(kBackdrop[c]) * SrgbFromLinear(kShadow[c]);
    EXPECT_NEAR(display(0, 0)[c], (1 - a) * below + a * SrgbFromLinear(kTree[c]), kFloat);
  }
}

// The product of encoded values against the encoded product: how true the shadow of an
// editor is to light.
TEST(Montage, ItsMultipliedShadowIsNearlyThatOfLight) {
  for (float shadow = 0.1f; shadow <= 1; shadow += 0.05f) {
    for (float below = 0.05f; below <= 1; below += 0.05f) {
      Montage montage{cv::Mat3f(1, 1, cv::Vec3f::all(0)),
                      cv::Mat1f(1, 1, 0.f),
                      cv::Mat3f(1, 1, cv::Vec3f::all(shadow)),
                      cv::Mat3f(1, 1, cv::Vec3f::all(below))};
      // sRGB is a power law of 2.4 with an offset: up to 0.026 apart in deep shade
      EXPECT_NEAR(FlatDisplay(montage)(0, 0)[0], SrgbFromLinear(shadow * below), 0.03)
          << shadow << " x " << below;
    }
  }
}

TEST(Montage, IsCutToWhatADisplayShows) {
  Montage montage = OnePixel(0.5f);
  montage.tree(0, 0) = {7, -1, 1};
  montage.backdrop(0, 0) = {7, 7, 7};
  montage.shadow.release();
  const cv::Mat3f display = FlatDisplay(montage);
  EXPECT_FLOAT_EQ(display(0, 0)[0], 1.0f);
  EXPECT_FLOAT_EQ(display(0, 0)[1], 0.5f);
  EXPECT_FLOAT_EQ(display(0, 0)[2], 1.0f);
}

}  // namespace
}  // namespace relight
