// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/capture_time.h"

#include "relight/base/error.h"

#include <date/tz.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

using namespace std::chrono;

constexpr char kWhenForms[] =
    "17:00, 17:00:30, 2011-09-23T17:00, either with an offset like +02:00 or Z, +3h, "
    "-90m, "
    "+1h30m or same";

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  return text;
}

// "+02:00", "-0330", "+2", "Z".
std::optional<minutes> OffsetIn(const std::string& text) {
  if (text == "Z" || text == "z") return minutes(0);
  static const std::regex kForm(R"(([+-])(\d{1,2})(?::?(\d{2}))?)");
  std::smatch part;
  if (!std::regex_match(text, part, kForm)) return std::nullopt;
  const hours h(std::stoi(part[2]));
  const minutes m(part[3].matched ? std::stoi(part[3]) : 0);
  if (h > hours(15) || m > minutes(59)) return std::nullopt;
  return part[1] == "-" ? -(h + m) : h + m;
}

const date::time_zone* Located(const Zone& zone) {
  try {
    return date::locate_zone(zone.name);
  } catch (const std::exception&) {
    return nullptr;
  }
}

const date::time_zone& Found(const Zone& zone) {
  const date::time_zone* found = Located(zone);
  if (found == nullptr) {
    throw OptionError(
        "zone must be an IANA name like Europe/Paris or an offset like +02:00, "
        "got " +
        zone.name);
  }
  return *found;
}

// The compiled database ends with 2037. A calendar comes back every 28 years, weekdays
// and leap years alike, until 2100: there the rules of today are asked of such a year.
days CalendarShift(milliseconds since_epoch) {
  const auto end = date::sys_days(date::year(2038) / 1 / 1).time_since_epoch();
  constexpr days kTwentyEightYears(28 * 365 + 7);
  days shift(0);
  while (since_epoch - shift >= end) shift += kTwentyEightYears;
  return shift;
}

milliseconds At(hours h, minutes m, seconds s) { return h + m + s; }

// What a text says before it is put on a day and in a zone.
struct WrittenTime {
  std::optional<WallClock> day;  // Midnight of it.
  milliseconds of_day{0};
  std::optional<minutes> offset;
};

std::optional<WrittenTime> ReadWritten(const std::string& text) {
  static const std::regex kForm(R"((?:(\d{4})[-:](\d{2})[-:](\d{2})[Tt ])?)"
                                R"((\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d{1,9}))?)?)"
                                R"( ?([Zz]|[+-]\d{2}(?::?\d{2})?)?)");
  std::smatch part;
  if (!std::regex_match(text, part, kForm)) return std::nullopt;
  WrittenTime written;
  if (part[1].matched) {
    const year_month_day date{year(std::stoi(part[1])),
                              month(static_cast<unsigned>(std::stoi(part[2]))),
                              day(static_cast<unsigned>(std::stoi(part[3])))};
    if (!date.ok()) return std::nullopt;
    written.day = WallClock(sys_days(date).time_since_epoch());
  }
  const int h = std::stoi(part[4]), m = std::stoi(part[5]);
  const int s = part[6].matched ? std::stoi(part[6]) : 0;
  if (h > 23 || m > 59 || s > 59) return std::nullopt;
  written.of_day = At(hours(h), minutes(m), seconds(s));
  if (part[7].matched) {
    written.of_day += milliseconds(std::stoi((part[7].str() + "000").substr(0, 3)));
  }
  if (part[8].matched) {
    written.offset = OffsetIn(part[8]);
    if (!written.offset) return std::nullopt;
  }
  return written;
}

// "+1h30m", "-90m", "+2d".
std::optional<milliseconds> ReadShift(const std::string& text) {
  static const std::regex kForm(
      R"(([+-])(?:(\d{1,4})d)?(?:(\d{1,5})h)?(?:(\d{1,6})(?:m|min))?(?:(\d{1,7})s)?)");
  std::smatch part;
  if (text.size() < 3 || !std::regex_match(text, part, kForm)) return std::nullopt;
  const auto number = [&](int i) { return part[i].matched ? std::stoi(part[i]) : 0; };
  const milliseconds shift =
      days(number(2)) + hours(number(3)) + minutes(number(4)) + seconds(number(5));
  return part[1] == "-" ? -shift : shift;
}

