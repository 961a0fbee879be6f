// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/day_plan.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/photo/photo_facts.h"
#include "relight/sky/light_in_words.h"
#include "relight/sky/sun_times.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <set>
#include <string_view>
#include <system_error>

namespace relight {
namespace fs = std::filesystem;
namespace {

using std::chrono::minutes;
using std::chrono::year_month_day;

constexpr minutes kDay = std::chrono::hours(24);
constexpr std::size_t kMostFrames = 10000;
constexpr double kSecondsPerFrame = 0.4, kSecondsPerMegapixel = 0.6;

// All of `text` as a number of digits.
std::optional<int> WholeNumber(std::string_view text) {
  int value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && value >= 0 ? std::optional(value) : std::nullopt;
}

[[noreturn]] void RefuseHours(const std::string& text) {
  throw OptionError(
      "--hours must be FIRST..LAST, each an hour of the clock (9, 17:30), sunrise or "
      "sunset, the first before the last; got \"" +
      text + "\"");
}

// "9", "17:30".
std::optional<minutes> ClockTime(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto hour = WholeNumber(text.substr(0, colon));
  const auto minute = colon == std::string_view::npos
                          ? std::optional(0)
                          : WholeNumber(text.substr(colon + 1));
  if (!hour || !minute || *minute > 59) return {};
  const minutes time = std::chrono::hours(*hour) + minutes(*minute);
  return time <= kDay ? std::optional(time) : std::nullopt;
}

// "30m", "1h", "1h30m".
minutes ParseStep(const std::string& text) {
  std::string_view rest = text;
  minutes step{0};
  for (const auto& [unit, length] : {std::pair('h', 60), std::pair('m', 1)}) {
    const std::size_t at = rest.find(unit);
    if (at == std::string_view::npos) continue;
    const auto count = WholeNumber(rest.substr(0, at));
    if (!count || *count > 24 * 60) break;
    step += minutes(*count * length);
    rest.remove_prefix(at + 1);
  }
  if (!rest.empty() || step < minutes(1) || step > kDay) {
    throw OptionError(
        "--every must be a time from 1m to 24h, as 30m, 1h or 1h30m; got \"" + text +
        "\"");
  }
  return step;
}

std::string TwoDigits(unsigned value) {
  return (value < 10 ? "0" : "") + std::to_string(value);
}

std::string DateText(year_month_day date) {
  return std::to_string(static_cast<int>(date.year())) + "-" +
         TwoDigits(static_cast<unsigned>(date.month())) + "-" +
         TwoDigits(static_cast<unsigned>(date.day()));
}

// "2011-07-22T17:30:00+02:00" as the name of a file.
std::string NameOf(const LocalTime& time) {
  const std::string text = FormatLocal(time);
  return text.substr(0, 10) + "_" + text.substr(11, 2) + text.substr(14, 2);
}

// "+0200".
std::string OffsetName(minutes offset) {
  std::string text = FormatOffset(offset);
  text.erase(text.find(':'), 1);
  return text;
}

// What the user said of hours and frames.
CommandWords WordsOf(const DayRequest& r) {
  const DayRequest standard;
  CommandWords said{"day", {}};
  said.Add("--dates", r.dates);
  const auto add =
      [&](const char* flag, const std::string& value, const std::string& left) {
        if (value != left) said.Add(flag, std::optional(value));
      };
  add("--hours", r.hours, standard.hours);
  add("--every", r.every, standard.every);
  add("--exposure", r.exposure, standard.exposure);
  add("--format", r.format, standard.format);
  if (r.alone) said.Add("--alone");
  said.Add("--over", r.over);
  said.Add("-o", r.output);
  return said;
}

// Minutes of the place's clock since the day's midnight.
minutes ClockOf(Instant at, year_month_day date, const ViewPlan& view) {
  const LocalTime local =
      view.zone ? InZone(at, *view.zone) : LocalTime{at, view.input.time->offset};
  return std::chrono::floor<minutes>(WallClockOf(local).time_since_epoch() -
                                     std::chrono::sys_days(date).time_since_epoch());
}

// The moments at which the place's clocks show a time: one, two where clocks are put
// back, none where they are put forward.
std::vector<LocalTime> MomentsOf(WallClock local, const ViewPlan& view) {
  const minutes own = view.input.time ? view.input.time->offset : minutes(0);
  const ClockReading reading =
      ReadClock(local, view.zone.value_or(Zone{FormatOffset(own), own}));
  if (reading.kind == ClockReading::Kind::kNever) return {};
  if (reading.kind == ClockReading::Kind::kOnce) return {reading.first};
  return {reading.first, reading.second};
}

// The frames of one date.
void AddDate(year_month_day date, DayPlan& plan) {
  const ViewPlan& view = plan.view;
  const SunTimes sun = SunTimesOf(date, *view.place);
  // Where the sun neither rises nor sets it is up all day, or the hours are left out
  const auto clock = [&](const std::optional<Instant>& at, minutes otherwise) {
    return at ? std::clamp(ClockOf(*at, date, view), minutes(0), kDay) : otherwise;
  };
  const auto hours = HoursOf(plan.request.hours,
                             plan.request.every,
                             clock(sun.sunrise, minutes(0)),
                             clock(sun.sunset, kDay));
  std::vector<LocalTime> moments;
  for (const minutes at : hours) {
    const WallClock local(std::chrono::sys_days(date).time_since_epoch() + at);
    for (const LocalTime& moment : MomentsOf(local, view)) moments.push_back(moment);
  }
  std::sort(moments.begin(), moments.end(), [](const LocalTime& a, const LocalTime& b) {
    return a.utc < b.utc;
  });
  for (const LocalTime& moment : moments) {
    DayFrame frame;
    frame.light.time = moment;
    frame.light.sun = SolarPositionAt(moment.utc, *view.place);
    frame.light.words =
        LightInFewWords(frame.light.sun.azimuth_rad - RadFromDeg(view.heading_deg),
                        frame.light.sun.elevation_rad);
    frame.name = NameOf(moment);
    std::vector<DayFrame>& frames =
        DegFromRad(frame.light.sun.elevation_rad) > LowestTargetSun(view.options.light)
            ? plan.frames
            : plan.left_out;
    // 24:00 is 0:00 of the next date; an hour that clocks show twice has two frames
    const auto recent =
        static_cast<std::ptrdiff_t>(std::min<std::size_t>(frames.size(), 24 * 60));
    const auto same =
        std::find_if(frames.end() - recent, frames.end(), [&](const DayFrame& f) {
          return f.name == frame.name;
        });
    if (same != frames.end()) {
      if (same->light.time->utc == moment.utc) continue;
      frame.name += OffsetName(moment.offset);
    }
    frames.push_back(frame);
  }
  if (plan.frames.size() > kMostFrames) {
    throw OptionError("more than " + std::to_string(kMostFrames) +
                      " frames; take fewer --dates or a longer --every");
  }
}

// Names of the first and last, for one line.
std::string ListOf(const std::vector<DayFrame>& frames) {
  if (frames.size() <= 4) {
    std::string list;
    for (const DayFrame& f : frames) list += (list.empty() ? "" : ", ") + f.name;
    return list;
  }
  return frames.front().name + " to " + frames.back().name;
}

// Throws InputError unless the folder, or the first above it that is there, is a folder
// that may be written to: said before the work.
void RequireFolder(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder);
  while (!fs::exists(there, error) && !error && there.has_relative_path())
    there = there.parent_path();
  if (!error && !fs::is_directory(there, error)) {
    throw InputError(there.string() + ": is a file; give the name of a folder with -o");
  }
  if (!error && access(there.c_str(), W_OK | X_OK) != 0)
    error.assign(errno, std::generic_category());
  if (!error) return;
  throw InputError(folder.string() + ": cannot be written to: " + error.message() +
                   "; choose a folder you may write to with -o");
}

}  // namespace

