// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/view_selection.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

namespace relight {
namespace {

using Cameras = std::map<std::string, Camera>;

void Add(Cameras& cameras, double azimuth_deg) {
  char name[16];
  std::snprintf(name, sizeof name, "v%03zu", cameras.size());
  Camera camera;
  camera.camera_from_world.translation() =
      -15 * DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg), 0.1);
  cameras[name] = camera;
}

Cameras Arc(int count, double step_deg) {
  Cameras cameras;
  for (int i = 0; i < count; ++i) Add(cameras, 33 + i * step_deg);
  return cameras;
}

std::vector<double> AzimuthsOf(const Cameras& cameras) {
  std::vector<double> azimuths;
  for (const auto& [name, camera] : cameras)
    azimuths.push_back(DegFromRad(AzimuthOf(camera.PositionInWorld())));
  std::sort(azimuths.begin(), azimuths.end());
  return azimuths;
}

TEST(ViewSelection, FewViewsAreAllTaken) {
  EXPECT_EQ(EvenlySpreadViews(Arc(12, 30), {}).size(), 12u);
  EXPECT_EQ(EvenlySpreadViews(Arc(5, 30), {.most_views = 5}).size(), 5u);
  EXPECT_THROW(EvenlySpreadViews(Arc(5, 30), {.most_views = 1}), OptionError);
}

TEST(ViewSelection, AFullCircleIsTakenInEvenSteps) {
  for (const int count : {24, 36, 60, 120}) {
    const Cameras chosen = EvenlySpreadViews(Arc(count, 360.0 / count), {});
    ASSERT_EQ(chosen.size(), 12u);
    EXPECT_TRUE(chosen.contains("v000"));
    const std::vector<double> azimuths = AzimuthsOf(chosen);
    for (std::size_t i = 1; i < azimuths.size(); ++i)
      EXPECT_NEAR(azimuths[i] - azimuths[i - 1], 30, 1e-6) << count;
  }
}

TEST(ViewSelection, HalfACircleIsTakenWithItsEnds) {
  const Cameras chosen = EvenlySpreadViews(Arc(31, 6), {.most_views = 11});
  ASSERT_EQ(chosen.size(), 11u);
  EXPECT_TRUE(chosen.contains("v000") && chosen.contains("v030"));
  const std::vector<double> azimuths = AzimuthsOf(chosen);
  for (std::size_t i = 1; i < azimuths.size(); ++i)
    EXPECT_NEAR(azimuths[i] - azimuths[i - 1], 18, 1e-6);
}

TEST(ViewSelection, ACrowdedSideDoesNotCountMore) {
  Cameras cameras = Arc(12, 30);
  for (int i = 0; i < 40; ++i) Add(cameras, 100 + 0.5 * i);  // A film of one side
  const std::vector<double> azimuths = AzimuthsOf(EvenlySpreadViews(cameras, {}));
  ASSERT_EQ(azimuths.size(), 12u);
  for (std::size_t i = 1; i < azimuths.size(); ++i)
    EXPECT_GT(azimuths[i] - azimuths[i - 1], 25);
}

TEST(ViewSelection, PhotosFromOnePlaceStillFillTheNumber) {
  EXPECT_EQ(EvenlySpreadViews(Arc(40, 0), {}).size(), 12u);
}

}  // namespace
}  // namespace relight