LocalTime AtOffset(WallClock local, minutes offset) {
  return {.utc = Instant(local.time_since_epoch() - offset), .offset = offset};
}

WallClock MidnightOf(WallClock local) {
  return WallClock(floor<days>(local.time_since_epoch()));
}

// ISO 6709 of the zone tables: "+4852+00220", "+404251-0740023".
std::optional<Place> ParseIso6709(const std::string& text) {
  static const std::regex kForm(
      R"(([+-])(\d{2})(\d{2})(\d{2})?([+-])(\d{3})(\d{2})(\d{2})?)");
  std::smatch part;
  if (!std::regex_match(text, part, kForm)) return std::nullopt;
  const auto angle = [&](int sign) {
    const double seconds = part[sign + 3].matched ? std::stod(part[sign + 3]) : 0.0;
    const double deg =
        std::stod(part[sign + 1]) + std::stod(part[sign + 2]) / 60.0 + seconds / 3600.0;
    return part[sign] == "-" ? -deg : deg;
  };
  return Place{.latitude_deg = angle(1), .longitude_deg = angle(5)};
}

std::string InWords(minutes offset) { return "UTC" + FormatOffset(offset); }

}  // namespace

Zone ParseZone(const std::string& text) {
  if (const auto offset = OffsetIn(text)) {
    return {.name = FormatOffset(*offset), .fixed_offset = offset};
  }
  Zone zone{.name = text, .fixed_offset = std::nullopt};
  // A name becomes a path in the database's folder: nothing that leads out of it
  static const std::regex kName(R"([A-Za-z][A-Za-z0-9_+-]*(/[A-Za-z0-9_+-]+)*)");
  if (!std::regex_match(text, kName) || Located(zone) == nullptr) {
    throw OptionError(
        "zone must be an IANA name like Europe/Paris or an offset like +02:00, "
        "got " +
        text);
  }
  return zone;
}

LocalTime InZone(Instant utc, const Zone& zone) {
  if (zone.fixed_offset) return {.utc = utc, .offset = *zone.fixed_offset};
  const days shift = CalendarShift(utc.time_since_epoch());
  const auto info = Found(zone).get_info(
      date::sys_seconds(floor<seconds>(utc.time_since_epoch() - shift)));
  return {.utc = utc, .offset = round<minutes>(info.offset)};
}

ClockReading ReadClock(WallClock local, const Zone& zone) {
  ClockReading reading;
  if (zone.fixed_offset) {
    reading.first = reading.second = AtOffset(local, *zone.fixed_offset);
    return reading;
  }
  const days shift = CalendarShift(local.time_since_epoch());
  const auto info = Found(zone).get_info(
      date::local_seconds(floor<seconds>(local.time_since_epoch() - shift)));
  const minutes before = round<minutes>(info.first.offset);
  reading.first = reading.second = AtOffset(local, before);
  if (info.result == date::local_info::unique) return reading;

  // The change, as the clocks on the wall showed it
  const minutes after = round<minutes>(info.second.offset);
  const Instant changed(info.first.end.time_since_epoch() + shift);
  const auto clock = [&](minutes offset) {
    return FormatLocal({changed, offset}).substr(11, 5);
  };
  const std::string from_to = "from " + clock(before) + " to " + clock(after);
  const std::string text = FormatLocal({Instant(local.time_since_epoch()), minutes(0)});
  reading.why = text.substr(0, text.size() - 6);
  if (info.result == date::local_info::ambiguous) {
    reading.kind = ClockReading::Kind::kTwice;
    reading.second = AtOffset(local, after);
    reading.why += " occurred twice in " + zone.name +
                   ", where the clocks were put back then, " + from_to + "; write " +
                   FormatLocal(reading.first) + " for the first, " +
                   FormatLocal(reading.second) + " for the second";
  } else {
    reading.kind = ClockReading::Kind::kNever;
    reading.first = InZone(AtOffset(local, before).utc, zone);
    reading.second = InZone(AtOffset(local, after).utc, zone);
    reading.why += " did not exist in " + zone.name +
                   ", where the clocks were put forward then, " + from_to + "; write " +
                   FormatLocal(reading.first) +
                   " for a clock that was not changed yet, " +
                   FormatLocal(reading.second) + " for one that was changed too early";
  }
  return reading;
}

