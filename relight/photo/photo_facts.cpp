// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/photo_facts.h"

#include "relight/photo/picture_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace relight {
namespace {

using namespace std::chrono;

constexpr char kMadeByRelight[] = "relight ";

// Spaces and zeros around what a camera left in a field of fixed width.
std::string Trimmed(const std::string& text) {
  const auto blank = [](unsigned char c) { return c <= ' '; };
  const auto begin = std::find_if_not(text.begin(), text.end(), blank);
  const auto end =
      std::find_if_not(text.rbegin(), std::make_reverse_iterator(begin), blank);
  return {begin, end.base()};
}

// A camera without a set clock writes blanks or zeros: nothing, and nothing to note.
bool SaysNothing(const std::string& text) {
  return text.find_first_not_of(" :-0/.+") == std::string::npos;
}

std::optional<sys_days> DaysOf(int year, int month, int day) {
  const year_month_day date{std::chrono::year(year),
                            std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (year < 1800 || year > 2200 || month < 1 || day < 1 || !date.ok())
    return std::nullopt;
  return sys_days(date);
}

// "2011:07:22 13:00:00", as EXIF has it; dashes and a T, as some programs do.
std::optional<WallClock> ParseExifTime(const std::string& text) {
  int y, mo, d, h, mi, s, used = 0;
  if (std::sscanf(text.c_str(),
                  "%4d%*1[:-]%2d%*1[:-]%2d%*1[ T]%2d:%2d:%2d%n",
                  &y,
                  &mo,
                  &d,
                  &h,
                  &mi,
                  &s,
                  &used) != 6 ||
      used == 0) {
    return std::nullopt;
  }
  const auto days = DaysOf(y, mo, d);
  if (!days || h < 0 || h > 23 || mi < 0 || mi > 59 || s < 0 || s > 60)
    return std::nullopt;
  return WallClock(days->time_since_epoch() + hours(h) + minutes(mi) + seconds(s));
}

// "-04:00", "Z".
std::optional<minutes> ParseExifOffset(const std::string& text) {
  if (text == "Z") return minutes(0);
  char sign = 0;
  int h = 0, m = 0, used = 0;
  if (std::sscanf(text.c_str(), "%c%2d:%2d%n", &sign, &h, &m, &used) != 3 || used != 6) {
    return std::nullopt;
  }
  if ((sign != '+' && sign != '-') || h < 0 || h > 15 || m < 0 || m > 59)
    return std::nullopt;
  return (sign == '-' ? -1 : 1) * (hours(h) + minutes(m));
}

// Degrees, minutes, seconds.
std::optional<double> Sexagesimal(const std::vector<double>& parts, double limit_deg) {
  if (parts.empty() || parts.size() > 3) return std::nullopt;
  double value = 0.0, scale = 1.0;
  for (const double part : parts) {
    if (!std::isfinite(part) || part < 0.0) return std::nullopt;
    value += part * scale;
    scale /= 60.0;
  }
  return value <= limit_deg ? std::optional(value) : std::nullopt;
}

class FactsReader {
 public:
  explicit FactsReader(const PictureFile& file) : file_(file) {
    facts_.file = file.path().string();
  }

  PhotoFacts Read() {
    const cv::Size size = UprightSize(file_.size(), file_.orientation());
    facts_.width = size.width;
    facts_.height = size.height;
    facts_.orientation = file_.orientation();
    ReadTime();
    ReadGpsTime();
    ReadPlace();
    ReadHeading();
    ReadLens();
    ReadMaker();
    return std::move(facts_);
  }

 private:
  std::string Text(const char* name) const {
    return Trimmed(file_.Text(name).value_or(""));
  }

  std::optional<double> Number(const char* name) const {
    const std::vector<double> numbers = file_.Numbers(name);
    return numbers.size() == 1 ? std::optional(numbers[0]) : std::nullopt;
  }

  void Unusable(const std::string& what, const std::string& value) {
    facts_.notes.push_back(what + " is not usable (" + value +
                           ") and counts as missing.");
  }

  void ReadTime() {
    const std::string text = Text("Exif:DateTimeOriginal");
    if (!SaysNothing(text)) {
      facts_.local_time = ParseExifTime(text);
      if (!facts_.local_time) Unusable("The capture time", text);
    }
    const std::string fraction = Text("Exif:SubsecTimeOriginal");
    if (facts_.local_time && !fraction.empty() &&
        fraction.find_first_not_of("0123456789") == std::string::npos) {
      *facts_.local_time += milliseconds(std::stoi((fraction + "000").substr(0, 3)));
    }
    const std::string offset = Text("Exif:OffsetTimeOriginal");
    if (!offset.empty() && offset.find_first_not_of(" :") != std::string::npos) {
      facts_.offset = ParseExifOffset(offset);
      if (!facts_.offset) Unusable("The time zone of the capture time", offset);
    }
  }

  void ReadGpsTime() {
    const std::string date = Text("GPS:DateStamp");
    const std::vector<double> time = file_.Numbers("GPS:TimeStamp");
    if (SaysNothing(date) || time.size() != 3) return;
    int y = 0, m = 0, d = 0;
    const bool dated =
        std::sscanf(date.c_str(), "%4d%*1[:-]%2d%*1[:-]%2d", &y, &m, &d) == 3;
    const auto days = dated ? DaysOf(y, m, d) : std::nullopt;
    const bool timed = time[0] >= 0 && time[0] < 24 && time[1] >= 0 && time[1] < 60 &&
                       time[2] >= 0 && time[2] < 61;
    if (!days || !timed) {
      Unusable("The GPS time", date);
      return;
    }
    facts_.gps_time =
        Instant(*days) +
        milliseconds(std::llround(1000.0 * (3600 * time[0] + 60 * time[1] + time[2])));
  }

  void ReadPlace() {
    const std::vector<double> latitude = file_.Numbers("GPS:Latitude");
    const std::vector<double> longitude = file_.Numbers("GPS:Longitude");
    if (latitude.empty() && longitude.empty()) return;
    const auto lat = Sexagesimal(latitude, 90.0);
    const auto lon = Sexagesimal(longitude, 180.0);
    const std::string lat_ref = Text("GPS:LatitudeRef"),
                      lon_ref = Text("GPS:LongitudeRef");
    const bool refs =
        (lat_ref == "N" || lat_ref == "S") && (lon_ref == "E" || lon_ref == "W");
    if (!lat || !lon || !refs) {
      Unusable("The GPS place",
               !refs ? "north or south, east or west is not said"
                     : "no latitude up to 90 and longitude up to 180 degrees");
      return;
    }
    Place place{.latitude_deg = lat_ref == "S" ? -*lat : *lat,
                .longitude_deg = lon_ref == "W" ? -*lon : *lon};
    if (const auto altitude = Number("GPS:Altitude")) {
      if (std::isfinite(*altitude) && std::abs(*altitude) < 1e5) {
        constexpr double kBelowSea = 1.0;
        const bool below = Number("GPS:AltitudeRef").value_or(0.0) == kBelowSea;
        place.altitude_m = below ? -*altitude : *altitude;
      } else {
        Unusable("The GPS altitude", std::to_string(*altitude));
      }
    }
    facts_.place = place;
  }

  void ReadHeading() {
    const auto heading = Number("GPS:ImgDirection");
    if (!heading) return ReadGimbal();
    if (!std::isfinite(*heading) || *heading < 0.0 || *heading > 360.0) {
      Unusable("The heading", std::to_string(*heading));
      return;
    }
    facts_.heading_deg = std::fmod(*heading, 360.0);
    const std::string ref = Text("GPS:ImgDirectionRef");
    facts_.heading_is_magnetic = ref == "M";
    if (ref != "M" && ref != "T") {
      facts_.notes.push_back(
          "The heading does not say whether it is from true or magnetic north; it is "
          "taken "
          "as true.");
    }
  }

  // Drones of one maker say it in XMP, from true north, in (-180, 180].
  void ReadGimbal() {
    const auto yaw = Number("drone-dji:GimbalYawDegree");
    if (!yaw || !std::isfinite(*yaw) || std::abs(*yaw) > 360) return;
    facts_.heading_deg = std::fmod(*yaw + 720, 360.0);
  }

  void ReadLens() {
    const auto positive = [&](const char* name) {
      const auto value = Number(name);
      return value && std::isfinite(*value) && *value > 0.0 ? value : std::nullopt;
    };
    facts_.focal_mm = positive("Exif:FocalLength");
    facts_.focal_35mm_mm = positive("Exif:FocalLengthIn35mmFilm");
  }

  void ReadMaker() {
    facts_.make = Text("Make");
    facts_.model = Text("Model");
    facts_.software = Text("Software");
    facts_.description = Text("ImageDescription");
    facts_.made_by_relight = facts_.software.rfind(kMadeByRelight, 0) == 0;
    if (facts_.made_by_relight) facts_.provenance_json = facts_.description;
  }

  const PictureFile& file_;
  PhotoFacts facts_;
};

}  // namespace

PhotoFacts ReadPhotoFacts(const std::filesystem::path& path) {
  const PictureFile file(path);
  return FactsReader(file).Read();
}

}  // namespace relight
