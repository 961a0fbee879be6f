// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/capture_time.h"

#include "relight/base/error.h"
#include "tests/relight/photo/made_files.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

using namespace std::chrono;
using tests::WordsOf;

WallClock Wall(int y, unsigned m, unsigned d, int h, int min) {
  return WallClock(sys_days(year(y) / month(m) / day(d)).time_since_epoch() + hours(h) +
                   minutes(min));
}

// 2011-07-22T13:00:00-04:00, the maple's.
const LocalTime kMaple{.utc = Instant(sys_days(year(2011) / July / 22)) + hours(17),
                       .offset = hours(-4)};

TEST(CaptureTime, ParseWhenKnowsAllItsForms) {
  struct Row {
    const char* text;
    const char* zone;  // Or none.
    const char* expected;
  };
  for (const Row& row : {
           Row{"same", nullptr, "2011-07-22T13:00:00-04:00"},
           Row{"17:00", nullptr, "2011-07-22T17:00:00-04:00"},
           Row{"7:05", nullptr, "2011-07-22T07:05:00-04:00"},
           Row{"17:00:30", nullptr, "2011-07-22T17:00:30-04:00"},
           Row{"17:00:30.5", nullptr, "2011-07-22T17:00:30.500-04:00"},
           Row{"2011-09-23T17:00", nullptr, "2011-09-23T17:00:00-04:00"},
           Row{"2011-09-23 17:00", nullptr, "2011-09-23T17:00:00-04:00"},
           Row{"2011-09-23T17:00+02:00", nullptr, "2011-09-23T17:00:00+02:00"},
           Row{"2011-09-23T17:00:01Z", nullptr, "2011-09-23T17:00:01+00:00"},
           Row{"03:00+09:00",
               nullptr,
               "2011-07-23T03:00:00+09:00"},  // Already the 23rd there
           Row{"+3h", nullptr, "2011-07-22T16:00:00-04:00"},
           Row{"-90m", nullptr, "2011-07-22T11:30:00-04:00"},
           Row{"+1h30m", nullptr, "2011-07-22T14:30:00-04:00"},
           Row{"+2d", nullptr, "2011-07-24T13:00:00-04:00"},
           Row{"-13h30m", nullptr, "2011-07-21T23:30:00-04:00"},
           Row{"17:00", "America/New_York", "2011-07-22T17:00:00-04:00"},
           Row{"2011-12-01T17:00", "America/New_York", "2011-12-01T17:00:00-05:00"},
           Row{"same", "Europe/Paris", "2011-07-22T19:00:00+02:00"},
           Row{"17:00", "+05:30", "2011-07-22T17:00:00+05:30"},
           Row{"+180d",
               "America/New_York",
               "2012-01-18T12:00:00-05:00"},  // Winter clocks
       }) {
    const auto zone = row.zone ? std::optional(ParseZone(row.zone)) : std::nullopt;
    const LocalTime time = ParseWhen(row.text, kMaple, zone);
    EXPECT_EQ(FormatLocal(time), row.expected) << row.text;
  }
}

TEST(CaptureTime, ParseWhenRefusesTheRestAndListsTheForms) {
  for (const char* text : {"",
                           "5pm",
                           "25:00",
                           "17:60",
                           "17",
                           "2011-02-30T12:00",
                           "2011-13-01T12:00",
                           "+",
                           "-",
                           "+h",
                           "3h",
                           "tomorrow",
                           "2011-09-23",
                           "17:00+99:00",
                           "17:00:61",
                           "+3x",
                           "١٧:٠٠"}) {
    const std::string words = WordsOf<OptionError>([&] { ParseWhen(text, kMaple); });
    EXPECT_NE(words.find("2011-09-23T17:00"), std::string::npos) << text;
    EXPECT_NE(words.find("same"), std::string::npos) << text;
  }
}

// All of `parts` are in `text`.
void ExpectHolds(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
}

TEST(CaptureTime, ClocksPutForwardLeaveAGap) {
  // 2011-03-27, 02:00 to 03:00 in Paris
  const Zone paris = ParseZone("Europe/Paris");
  const std::string gap =
      WordsOf<OptionError>([&] { FromWallClock(Wall(2011, 3, 27, 2, 30), paris); });
  ExpectHolds(gap,
              {"2011-03-27T02:30:00 did not exist in Europe/Paris",
               "put forward then, from 02:00 to 03:00",
               "2011-03-27T03:30:00+02:00",
               "2011-03-27T01:30:00+01:00"});
  EXPECT_EQ(FormatLocal(FromWallClock(Wall(2011, 3, 27, 1, 59), paris)),
            "2011-03-27T01:59:00+01:00");
  EXPECT_EQ(FormatLocal(FromWallClock(Wall(2011, 3, 27, 3, 0), paris)),
            "2011-03-27T03:00:00+02:00");
  // Half an hour on Lord Howe, in the spring of the south
  ExpectHolds(WordsOf<OptionError>([&] {
                FromWallClock(Wall(2020, 10, 4, 2, 15), ParseZone("Australia/Lord_Howe"));
              }),
              {"did not exist", "from 02:00 to 02:30", "2020-10-04T02:45:00+11:00"});
}