LocalTime FromWallClock(WallClock local, const Zone& zone) {
  const ClockReading reading = ReadClock(local, zone);
  if (reading.kind != ClockReading::Kind::kOnce) throw OptionError(reading.why);
  return reading.first;
}

LocalTime ParseWhen(const std::string& text,
                    const LocalTime& reference,
                    const std::optional<Zone>& zone) {
  const auto in_zone = [&](Instant utc) {
    return zone ? InZone(utc, *zone) : LocalTime{.utc = utc, .offset = reference.offset};
  };
  if (text == "same") return in_zone(reference.utc);
  if (const auto shift = ReadShift(text)) return in_zone(reference.utc + *shift);
  const auto written = ReadWritten(text);
  if (!written) {
    throw OptionError("a time is written " + std::string(kWhenForms) + "; got " + text);
  }
  if (written->offset) {
    // "17:00+02:00" is on the day that the reference has at that offset
    const WallClock there(reference.utc.time_since_epoch() + *written->offset);
    const WallClock day = written->day.value_or(MidnightOf(there));
    return AtOffset(day + written->of_day, *written->offset);
  }
  const WallClock day =
      written->day.value_or(MidnightOf(WallClockOf(in_zone(reference.utc))));
  const WallClock local = day + written->of_day;
  return zone ? FromWallClock(local, *zone) : AtOffset(local, reference.offset);
}

std::string FormatOffset(minutes offset) {
  const long count = std::labs(static_cast<long>(offset.count()));
  char text[64];
  std::snprintf(text,
                sizeof text,
                "%c%02ld:%02ld",
                offset < minutes(0) ? '-' : '+',
                count / 60,
                count % 60);
  return text;
}

std::string FormatLocal(const LocalTime& time) {
  const WallClock local = WallClockOf(time);
  const auto day = floor<days>(local.time_since_epoch());
  const year_month_day date{sys_days(day)};
  const hh_mm_ss of_day{local.time_since_epoch() - day};
  char text[64];
  std::snprintf(text,
                sizeof text,
                "%04d-%02u-%02uT%02d:%02d:%02d",
                int(date.year()),
                unsigned(date.month()),
                unsigned(date.day()),
                static_cast<int>(of_day.hours().count()),
                static_cast<int>(of_day.minutes().count()),
                static_cast<int>(of_day.seconds().count()));
  std::string out = text;
  if (const long ms = static_cast<long>(of_day.subseconds().count()); ms != 0) {
    std::snprintf(text, sizeof text, ".%03ld", ms);
    out += text;
  }
  return out + FormatOffset(time.offset);
}

