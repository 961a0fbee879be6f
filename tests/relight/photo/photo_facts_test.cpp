// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/photo_facts.h"

#include "relight/base/error.h"
#include "relight/photo/capture_time.h"
#include "tests/relight/photo/made_files.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

using namespace tests;

// EXIF as a telephone writes it; each test changes what it is about.
struct Exif {
  std::string time = "2011:07:22 13:00:00";
  std::string offset = "-04:00";
  std::string lat_ref = "N", lon_ref = "W", heading_ref = "T";
  std::vector<Fraction> lat = {{40, 1}, {21, 1}, {0, 1}},
                        lon = {{74, 1}, {39, 1}, {0, 1}};
  Fraction altitude = {20, 1};
  int altitude_ref = 0;
  Fraction heading = {35925, 100};
  std::string gps_date = "2011:07:22";
  std::vector<Fraction> gps_time = {{17, 1}, {0, 1}, {1, 2}};

  std::string Tiff() const {
    return MakeTiff({TextField(271, "Maker "), TextField(272, "Model 1")},
                    {TextField(0x9003, time),
                     TextField(0x9011, offset),
                     TextField(0x9291, "25"),
                     RationalField(0x920A, {{70, 1}}),
                     ShortField(0xA405, {105})},
                    {ByteField(0, {2, 3, 0, 0}),
                     TextField(1, lat_ref),
                     RationalField(2, lat),
                     TextField(3, lon_ref),
                     RationalField(4, lon),
                     ByteField(5, {altitude_ref}),
                     RationalField(6, {altitude}),
                     RationalField(7, gps_time),
                     TextField(16, heading_ref),
                     RationalField(17, {heading}),
                     TextField(29, gps_date)});
  }
};

PhotoFacts FactsOf(const Exif& exif) {
  const TemporaryFolder folder;
  WriteJpegWithExif(folder / "a.jpg", SmoothPhoto(32, 16), exif.Tiff());
  return ReadPhotoFacts(folder / "a.jpg");
}

TEST(PhotoFacts, AreThoseOfTheExif) {
  const PhotoFacts facts = FactsOf({});
  EXPECT_TRUE(facts.notes.empty()) << facts.notes[0];
  EXPECT_EQ(facts.width, 32);
  EXPECT_EQ(facts.height, 16);
  ASSERT_TRUE(facts.local_time && facts.offset && facts.gps_time && facts.place &&
              facts.heading_deg);
  EXPECT_EQ(FormatLocal({.utc = Instant(facts.local_time->time_since_epoch())}),
            "2011-07-22T13:00:00.250+00:00");
  EXPECT_EQ(*facts.offset, std::chrono::minutes(-240));
  EXPECT_EQ(FormatLocal({.utc = *facts.gps_time}), "2011-07-22T17:00:00.500+00:00");
  EXPECT_NEAR(facts.place->latitude_deg, 40.35, 1e-9);
  EXPECT_NEAR(facts.place->longitude_deg, -74.65, 1e-9);
  EXPECT_EQ(facts.place->altitude_m, 20.0);
  EXPECT_NEAR(*facts.heading_deg, 359.25, 1e-4);  // OpenImageIO keeps floats
  EXPECT_FALSE(facts.heading_is_magnetic);
  EXPECT_EQ(facts.focal_mm, 70.0);
  EXPECT_EQ(facts.focal_35mm_mm, 105.0);
  EXPECT_EQ(facts.make, "Maker");
  EXPECT_EQ(facts.model, "Model 1");
  EXPECT_FALSE(facts.made_by_relight);
}

TEST(PhotoFacts, KnowSouthEastBelowTheSeaAndMagneticNorth) {
  Exif exif;
  exif.lat_ref = "S";
  exif.lon_ref = "E";
  exif.altitude_ref = 1;
  exif.heading_ref = "M";
  const PhotoFacts facts = FactsOf(exif);
  EXPECT_NEAR(facts.place->latitude_deg, -40.35, 1e-9);
  EXPECT_NEAR(facts.place->longitude_deg, 74.65, 1e-9);
  EXPECT_EQ(facts.place->altitude_m, -20.0);
  EXPECT_TRUE(facts.heading_is_magnetic);
}

