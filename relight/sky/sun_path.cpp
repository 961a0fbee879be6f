// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sun_path.h"

#include "relight/base/angles.h"

#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace relight {
namespace {

using std::chrono::minutes;

constexpr double kRim_px = 260, kMiddle_px = 310;

struct Point {
  double x, y;
};

Point PointOf(double azimuth_rad, double elevation_rad) {
  const double r = kRim_px * (1 - elevation_rad / (std::numbers::pi / 2));
  return {kMiddle_px + r * std::sin(azimuth_rad), kMiddle_px - r * std::cos(azimuth_rad)};
}

SolarPosition SunOf(const Place& place,
                    std::chrono::year_month_day date,
                    minutes of_clock,
                    minutes offset) {
  const auto at = std::chrono::sys_days(date) + of_clock - offset;
  return SolarPositionAt(std::chrono::time_point_cast<Instant::duration>(at), place);
}

// The parts of a day's way above the horizon.
void AddPath(const Place& place,
             std::chrono::year_month_day date,
             minutes offset,
             const char* style,
             std::ostringstream& svg) {
  bool drawing = false;
  for (minutes at{0}; at <= minutes(24 * 60); at += minutes(5)) {
    const SolarPosition sun = SunOf(place, date, at, offset);
    if (sun.elevation_rad < 0) {
      if (drawing) svg << "\"/>\n";
      drawing = false;
      continue;
    }
    if (!drawing) svg << "<polyline fill=\"none\" " << style << " points=\"";
    drawing = true;
    const Point p = PointOf(sun.azimuth_rad, sun.elevation_rad);
    svg << p.x << "," << p.y << " ";
  }
  if (drawing) svg << "\"/>\n";
}

void AddText(const Point& at, const std::string& text, std::ostringstream& svg) {
  svg << "<text x=\"" << at.x << "\" y=\"" << at.y
      << "\" text-anchor=\"middle\" dominant-baseline=\"middle\">" << text << "</text>\n";
}

}  // namespace

std::string SunPathSvg(const Place& place,
                       std::chrono::year_month_day date,
                       minutes offset,
                       const SolarPosition& now) {
  using std::chrono::day;
  using std::chrono::month;
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1);
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 620 620\" "
         "font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n"
         "<rect width=\"620\" height=\"620\" fill=\"#fff\"/>\n";
  for (int elevation_deg = 0; elevation_deg < 90; elevation_deg += 15) {
    const double r = kRim_px * (1 - elevation_deg / 90.0);
    svg << "<circle cx=\"" << kMiddle_px << "\" cy=\"" << kMiddle_px << "\" r=\"" << r
        << "\" fill=\"none\" stroke=\"" << (elevation_deg == 0 ? "#222" : "#ccc")
        << "\"/>\n";
    if (elevation_deg > 0) {
      AddText({kMiddle_px, kMiddle_px + r}, std::to_string(elevation_deg) + "°", svg);
    }
  }
  const char* names[] = {"N", "NE", "E", "SE", "S", "SW", "W", "NW"};
  for (int i = 0; i < 8; ++i) {
    AddText(PointOf(RadFromDeg(45.0 * i), RadFromDeg(-6.5)), names[i], svg);
  }

  const auto year = date.year();
  for (const auto& solstice : {year / month(6) / day(21), year / month(12) / day(21)}) {
    AddPath(place, solstice, offset, "stroke=\"#999\" stroke-dasharray=\"4 4\"", svg);
  }
  AddPath(place, date, offset, "stroke=\"#d60\" stroke-width=\"2.5\"", svg);
  for (int hour = 0; hour < 24; ++hour) {
    const SolarPosition sun = SunOf(place, date, minutes(60 * hour), offset);
    if (sun.elevation_rad < 0) continue;
    const Point p = PointOf(sun.azimuth_rad, sun.elevation_rad);
    svg << "<circle cx=\"" << p.x << "\" cy=\"" << p.y << "\" r=\"3\" fill=\"#d60\"/>\n";
    AddText({p.x, p.y - 12}, std::to_string(hour), svg);
  }
  if (now.elevation_rad >= 0) {
    const Point p = PointOf(now.azimuth_rad, now.elevation_rad);
    svg << "<circle cx=\"" << p.x << "\" cy=\"" << p.y
        << "\" r=\"8\" fill=\"#fc0\" stroke=\"#b60\" stroke-width=\"1.5\"/>\n";
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace relight