TEST(CaptureTime, ClocksPutBackHaveAnHourTwice) {
  const Zone paris = ParseZone("Europe/Paris");
  const std::string twice =
      WordsOf<OptionError>([&] { FromWallClock(Wall(2011, 10, 30, 2, 30), paris); });
  ExpectHolds(twice,
              {"2011-10-30T02:30:00 occurred twice in Europe/Paris",
               "put back then, from 03:00 to 02:00",
               "2011-10-30T02:30:00+02:00 for the first",
               "2011-10-30T02:30:00+01:00 for the second"});
  const ClockReading reading = ReadClock(Wall(2011, 10, 30, 2, 30), paris);
  EXPECT_EQ(reading.kind, ClockReading::Kind::kTwice);
  EXPECT_EQ(reading.second.utc - reading.first.utc, hours(1));
  // South of the equator the year is the other way round
  EXPECT_EQ(
      FormatLocal(FromWallClock(Wall(2020, 1, 15, 12, 0), ParseZone("Australia/Sydney"))),
      "2020-01-15T12:00:00+11:00");
  // What is typed with its offset, or as a time from another, is never ambiguous
  EXPECT_EQ(ParseWhen("2011-10-30T02:30+01:00", kMaple, paris).utc, reading.second.utc);
  const LocalTime before{.utc = reading.first.utc - hours(3), .offset = hours(2)};
  EXPECT_EQ(ParseWhen("+3h", before, paris).utc, reading.first.utc);
  EXPECT_EQ(ParseWhen("+4h", before, paris).utc, reading.second.utc);
  EXPECT_EQ(FormatLocal(ParseWhen("+4h", before, paris)), "2011-10-30T02:30:00+01:00");
  EXPECT_THROW(ParseWhen("2011-10-30T02:30", kMaple, paris), OptionError);
}

TEST(CaptureTime, APhotoInTheHourOfAChangeIsRefusedUnlessGpsDecides) {
  PhotoFacts facts;
  facts.file = "IMG_0412.JPG";
  facts.local_time = Wall(2011, 10, 30, 2, 30);
  ExpectHolds(WordsOf<InputError>([&] { ResolveCaptureTime(facts, "Europe/Paris"); }),
              {"IMG_0412.JPG", "occurred twice", "+01:00 for the second", "--taken"});
  ExpectHolds(WordsOf<OptionError>(
                  [&] { ResolveCaptureTime(facts, "Europe/Paris", "2011-03-27T02:30"); }),
              {"taken", "did not exist", "2011-03-27T03:30:00+02:00"});
  facts.gps_time = Instant(sys_days(year(2011) / October / 30)) + minutes(90);
  facts.place = Place{.latitude_deg = 48.85, .longitude_deg = 2.35};
  const CaptureTime decided = ResolveCaptureTime(facts, "Europe/Paris");
  EXPECT_EQ(FormatLocal(decided.time), "2011-10-30T02:30:00+01:00");
  ASSERT_EQ(decided.notes.size(), 1u);
  ExpectHolds(decided.notes[0], {"occurred twice", "GPS time decides"});
  facts.gps_time = {};
  facts.offset = hours(1);  // So does the photo's own offset, without a word
  EXPECT_TRUE(ResolveCaptureTime(facts, "Europe/Paris").notes.empty());
}