std::vector<minutes> HoursOf(const std::string& hours,
                             const std::string& every,
                             minutes sunrise,
                             minutes sunset) {
  const minutes step = ParseStep(every);
  const std::size_t dots = hours.find("..");
  if (dots == std::string::npos) RefuseHours(hours);
  const auto end = [&](std::string_view text) {
    if (text == "sunrise" || text == "sunset") {
      // The sun is up between the two: round inwards
      const minutes at = text == "sunrise" ? sunrise : sunset;
      return text == "sunrise" ? (at / step + 1) * step
                               : std::max(at - minutes(1), minutes(0)) / step * step;
    }
    const auto time = ClockTime(text);
    if (!time) RefuseHours(hours);
    return *time;
  };
  const std::string_view text = hours;
  const minutes first = end(text.substr(0, dots));
  const minutes last = end(text.substr(dots + 2));
  const bool by_sun = text.find("sun") != std::string_view::npos;
  if (first > last && !by_sun) RefuseHours(hours);
  std::vector<minutes> all;
  for (minutes at = first; at <= last; at += step) all.push_back(at);
  return all;
}

std::vector<year_month_day> ParseDates(const std::string& text) {
  std::set<year_month_day> dates;  // In the order of time, each once
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    const auto year = part.size() == 10 && part[4] == '-' && part[7] == '-'
                          ? WholeNumber(part.substr(0, 4))
                          : std::nullopt;
    const auto month = year ? WholeNumber(part.substr(5, 2)) : std::nullopt;
    const auto day = year ? WholeNumber(part.substr(8, 2)) : std::nullopt;
    const year_month_day date(
        std::chrono::year(year.value_or(0)),
        std::chrono::month(static_cast<unsigned>(month.value_or(0))),
        std::chrono::day(static_cast<unsigned>(day.value_or(0))));
    if (!year || !month || !day || !date.ok()) {
      throw OptionError(
          "--dates must be days as 2011-07-22, with commas between; got \"" + text +
          "\"");
    }
    dates.insert(date);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  return {dates.begin(), dates.end()};
}