CaptureTime ResolveCaptureTime(const PhotoFacts& facts,
                               const std::optional<std::string>& zone_text,
                               const std::optional<std::string>& taken_text) {
  const auto refuse = [&](const std::string& why) {
    throw InputError((facts.file.empty() ? "photo" : facts.file) + ": " + why);
  };
  CaptureTime capture;
  if (zone_text) capture.zone = ParseZone(*zone_text);
  if (capture.zone && !facts.place) {
    capture.approximate_place = PlaceOfZone(*capture.zone);
    if (capture.approximate_place) {
      char where[64];
      std::snprintf(where,
                    sizeof where,
                    "%.2f,%.2f",
                    capture.approximate_place->latitude_deg,
                    capture.approximate_place->longitude_deg);
      capture.notes.push_back("The place is only known by the time zone " +
                              capture.zone->name + ": taken as " + where +
                              ". Give --place to have it right.");
    }
  }

  if (taken_text) {
    capture.source = "--taken";
    const auto written = ReadWritten(*taken_text);
    if (!written) {
      throw OptionError(
          "taken must be a time like 2011-09-23T17:00 or 2011-09-23T17:00+02:00, or "
          "17:00 for "
          "a photo that knows its day; got " +
          *taken_text);
    }
    if (!written->day && !facts.local_time) {
      refuse("no day of capture in EXIF; give --taken with the date, like 2011-09-23T" +
             *taken_text);
    }
    const WallClock local =
        written->day.value_or(facts.local_time ? MidnightOf(*facts.local_time)
                                               : WallClock()) +
        written->of_day;
    if (written->offset) {
      capture.time = AtOffset(local, *written->offset);
    } else if (capture.zone) {
      try {
        capture.time = FromWallClock(local, *capture.zone);
      } catch (const OptionError& error) {
        throw OptionError(std::string("taken: ") + error.what());
      }
    } else if (facts.offset) {
      capture.time = AtOffset(local, *facts.offset);
      capture.notes.push_back(
          "--taken has no zone of its own: it is taken at the photo's, " +
          InWords(*facts.offset) + ".");
    } else {
      refuse("time without zone; give --zone, or an offset with --taken, like " +
             *taken_text + "+02:00");
    }
  } else if (facts.local_time && facts.offset) {
    capture.source = "DateTimeOriginal and OffsetTimeOriginal";
    capture.time = AtOffset(*facts.local_time, *facts.offset);
    if (capture.zone) {
      const LocalTime there = InZone(capture.time.utc, *capture.zone);
      if (there.offset != *facts.offset) {
        capture.notes.push_back(
            "The photo says " + InWords(*facts.offset) + ", " + capture.zone->name +
            " had " + InWords(there.offset) +
            "; the moment is the photo's, the clocks are the zone's.");
        capture.time = there;
      }
    }
  } else if (facts.gps_time) {
    capture.source = "GPS date and time";
    if (capture.zone) {
      capture.time = InZone(*facts.gps_time, *capture.zone);
      if (facts.local_time) {
        // GPS time decides what the clock alone leaves open
        const ClockReading reading = ReadClock(*facts.local_time, *capture.zone);
        if (reading.kind != ClockReading::Kind::kOnce) {
          capture.notes.push_back(reading.why.substr(0, reading.why.find(';')) +
                                  "; GPS time decides: " + FormatLocal(capture.time) +
                                  ".");
        }
      }
    } else if (facts.local_time) {
      // The camera's clock shows local time: its distance to GPS, to the quarter of an
      // hour
      const auto ahead =
          facts.local_time->time_since_epoch() - facts.gps_time->time_since_epoch();
      const minutes offset =
          15 * round<duration<int, std::ratio<900>>>(ahead).count() * minutes(1);
      const bool plausible = offset >= hours(-12) && offset <= hours(14) &&
                             abs(ahead - offset) <= minutes(5);
      if (!plausible) {
        refuse("its clock and its GPS time do not fit together (" +
               FormatLocal(AtOffset(*facts.local_time, minutes(0))).substr(0, 19) + ", " +
               FormatLocal({.utc = *facts.gps_time}) + "); give --taken with an offset");
      }
      capture.time = {.utc = *facts.gps_time, .offset = offset};
      capture.notes.push_back("The zone is taken from the camera's clock against GPS: " +
                              InWords(offset) + ".");
    } else if (facts.place) {
      const hours offset(std::lround(facts.place->longitude_deg / 15.0));
      capture.time = {.utc = *facts.gps_time, .offset = offset};
      capture.notes.push_back(
          "The zone is guessed from the longitude: " + InWords(offset) +
          ". Give --zone for the time that clocks showed.");
    } else {
      capture.time = {.utc = *facts.gps_time};
      capture.notes.push_back(
          "Only UTC is known: times are UTC. Give --zone for local time.");
    }
  } else if (facts.local_time && capture.zone) {
    capture.source = "DateTimeOriginal and --zone";
    const ClockReading reading = ReadClock(*facts.local_time, *capture.zone);
    if (reading.kind != ClockReading::Kind::kOnce) {
      refuse("its time " + reading.why + ", with --taken or taken in capture.toml");
    }
    capture.time = reading.first;
  } else if (facts.local_time) {
    refuse("time without zone; give --zone, like --zone Europe/Paris or --zone +02:00");
  } else {
    refuse("no capture time in EXIF; give --taken, like --taken 2011-09-23T17:00+02:00");
  }

  if (!taken_text) {
    if (const auto doubt = ZoneAgainstGps(facts, capture.zone))
      capture.notes.push_back(*doubt);
  }
  if (!capture.zone) {
    capture.zone = Zone{FormatOffset(capture.time.offset), capture.time.offset};
  }
  return capture;
}

