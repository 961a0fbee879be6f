// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_times.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/cameras/another_tree.h"
#include "relight/photo/photo_facts.h"
#include "relight/sky/light_in_words.h"
#include "relight/sky/solar_position.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

namespace relight {
namespace fs = std::filesystem;
namespace {

using std::chrono::minutes;

constexpr minutes kLongestApart{60};
constexpr double kGpsErrors_m = 30.0;
constexpr double kEarthRadius_m = 6371000.0;

std::string Number(double value) { return std::to_string(std::lround(value)); }

std::string Duration(minutes length) {
  const auto h = length.count() / 60, m = length.count() % 60;
  return (h > 0 ? std::to_string(h) + " h " : "") + std::to_string(m) + " min";
}

std::string DayOf(const LocalTime& time) { return FormatLocal(time).substr(0, 10); }
std::string ClockOf(const LocalTime& time) { return FormatLocal(time).substr(11, 5); }

std::string Listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 6;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    list += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMost)
    list += " and " + std::to_string(names.size() - kMost) + " more";
  return list;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// East and north of `origin`, on a sphere: exact enough for what GPS says.
Eigen::Vector2d MetresFrom(const Place& origin, const Place& place) {
  const double east_deg = WrapDeg180(place.longitude_deg - origin.longitude_deg);
  return kEarthRadius_m *
         Eigen::Vector2d(RadFromDeg(east_deg) * std::cos(RadFromDeg(origin.latitude_deg)),
                         RadFromDeg(place.latitude_deg - origin.latitude_deg));
}

// What is said of several photos alike is said once, of the first.
void AddOncePerKind(std::span<const ViewTime> times, std::vector<std::string>& doubts) {
  std::size_t with_doubt = 0;
  for (const ViewTime& time : times) with_doubt += time.doubts.empty() ? 0 : 1;
  constexpr std::size_t kMost = 3;
  std::size_t said = 0;
  for (const ViewTime& time : times) {
    if (time.doubts.empty()) continue;
    if (++said > kMost) break;
    doubts.insert(doubts.end(), time.doubts.begin(), time.doubts.end());
  }
  if (with_doubt > kMost) {
    doubts.push_back("and so do " + std::to_string(with_doubt - kMost) +
                     " more photos; the first are named");
  }
}

std::vector<std::string> DoubtsOfCameras(const Capture& capture) {
  if (!fs::exists(capture.folder / "cameras" / "images.txt")) return {};
  std::vector<NamedCamera> cameras;
  try {
    for (const auto& [name, camera] : CamerasOf(capture))
      cameras.push_back({name, camera});
  } catch (const InputError&) {
    return {};  // Said by whoever needs the cameras
  }
  std::vector<std::string> doubts;
  for (const ViewOfAnotherTree& other : ViewsOfAnotherTree(cameras)) {
    doubts.push_back(other.view + " seems to show another tree: its camera looks " +
                     Number(other.off_axis_deg) +
                     " deg past the point that the others have in their pictures; take "
                     "it out of capture.toml and import the cameras again with "
                     "--matching-only");
  }
  return doubts;
}

}  // namespace

std::vector<ViewTime> ViewTimesOf(const Capture& capture,
                                  const std::optional<std::string>& zone_text) {
  const CaptureFile& file = capture.file;
  const auto zone = zone_text ? zone_text : file.zone;
  std::vector<ViewTime> times;
  for (const ViewEntry& view : file.views) {
    ViewTime& time = times.emplace_back(ViewTime{view.name, {}, {}});
    PhotoFacts facts;
    try {
      facts = ReadPhotoFacts(capture.PhotoOf(view));
    } catch (const InputError&) {
      continue;  // Said by whoever needs the photo
    }
    time.place = facts.place;
    std::optional<std::string> taken = view.taken;
    if (!taken && !facts.local_time && !facts.gps_time) taken = file.taken;
    try {
      time.time = ResolveCaptureTime(facts, zone, taken).time;
    } catch (const Error& error) {
      // A time that cannot be is doubted; one that is missing is not
      if (zone && (taken || facts.local_time)) time.doubts.emplace_back(error.what());
    }
    if (taken) continue;
    const auto parsed = zone ? std::optional(ParseZone(*zone)) : std::nullopt;
    if (const auto doubt = ZoneAgainstGps(facts, parsed)) time.doubts.push_back(*doubt);
  }
  return times;
}