DayPlan PlanDay(const DayRequest& request) {
  DayPlan plan;
  plan.request = request;
  RequireExposure(request.exposure);
  if (request.format != "png" && request.format != "exr") {
    throw OptionError("--format must be png or exr, got \"" + request.format + "\"");
  }
  if (request.alone && request.over) {
    throw OptionError(
        "--alone is the tree on nothing, --over on another photo; give one of them");
  }
  std::optional<std::vector<year_month_day>> dates;
  if (request.dates) dates = ParseDates(*request.dates);
  HoursOf(request.hours, request.every, minutes(0), kDay);
  plan.view = PlanView(request, true, WordsOf(request));
  plan.notes = plan.view.notes;

  // The hours
  if (!dates) {
    dates = {year_month_day(std::chrono::floor<std::chrono::days>(
        std::chrono::sys_time<std::chrono::milliseconds>(
            WallClockOf(*plan.view.input.time).time_since_epoch())))};
  }
  for (const year_month_day date : *dates) AddDate(date, plan);
  if (plan.frames.empty() && plan.left_out.empty()) {
    throw InputError("no clock showed " + request.hours + " on " +
                     DateText(dates->front()) +
                     ", for clocks were put forward then; choose other --hours or "
                     "--dates");
  }
  if (plan.frames.empty()) {
    throw InputError("the sun is below the horizon at every hour of " + request.hours +
                     " on " + DateText(dates->front()) +
                     (dates->size() > 1 ? " and the other dates" : "") +
                     "; choose other --hours or --dates");
  }
  if (!plan.left_out.empty()) {
    const std::size_t count = plan.left_out.size();
    plan.notes.push_back(
        std::to_string(count) + (count == 1 ? " hour is" : " hours are") +
        " left out, for the sun is below the horizon: " + ListOf(plan.left_out));
  }

  // Where to, and on what
  if (request.output) {
    plan.folder = *request.output;
  } else {
    const std::string name = plan.view.name + "_day";
    plan.folder = fs::is_directory(request.source) ? request.source / "out" / name
                                                   : plan.view.photo.parent_path() / name;
  }
  RequireFolder(plan.folder);
  const double frame_s = kSecondsPerFrame + kSecondsPerMegapixel * plan.view.megapixels;
  const auto count = static_cast<double>(plan.frames.size());
  plan.view.stages.push_back({"frames",
                              std::to_string(plan.frames.size()) + " frames of " +
                                  plan.view.name + " to " + plan.folder.string(),
                              1 + count * frame_s});
  plan.view.stages.push_back({"page",
                              "contact sheet, video and page of all frames",
                              1 + 0.5 * count * (0.1 + 0.1 * plan.view.megapixels)});
  return plan;
}

}  // namespace relight