std::optional<std::string> ZoneAgainstGps(const PhotoFacts& facts,
                                          const std::optional<Zone>& zone) {
  if (!facts.local_time || !facts.gps_time || (!facts.offset && !zone)) return {};
  const Instant gps = *facts.gps_time;
  const auto agree = [&](Instant utc) { return abs(utc - gps) <= kGpsLag; };
  LocalTime clock;
  if (facts.offset) {
    clock = AtOffset(*facts.local_time, *facts.offset);
  } else {
    const ClockReading reading = ReadClock(*facts.local_time, *zone);
    clock = agree(reading.second.utc) ? reading.second : reading.first;
  }
  if (agree(clock.utc)) return {};

  // What would agree: zones are ahead of UTC by whole quarters of an hour
  const auto ahead = facts.local_time->time_since_epoch() - gps.time_since_epoch();
  const minutes offset =
      15 * round<duration<int, std::ratio<900>>>(ahead).count() * minutes(1);
  const bool is_zone = offset >= hours(-12) && offset <= hours(14) &&
                       abs(ahead - offset) <= std::min(kGpsLag, minutes(5));
  const std::string used = facts.offset ? "its own offset" : "the zone " + zone->name;
  return (facts.file.empty() ? "the photo" : facts.file) + ": by " + used +
         " it was taken at " + FormatLocal({clock.utc, minutes(0)}) + ", by GPS at " +
         FormatLocal({gps, minutes(0)}) + "; " +
         (is_zone ? "the offset " + FormatOffset(offset) +
                        " would agree: mend --zone, zone in capture.toml or the photo's "
                        "OffsetTimeOriginal, if the camera's clock was right"
                  : "no zone would agree: its clock was wrong, or its GPS time is old; "
                    "give the time with --taken");
}

std::optional<Place> PlaceOfZone(const Zone& zone) {
  if (zone.fixed_offset) return std::nullopt;
  const fs::path folder = "/usr/share/zoneinfo";

  // The name itself, and what it is another name of
  std::vector<std::string> names = {zone.name};
  std::error_code status;
  const fs::path target = fs::canonical(folder / zone.name, status);
  if (!status) names.push_back(fs::relative(target, folder, status).string());
  for (const std::string& name : names) {
    for (const char* table : {"zone1970.tab", "zone.tab"}) {
      std::ifstream in(folder / table);
      std::string line;
      while (std::getline(in, line)) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream columns(line);
        std::string countries, place, zone_name;
        columns >> countries >> place >> zone_name;
        if (zone_name == name) return ParseIso6709(place);
      }
    }
  }
  return std::nullopt;
}

Place ParsePlace(const std::string& text) {
  static const std::regex kForm(
      R"(\s*([+-]?\d+(?:\.\d*)?)\s*([NSns]?)\s*,\s*([+-]?\d+(?:\.\d*)?)\s*([EWew]?)\s*)"
      R"((?:,\s*([+-]?\d+(?:\.\d*)?)\s*m?\s*)?)");
  std::smatch part;
  const auto refuse = [&]() {
    throw OptionError(
        "place must be LAT,LON in degrees, north and east positive, like 40.35,-74.65 "
        "(latitude -90 to 90, longitude -180 to 180); got " +
        text);
  };
  if (!std::regex_match(text, part, kForm)) refuse();
  Place place{.latitude_deg = std::stod(part[1]), .longitude_deg = std::stod(part[3])};
  if (Upper(part[2]) == "S") place.latitude_deg = -place.latitude_deg;
  if (Upper(part[4]) == "W") place.longitude_deg = -place.longitude_deg;
  if (part[5].matched) place.altitude_m = std::stod(part[5]);
  if (std::abs(place.latitude_deg) > 90.0 || std::abs(place.longitude_deg) > 180.0)
    refuse();
  return place;
}

double ParseHeading(const std::string& text) {
  static constexpr std::array kPoints = {"N",
                                         "NNE",
                                         "NE",
                                         "ENE",
                                         "E",
                                         "ESE",
                                         "SE",
                                         "SSE",
                                         "S",
                                         "SSW",
                                         "SW",
                                         "WSW",
                                         "W",
                                         "WNW",
                                         "NW",
                                         "NNW"};
  const auto point = std::find(kPoints.begin(), kPoints.end(), Upper(text));
  if (point != kPoints.end()) return 22.5 * static_cast<double>(point - kPoints.begin());
  static const std::regex kNumber(R"(\d{1,3}(?:\.\d*)?)");
  if (!std::regex_match(text, kNumber) || std::stod(text) > 360.0) {
    throw OptionError(
        "heading must be degrees clockwise from true north, 0 to 360, or a point of the "
        "compass like SW; got " +
        text);
  }
  return std::fmod(std::stod(text), 360.0);
}

}  // namespace relight
