// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/light_in_words.h"

#include "relight/base/angles.h"

#include <array>
#include <string_view>

namespace relight {
namespace {

// The eight directions from the camera, clockwise from straight ahead.
struct Sector {
  std::string_view sun;
  std::string_view from;
  std::string_view shadow;  // When the sun is in this sector: it falls the other way.
};

constexpr std::array<Sector, 8> kSectors = {{
    {"sun in front of you", "from the front", "falls towards you"},
    {"sun in front of you on the right",
     "from the front on the right",
     "falls towards you to the left"},
    {"sun on your right", "from the right", "falls to the left"},
    {"sun behind you on the right", "from behind on the right", "falls away to the left"},
    {"sun behind you", "from behind", "falls away from you"},
    {"sun behind you on the left", "from behind on the left", "falls away to the right"},
    {"sun on your left", "from the left", "falls to the right"},
    {"sun in front of you on the left",
     "from the front on the left",
     "falls towards you to the right"},
}};

constexpr std::array<std::string_view, 8> kCompass = {"north",
                                                      "north-east",
                                                      "east",
                                                      "south-east",
                                                      "south",
                                                      "south-west",
                                                      "west",
                                                      "north-west"};

// Which eighth of the circle, clockwise.
std::size_t EighthOf(double azimuth_rad) {
  const double eighths = DegFromRad(azimuth_rad) / 45.0;
  const long index = std::lround(eighths - 8.0 * std::floor(eighths / 8.0));
  return static_cast<std::size_t>(index % 8);
}

const Sector& SectorOf(double azimuth_rad) { return kSectors[EighthOf(azimuth_rad)]; }

constexpr double kOverhead_rad = RadFromDeg(80.0);

std::string Degrees(double angle_rad) {
  return std::to_string(std::lround(DegFromRad(angle_rad))) + "°";
}

}  // namespace

std::string LightInWords(double azimuth_from_heading_rad, double elevation_rad) {
  if (elevation_rad <= 0.0) return "sun below the horizon, no shadow";
  if (elevation_rad >= kOverhead_rad) {
    return "sun overhead, " + Degrees(elevation_rad) + " high, shadow under the tree";
  }
  const Sector& sector = SectorOf(azimuth_from_heading_rad);
  return std::string(sector.sun) + ", " + Degrees(elevation_rad) + " high, shadow " +
         std::string(sector.shadow);
}

std::string LightInFewWords(double azimuth_from_heading_rad, double elevation_rad) {
  if (elevation_rad <= 0.0) return "from below the horizon";
  if (elevation_rad >= kOverhead_rad) return "from overhead, " + Degrees(elevation_rad);
  return std::string(SectorOf(azimuth_from_heading_rad).from) + ", " +
         Degrees(elevation_rad);
}

std::string LightFromCompass(double azimuth_rad, double elevation_rad) {
  if (elevation_rad <= 0.0) return "from below the horizon";
  return "from the " + std::string(kCompass[EighthOf(azimuth_rad)]) + ", " +
         Degrees(elevation_rad);
}

}  // namespace relight