TEST(PhotoFacts, WhatCannotBeCountsAsMissingWithANote) {
  Exif exif;
  exif.time = "2011:13:22 13:00:00";
  exif.offset = "+99:00";
  exif.lat = {{95, 1}, {0, 1}, {0, 1}};
  exif.heading = {0, 0};
  exif.gps_date = "2011:02:30";
  const PhotoFacts facts = FactsOf(exif);
  EXPECT_FALSE(facts.local_time || facts.offset || facts.place || facts.gps_time);
  EXPECT_GE(facts.notes.size(), 4u);

  // Divided by nothing
  Exif zero;
  zero.lat = {{40, 0}, {0, 0}, {0, 0}};
  EXPECT_FALSE(FactsOf(zero).place.has_value());
  zero = {};
  zero.heading = {400, 1};
  EXPECT_FALSE(FactsOf(zero).heading_deg.has_value());
  zero = {};
  zero.lat_ref = "";
  EXPECT_FALSE(FactsOf(zero).place.has_value());
}

// A clock that was never set says nothing; that is no mistake to report.
TEST(PhotoFacts, AnUnsetClockIsSimplyMissing) {
  Exif exif;
  exif.time = "0000:00:00 00:00:00";
  exif.offset = "   :  ";
  const PhotoFacts facts = FactsOf(exif);
  EXPECT_FALSE(facts.local_time || facts.offset);
  EXPECT_TRUE(facts.notes.empty());
}

TEST(PhotoFacts, TurnTheSizeWithThePicture) {
  const TemporaryFolder folder;
  WriteJpegWithExif(
      folder / "a.jpg", SmoothPhoto(32, 16), MakeTiff({ShortField(274, {8})}));
  EXPECT_EQ(ReadPhotoFacts(folder / "a.jpg").width, 16);
}

TEST(PhotoFacts, RandomExifNeverCrashes) {
  const TemporaryFolder folder;
  cv::RNG random(17);
  const std::string exif = Exif().Tiff();
  for (int i = 0; i < 300; ++i) {
    std::string damaged = exif;
    for (int k = 0; k < 6; ++k) {
      damaged[static_cast<std::size_t>(
          random.uniform(8, static_cast<int>(damaged.size())))] =
          static_cast<char>(random.uniform(0, 256));
    }
    WriteJpegWithExif(folder / "a.jpg", SmoothPhoto(16, 16), damaged);
    try {
      const PhotoFacts facts = ReadPhotoFacts(folder / "a.jpg");
      if (facts.place) {
        EXPECT_LE(std::abs(facts.place->latitude_deg), 90.0);
        EXPECT_LE(std::abs(facts.place->longitude_deg), 180.0);
      }
      if (facts.heading_deg) {
        EXPECT_LT(*facts.heading_deg, 360.0);
      }
    } catch (const InputError&) {
      // Refused in words: as good
    }
  }
}

TEST(PhotoFacts, OfTheMaple) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/photos/view_00.jpg");
  const PhotoFacts facts = ReadPhotoFacts(SharedPath("data/maple/photos/view_00.jpg"));
  EXPECT_EQ(FormatLocal(ResolveCaptureTime(facts).time), "2011-07-22T13:00:00-04:00");
  // Each view's GPS place is where its camera stands, some 20 m from the tree
  constexpr double kTwentyFiveMetresDeg = 25.0 / 85000;
  EXPECT_NEAR(facts.place->latitude_deg, 40.35, kTwentyFiveMetresDeg);
  EXPECT_NEAR(facts.place->longitude_deg, -74.65, kTwentyFiveMetresDeg);
  EXPECT_NEAR(*facts.heading_deg, 359.25, 1e-3);
  EXPECT_FALSE(facts.heading_is_magnetic);
  EXPECT_EQ(facts.focal_35mm_mm, 70.0);
}

}  // namespace
}  // namespace relight