std::vector<std::string> DoubtsOfTimes(std::span<const ViewTime> times,
                                       const std::optional<Place>& place,
                                       std::optional<double> heading_rad) {
  // The day of most photos; the first of equals
  std::map<std::string, std::vector<const ViewTime*>> of_day;
  for (const ViewTime& time : times) {
    if (time.time) of_day[DayOf(*time.time)].push_back(&time);
  }
  if (of_day.empty()) return {};
  const auto most =
      std::max_element(of_day.begin(), of_day.end(), [](const auto& a, const auto& b) {
        return a.second.size() < b.second.size();
      });
  std::vector<std::string> doubts;
  for (const auto& [day, photos] : of_day) {
    if (day == most->first) continue;
    std::vector<std::string> names;
    for (const ViewTime* photo : photos) names.push_back(photo->view);
    doubts.push_back(Listed(names) + (names.size() == 1 ? " was" : " were") +
                     " taken on another day, " + day + ", than the others (" +
                     most->first +
                     "): leaves move and grow, and the light is another; better take " +
                     (names.size() == 1 ? "it" : "them") + " out of capture.toml");
  }

  // How far the sun went between the first and the last of that day
  const auto earlier = [](const ViewTime* a, const ViewTime* b) {
    return a->time->utc < b->time->utc;
  };
  const auto [first, last] =
      std::minmax_element(most->second.begin(), most->second.end(), earlier);
  const auto apart = (*last)->time->utc - (*first)->time->utc;
  if (apart <= kLongestApart) return doubts;
  std::string text = "the photos were taken from " + ClockOf(*(*first)->time) + " (" +
                     (*first)->view + ") to " + ClockOf(*(*last)->time) + " (" +
                     (*last)->view + "), " +
                     Duration(std::chrono::round<minutes>(apart)) + " apart";
  if (place) {
    const SolarPosition from = SolarPositionAt((*first)->time->utc, *place);
    const SolarPosition to = SolarPositionAt((*last)->time->utc, *place);
    const auto words = [&](const SolarPosition& sun) {
      return heading_rad
                 ? LightInFewWords(sun.azimuth_rad - *heading_rad, sun.elevation_rad)
                 : LightFromCompass(sun.azimuth_rad, sun.elevation_rad);
    };
    text += ": the sun went " +
            Number(DegFromRad(AngleBetween(from.direction, to.direction))) +
            " deg, first " + words(from) + " high, at last " + words(to) + " high";
  }
  doubts.push_back(text +
                   ". Their light differs; each is relit from its own hour, but 20 "
                   "minutes for all are better");
  return doubts;
}

std::vector<std::string> DoubtsOfPlaces(std::span<const ViewTime> times) {
  std::vector<const ViewTime*> placed;
  for (const ViewTime& time : times) {
    if (time.place) placed.push_back(&time);
  }
  if (placed.size() < 3) return {};

  // The median place, and the median distance from it
  std::vector<double> east_m, north_m, distance_m;
  for (const ViewTime* time : placed) {
    const Eigen::Vector2d at = MetresFrom(*placed[0]->place, *time->place);
    east_m.push_back(at.x());
    north_m.push_back(at.y());
  }
  const Eigen::Vector2d center(Median(east_m), Median(north_m));
  for (std::size_t i = 0; i < placed.size(); ++i)
    distance_m.push_back((Eigen::Vector2d(east_m[i], north_m[i]) - center).norm());
  const double typical_m = Median(distance_m);

  std::vector<std::string> doubts;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (distance_m[i] <= kGpsErrors_m + 3 * typical_m) continue;
    doubts.push_back(placed[i]->view + " seems to show another tree: it was taken " +
                     Number(distance_m[i]) +
                     " m from the middle of the others, most of which are within " +
                     Number(typical_m) +
                     " m of it; take it out of capture.toml, if its GPS place is right");
  }
  return doubts;
}

std::vector<std::string> DoubtsOfCapture(const Capture& capture,
                                         const std::optional<std::string>& zone_text,
                                         std::optional<double> heading_rad) {
  const std::vector<ViewTime> times = ViewTimesOf(capture, zone_text);
  std::optional<Place> place;
  if (capture.file.place) place = ParsePlace(*capture.file.place);
  for (const ViewTime& time : times) {
    if (!place) place = time.place;
  }
  std::vector<std::string> doubts;
  AddOncePerKind(times, doubts);
  for (const auto& more : {DoubtsOfTimes(times, place, heading_rad),
                           DoubtsOfPlaces(times),
                           DoubtsOfCameras(capture)}) {
    doubts.insert(doubts.end(), more.begin(), more.end());
  }
  return doubts;
}

}  // namespace relight