TEST(CaptureTime, AZoneThatGpsContradictsIsDoubted) {
  PhotoFacts facts;
  facts.file = "IMG_0412.JPG";
  facts.local_time = Wall(2011, 7, 22, 13, 0);
  facts.gps_time = kMaple.utc - minutes(4);
  facts.place = Place{.latitude_deg = 40.35, .longitude_deg = -74.65};
  EXPECT_TRUE(ResolveCaptureTime(facts, "America/New_York").notes.empty());
  EXPECT_FALSE(ZoneAgainstGps(facts, {}));  // Nothing is said that GPS could contradict
  const CaptureTime paris = ResolveCaptureTime(facts, "Europe/Paris");
  EXPECT_EQ(paris.time.utc, *facts.gps_time);
  ASSERT_EQ(paris.notes.size(), 1u);
  ExpectHolds(paris.notes[0],
              {"IMG_0412.JPG",
               "Europe/Paris",
               "2011-07-22T11:00:00+00:00",
               "2011-07-22T16:56:00+00:00",
               "-04:00 would agree"});
  facts.offset = hours(-5);  // Summer time forgotten
  const CaptureTime own = ResolveCaptureTime(facts);
  ASSERT_EQ(own.notes.size(), 1u);
  ExpectHolds(own.notes[0], {"its own offset", "-04:00 would agree"});
  facts.gps_time = kMaple.utc - hours(49) - minutes(7);  // The day before yesterday's fix
  const auto old = ZoneAgainstGps(facts, {});
  ASSERT_TRUE(old);
  ExpectHolds(*old, {"no zone would agree", "--taken"});
  // What the user says of the time is not doubted by the photo's own
  EXPECT_TRUE(ResolveCaptureTime(facts, {}, "2011-07-22T13:00-04:00").notes.empty());
}

TEST(CaptureTime, TheRulesGoOnAfterTheDatabaseEnds) {
  const Zone paris = ParseZone("Europe/Paris");
  EXPECT_EQ(FromWallClock(Wall(2045, 7, 1, 12, 0), paris).offset, hours(2));
  EXPECT_EQ(FromWallClock(Wall(2045, 12, 1, 12, 0), paris).offset, hours(1));
  // The last Sunday of March 2045 is the 26th
  EXPECT_EQ(FromWallClock(Wall(2045, 3, 26, 1, 30), paris).offset, hours(1));
  EXPECT_EQ(FromWallClock(Wall(2045, 3, 26, 3, 30), paris).offset, hours(2));
  EXPECT_EQ(InZone(FromWallClock(Wall(2045, 7, 1, 12, 0), paris).utc, paris).offset,
            hours(2));
}

// To UTC and back is where it began, whatever the zone and the hour.
TEST(CaptureTime, ComesBackFromEveryZone) {
  cv::RNG random(31);
  for (const char* name : {"Europe/Paris",
                           "America/St_Johns",
                           "Asia/Kathmandu",
                           "Pacific/Chatham",
                           "Africa/Nairobi",
                           "US/Pacific",
                           "+05:45"}) {
    const Zone zone = ParseZone(name);
    for (int i = 0; i < 300; ++i) {
      const Instant utc{seconds(random.uniform(0, 2000000000))};
      const LocalTime local = InZone(utc, zone);
      const ClockReading back = ReadClock(WallClockOf(local), zone);
      EXPECT_NE(back.kind, ClockReading::Kind::kNever) << name;
      EXPECT_TRUE(back.first.utc == utc || back.second.utc == utc)
          << name << " " << FormatLocal(local);
      EXPECT_EQ(ParseWhen(FormatLocal(local), kMaple).utc, utc);
    }
  }
}

TEST(CaptureTime, ZonesHaveNamesOrOffsets) {
  EXPECT_EQ(ParseZone("+02:00").fixed_offset, hours(2));
  EXPECT_EQ(ParseZone("-0330").fixed_offset, -minutes(210));
  EXPECT_EQ(ParseZone("Z").fixed_offset, minutes(0));
  EXPECT_FALSE(ParseZone("Europe/Paris").fixed_offset.has_value());
  for (const char* text : {"",
                           "Paris",
                           "Europe/Nowhere",
                           "../../../etc/passwd",
                           "/etc/passwd",
                           "+25:00",
                           "02:00",
                           "Europe",
                           "zone.tab",
                           "Europe//Paris"}) {
    const std::string words = WordsOf<OptionError>([&] { ParseZone(text); });
    EXPECT_NE(words.find("Europe/Paris"), std::string::npos) << text;
  }
}

TEST(CaptureTime, AZoneHasARoughPlace) {
  const auto paris = PlaceOfZone(ParseZone("Europe/Paris"));
  ASSERT_TRUE(paris.has_value());
  EXPECT_NEAR(paris->latitude_deg, 48.87, 0.02);  // +4852+00220, in minutes of arc
  EXPECT_NEAR(paris->longitude_deg, 2.33, 0.02);
  const auto new_york = PlaceOfZone(ParseZone("US/Eastern"));  // Another name of it
  ASSERT_TRUE(new_york.has_value());
  EXPECT_NEAR(new_york->longitude_deg, -74.006, 0.01);
  EXPECT_LT(PlaceOfZone(ParseZone("Australia/Sydney"))->latitude_deg, -33.0);
  EXPECT_FALSE(PlaceOfZone(ParseZone("+02:00")).has_value());
}

