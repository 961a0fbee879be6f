// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/accuracy_notes.h"

#include "relight/base/angles.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

AccuracyFacts GoodFacts() {
  AccuracyFacts facts;
  facts.input.azimuth_rad = RadFromDeg(180);
  facts.input.elevation_rad = RadFromDeg(55);
  facts.input.direction =
      DirectionFromAzimuthElevation(facts.input.azimuth_rad, facts.input.elevation_rad);
  facts.heading_rad = RadFromDeg(60);
  facts.views = 12;
  facts.contrast = PhotoContrast{0.8, 0.2};
  return facts;
}

TEST(AccuracyNotes, AreNoneForAGoodCapture) {
  EXPECT_TRUE(AccuracyNotes(GoodFacts(), {}).empty());
}

TEST(AccuracyNotes, NameEachThingThatCosts) {
  const auto only = [](const AccuracyFacts& facts,
                       const Correction& correction,
                       const std::string& words) {
    const std::vector<std::string> notes = AccuracyNotes(facts, correction);
    ASSERT_EQ(notes.size(), 1u) << words;
    EXPECT_NE(notes[0].find(words), std::string::npos) << notes[0];
  };
  AccuracyFacts low = GoodFacts();
  low.input.elevation_rad = RadFromDeg(12);
  only(low, {}, "low, at 12 deg");

  AccuracyFacts few = GoodFacts();
  few.views = 4;
  only(few, {}, "from 4 photos");

  AccuracyFacts against = GoodFacts();
  against.heading_rad = RadFromDeg(175);
  only(against, {}, "against the sun");

  AccuracyFacts clouds = GoodFacts();
  clouds.air = TurbidityEstimate{.misfit = 0.3};
  only(clouds, {}, "--input-sky overcast");

  AccuracyFacts glossy = GoodFacts();
  glossy.contrast = PhotoContrast{1.1, 0.1};
  only(glossy, {}, "glisten");

  AccuracyFacts large = GoodFacts();
  large.contrast = PhotoContrast{0.7, 0.4};
  only(large, {}, "larger than a voxel");

  Correction unlike;
  unlike.mean_trust = 0.25;
  only(GoodFacts(), unlike, "counts 25 %");
}

}  // namespace
}  // namespace relight
