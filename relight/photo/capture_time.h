// SPDX-License-Identifier: Apache-2.0
#pragma once

// Time at the door of the program: what photos and users write, to UTC and back
// (docs/conventions.md#time). Zones are those of the system's IANA database.
//
// Where clocks are put forward some local times do not exist; where they are put back
// some occur twice. Neither is guessed: both are errors that say which, when the clocks
// changed and what to write instead. GPS time, which is UTC, decides for a photo that has
// it. After 2037, where the database ends, the rules of the years before go on.

#include "relight/base/instant.h"
#include "relight/photo/photo_facts.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// A moment, and what the clocks of its place are ahead of UTC.
struct LocalTime {
  Instant utc = {};
  std::chrono::minutes offset = {};
};

// Of the IANA database, or a fixed offset.
struct Zone {
  std::string name;  // "Europe/Paris", "+02:00".
  std::optional<std::chrono::minutes> fixed_offset =
      {};  // Local minus UTC; unset: by the database.
};

// "Europe/Paris" | "+02:00" | "-0330" | "Z". Throws OptionError.
Zone ParseZone(const std::string& text);

LocalTime InZone(Instant utc, const Zone& zone);

// How often clocks in a zone show a time, and what it can mean.
struct ClockReading {
  enum class Kind { kOnce, kTwice, kNever };
  Kind kind = Kind::kOnce;
  // kOnce: the time itself, in both. kTwice: with the clocks before and after the change.
  // kNever: what a clock meant that was not changed yet, or was changed too early; the
  // later of the two moments first.
  LocalTime first, second;
  std::string why = {};  // "2011-03-27T02:30:00 did not exist in …"; empty: kOnce.
};
ClockReading ReadClock(WallClock local, const Zone& zone);

// Throws OptionError with ClockReading::why for a time that is not there exactly once.
LocalTime FromWallClock(WallClock local, const Zone& zone);
inline WallClock WallClockOf(const LocalTime& time) {
  return WallClock(time.utc.time_since_epoch() + time.offset);
}

// A moment as users write it:
//   17:00  17:00:30               on the day of `reference`
//   2011-09-23T17:00              any day; seconds and fractions allowed; a blank for the
//   T …+02:00  …Z                   after either: with its offset from UTC +3h  -90m
//   +1h30m  +2d  same  from `reference`
// Without an offset of its own a time is in `zone`, else at the offset of `reference`.
// Throws OptionError that lists these forms.
LocalTime ParseWhen(const std::string& text,
                    const LocalTime& reference,
                    const std::optional<Zone>& zone = {});

// "2011-09-23T17:00:00+02:00"; milliseconds only when there are any.
std::string FormatLocal(const LocalTime& time);
// "+02:00".
std::string FormatOffset(std::chrono::minutes offset);

// When a photo was taken, and how that is known.
struct CaptureTime {
  LocalTime time;
  std::optional<Zone>
      zone;  // For target times: named by the user, else the photo's offset.
  // A rough place, known only by the name of the zone; for a photo without a place.
  std::optional<Place> approximate_place;
  std::string source;              // "DateTimeOriginal and OffsetTimeOriginal".
  std::vector<std::string> notes;  // Assumptions, one sentence each.
};

// DateTimeOriginal with OffsetTimeOriginal; else GPS date and time; else DateTimeOriginal
// in the zone `zone_text`. `taken_text`, a time as for ParseWhen, wins over the photo's
// own. Throws InputError: "no capture time in EXIF; give --taken", "time without zone;
// give --zone", a time of the photo's that the zone's clocks showed twice or never;
// OptionError for texts that are neither zone nor time, or name such a time.
CaptureTime ResolveCaptureTime(const PhotoFacts& facts,
                               const std::optional<std::string>& zone_text = {},
                               const std::optional<std::string>& taken_text = {});

// What GPS time says against the photo's clock in the zone `zone`, or at the photo's own
// offset: nothing when they agree within kGpsLag, or one of them is not there. Else one
// sentence with the photo, both moments and the offset that would agree.
std::optional<std::string> ZoneAgainstGps(const PhotoFacts& facts,
                                          const std::optional<Zone>& zone);
// A photo carries the time of the last fix, which may be some minutes old; zones differ
// by a quarter of an hour at least.
inline constexpr std::chrono::minutes kGpsLag{10};

// The principal place of an IANA zone, by the database's own table.
std::optional<Place> PlaceOfZone(const Zone& zone);

// "40.35,-74.65", "40.35N, 74.65W", "40.35,-74.65,20" (m). Throws OptionError.
Place ParsePlace(const std::string& text);

// "210", "210.5", "SW", "NNE": degrees clockwise from true north, [0, 360). Throws
// OptionError.
double ParseHeading(const std::string& text);

}  // namespace relight