TEST(CaptureTime, ComesFromTheBestThatThePhotoSays) {
  PhotoFacts facts;
  facts.file = "IMG_0412.JPG";
  const auto words = [&](std::optional<std::string> zone,
                         std::optional<std::string> taken) {
    return WordsOf<InputError>([&] { ResolveCaptureTime(facts, zone, taken); });
  };
  EXPECT_NE(words({}, {}).find("IMG_0412.JPG: no capture time in EXIF; give --taken"),
            std::string::npos);
  EXPECT_NE(words("Europe/Paris", {}).find("give --taken"), std::string::npos);

  // The clock alone, and then with what it needs
  facts.local_time = Wall(2011, 7, 22, 13, 0);
  EXPECT_NE(words({}, {}).find("time without zone; give --zone"), std::string::npos);
  const CaptureTime zoned = ResolveCaptureTime(facts, "America/New_York");
  EXPECT_EQ(FormatLocal(zoned.time), "2011-07-22T13:00:00-04:00");
  ASSERT_TRUE(zoned.approximate_place.has_value());
  EXPECT_NEAR(zoned.approximate_place->latitude_deg, 40.714, 0.01);
  ASSERT_EQ(zoned.notes.size(), 1u);
  EXPECT_NE(zoned.notes[0].find("--place"), std::string::npos);
  EXPECT_FALSE(ResolveCaptureTime(facts, "-04:00").approximate_place.has_value());

  // GPS: its moment, and the clock's distance from it as the zone
  facts.gps_time = kMaple.utc + seconds(40);
  const CaptureTime gps = ResolveCaptureTime(facts);
  EXPECT_EQ(FormatLocal(gps.time), "2011-07-22T13:00:40-04:00");
  EXPECT_EQ(gps.source, "GPS date and time");
  facts.gps_time = kMaple.utc + minutes(37);  // No zone is 37 minutes off
  EXPECT_NE(words({}, {}).find("do not fit"), std::string::npos);

  // The photo's own offset first of all
  facts.offset = hours(-4);
  const CaptureTime own = ResolveCaptureTime(facts);
  EXPECT_EQ(FormatLocal(own.time), "2011-07-22T13:00:00-04:00");
  ASSERT_EQ(own.notes.size(), 1u);  // That GPS says otherwise
  EXPECT_EQ(own.zone->fixed_offset, hours(-4));
  facts.place = Place{.latitude_deg = 40.35, .longitude_deg = -74.65};
  EXPECT_FALSE(
      ResolveCaptureTime(facts, "America/New_York").approximate_place.has_value());

  // --taken over everything
  EXPECT_EQ(FormatLocal(ResolveCaptureTime(facts, {}, "2012-01-01T09:30+01:00").time),
            "2012-01-01T09:30:00+01:00");
  EXPECT_EQ(
      FormatLocal(ResolveCaptureTime(facts, "Europe/Paris", "2012-07-01T09:30").time),
      "2012-07-01T09:30:00+02:00");
  EXPECT_EQ(FormatLocal(ResolveCaptureTime(facts, {}, "09:30").time),
            "2011-07-22T09:30:00-04:00");
  EXPECT_THROW(ResolveCaptureTime(facts, {}, "+3h"), OptionError);
  facts = {};
  EXPECT_NE(words({}, "2012-07-01T09:30").find("time without zone; give --zone"),
            std::string::npos);
  EXPECT_NE(words("Z", "09:30").find("give --taken with the date"), std::string::npos);
}

TEST(CaptureTime, PlacesAndHeadings) {
  const Place princeton = ParsePlace("40.35,-74.65");
  EXPECT_EQ(princeton.latitude_deg, 40.35);
  EXPECT_EQ(princeton.longitude_deg, -74.65);
  EXPECT_EQ(ParsePlace(" 33.9S , 151.2E, 12.5").latitude_deg, -33.9);
  EXPECT_EQ(ParsePlace("33.9S,151.2E,12.5").altitude_m, 12.5);
  for (const char* text : {"",
                           "40.35",
                           "95,0",
                           "0,181",
                           "40.35;-74.65",
                           "here",
                           "nan,0",
                           "1e3,0",
                           "40.35,-74.65,x"}) {
    EXPECT_THROW(ParsePlace(text), OptionError) << text;
  }
  EXPECT_EQ(ParseHeading("210"), 210.0);
  EXPECT_EQ(ParseHeading("210.5"), 210.5);
  EXPECT_EQ(ParseHeading("360"), 0.0);
  EXPECT_EQ(ParseHeading("SW"), 225.0);
  EXPECT_EQ(ParseHeading("nne"), 22.5);
  for (const char* text : {"", "-5", "361", "north-ish", "inf", "12 deg"}) {
    EXPECT_THROW(ParseHeading(text), OptionError) << text;
  }
}

}  // namespace
}  // namespace relight
