// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/light_in_words.h"

#include "relight/base/angles.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

std::string Words(double azimuth_deg, double elevation_deg) {
  return LightInWords(RadFromDeg(azimuth_deg), RadFromDeg(elevation_deg));
}

std::string FewWords(double azimuth_deg, double elevation_deg) {
  return LightInFewWords(RadFromDeg(azimuth_deg), RadFromDeg(elevation_deg));
}

TEST(LightInWords, SaysWhereTheSunIsAndWhereTheShadowFalls) {
  EXPECT_EQ(Words(225, 62),
            "sun behind you on the left, 62° high, shadow falls away to the right");
  EXPECT_EQ(Words(0, 20), "sun in front of you, 20° high, shadow falls towards you");
  EXPECT_EQ(
      Words(45, 20),
      "sun in front of you on the right, 20° high, shadow falls towards you to the left");
  EXPECT_EQ(Words(90, 20), "sun on your right, 20° high, shadow falls to the left");
  EXPECT_EQ(Words(135, 20),
            "sun behind you on the right, 20° high, shadow falls away to the left");
  EXPECT_EQ(Words(180, 20), "sun behind you, 20° high, shadow falls away from you");
  EXPECT_EQ(Words(270, 20), "sun on your left, 20° high, shadow falls to the right");
  EXPECT_EQ(Words(100, 84.4), "sun overhead, 84° high, shadow under the tree");
  EXPECT_EQ(Words(100, -3), "sun below the horizon, no shadow");
}

TEST(LightInWords, HasAShortForm) {
  EXPECT_EQ(FewWords(90, 14), "from the right, 14°");
  EXPECT_EQ(FewWords(225, 62), "from behind on the left, 62°");
  EXPECT_EQ(FewWords(10, 85), "from overhead, 85°");
}

TEST(LightInWords, DoesNotMindWholeTurnsAndSectorEdges) {
  for (double azimuth_deg = 0.0; azimuth_deg < 360.0; azimuth_deg += 7.3) {
    EXPECT_EQ(Words(azimuth_deg, 30), Words(azimuth_deg - 720, 30));
    EXPECT_EQ(Words(azimuth_deg, 30), Words(azimuth_deg + 360, 30));
  }
  EXPECT_EQ(FewWords(22.4, 5), "from the front, 5°");
  EXPECT_EQ(FewWords(22.6, 5), "from the front on the right, 5°");
  EXPECT_EQ(FewWords(337.6, 5), "from the front, 5°");
  EXPECT_EQ(FewWords(-22.4, 5), "from the front, 5°");
}

TEST(LightInWords, TheCompassNeedsNoCamera) {
  EXPECT_EQ(LightFromCompass(RadFromDeg(0), RadFromDeg(30)), "from the north, 30°");
  EXPECT_EQ(LightFromCompass(RadFromDeg(230), RadFromDeg(61.6)),
            "from the south-west, 62°");
  EXPECT_EQ(LightFromCompass(RadFromDeg(-91), RadFromDeg(10)), "from the west, 10°");
  EXPECT_EQ(LightFromCompass(RadFromDeg(-1000), -0.1), "from below the horizon");
}

}  // namespace
}  // namespace relight
