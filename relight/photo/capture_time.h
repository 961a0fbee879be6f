// SPDX-License-Identifier: Apache-2.0
#pragma once

// Time at the door of the program: what photos and users write, to UTC and back
// (docs/conventions.md#time). Zones are those of the system's IANA database.
//
// Where clocks are put forward some local times do not exist: they are moved on by the
// gap. Where clocks are put back some occur twice: the first is taken. Both are said in
// `note`. After 2037, where the database ends, the rules of the years before go on.

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
  std::string note = {};  // What had to be assumed of a clock change; mostly empty.
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
// give
// --zone"; OptionError for texts that are neither zone nor time.
CaptureTime ResolveCaptureTime(const PhotoFacts& facts,
                               const std::optional<std::string>& zone_text = {},
                               const std::optional<std::string>& taken_text = {});

// The principal place of an IANA zone, by the database's own table.
std::optional<Place> PlaceOfZone(const Zone& zone);

// "40.35,-74.65", "40.35N, 74.65W", "40.35,-74.65,20" (m). Throws OptionError.
Place ParsePlace(const std::string& text);

// "210", "210.5", "SW", "NNE": degrees clockwise from true north, [0, 360). Throws
// OptionError.
double ParseHeading(const std::string& text);

}  // namespace relight
