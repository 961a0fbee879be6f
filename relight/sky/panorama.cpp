// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/panorama.h"

#include "relight/base/angles.h"
#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/photo/lat_long_image.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

namespace relight {
namespace {

using std::numbers::pi;

constexpr int kFinest = 4096, kKept = 1024;  // Width where the sun is cut; of the sky
constexpr double kSunRadius_rad = 0.004652;  // Seen from the Earth's mean distance
constexpr double kWidest_rad = RadFromDeg(5);
constexpr double kBrighter = 8, kLeastShare = 0.005, kGlare = 0.01;

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// A pixel near the sun.
struct Near {
  Eigen::Vector3d direction;
  double weight_sr;
  cv::Vec3f* color;
  Eigen::Array3d Color() const { return {(*color)[0], (*color)[1], (*color)[2]}; }
};

// Edges of a row above the horizon, as sines of elevations.
std::pair<double, double> SinesOfRow(int rows, int row) {
  const double above = std::sin((0.5 - double(row) / rows) * pi);
  return {above, std::sin((0.5 - double(row + 1) / rows) * pi)};
}

struct Ring {
  Eigen::Array3d color = Eigen::Array3d::Zero();
  double weight_sr = 0;
};

Ring MeanOfRing(const std::vector<Near>& pixels,
                const Eigen::Vector3d& center,
                double from_rad,
                double to_rad) {
  Ring ring;
  for (const Near& pixel : pixels) {
    if (pixel.direction.z() <= 0) continue;  // Ground
    const double angle_rad = AngleBetween(pixel.direction, center);
    if (angle_rad < from_rad || angle_rad >= to_rad) continue;
    ring.color += pixel.weight_sr * pixel.Color();
    ring.weight_sr += pixel.weight_sr;
  }
  if (ring.weight_sr > 0) ring.color /= ring.weight_sr;
  return ring;
}

double MedianLuminance(const std::vector<Near>& pixels,
                       const Eigen::Vector3d& center,
                       double from_rad,
                       double to_rad) {
  std::vector<double> values;
  for (const Near& pixel : pixels) {
    const double angle_rad = AngleBetween(pixel.direction, center);
    if (pixel.direction.z() > 0 && angle_rad >= from_rad && angle_rad < to_rad) {
      values.push_back(Luminance(pixel.Color()));
    }
  }
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What is above `behind` inside of the radius.
struct Excess {
  Eigen::Array3d irradiance = Eigen::Array3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // Of unit length, or 0.
};
Excess ExcessIn(const std::vector<Near>& pixels,
                const Eigen::Vector3d& center,
                double radius_rad,
                const Eigen::Array3d& behind) {
  Excess excess;
  for (const Near& pixel : pixels) {
    if (AngleBetween(pixel.direction, center) > radius_rad) continue;
    const Eigen::Array3d part =
        pixel.weight_sr * (pixel.Color() - pixel.Color().min(behind));
    excess.irradiance += part;
    excess.direction += Luminance(part) * pixel.direction;
  }
  if (excess.direction.norm() > 0) excess.direction.normalize();
  return excess;
}

}  // namespace

Eigen::Vector3d LatLongDirection(cv::Size size, double column, double row) {
  return DirectionFromAzimuthElevation(2 * pi * (column + 0.5) / size.width - pi,
                                       (0.5 - (row + 0.5) / size.height) * pi);
}

double LatLongSolidAngle(cv::Size size, int row) {
  const auto [above, below] = SinesOfRow(size.height, row);
  return 2 * pi / size.width * (std::max(0.0, above) - std::max(0.0, below));
}

std::optional<PanoramaSun> CutOutSun(cv::Mat3f& lat_long) {
  const cv::Size size = lat_long.size();
  const double pixel_rad = pi / size.height;

  // The brightest pixel, and the sky's light on level ground
  double brightest = 0, ground = 0;
  cv::Point at(0, 0);
  for (int row = 0; row < size.height / 2; ++row) {
    const auto [above, below] = SinesOfRow(size.height, row);
    const double on_ground = pi / size.width * (above * above - below * below);
    for (int column = 0; column < size.width; ++column) {
      const cv::Vec3f& c = lat_long(row, column);
      const double luminance = Luminance({c[0], c[1], c[2]});
      ground += on_ground * luminance;
      if (luminance > brightest) {
        brightest = luminance;
        at = {column, row};
      }
    }
  }
  if (!(brightest > 0)) return std::nullopt;
  Eigen::Vector3d center = LatLongDirection(size, at.x, at.y);

  // All that may matter to it; below the horizon, what its disc may reach
  const double far_rad = std::max(2 * kWidest_rad, 12 * pixel_rad);
  std::vector<Near> pixels;
  for (int row = 0; row < size.height; ++row) {
    const double elevation_rad = (0.5 - (row + 0.5) / size.height) * pi;
    if (std::abs(elevation_rad - ElevationOf(center)) > far_rad) continue;
    if (elevation_rad < -kSunRadius_rad - 1.5 * pixel_rad) break;
    const auto [above, below] = SinesOfRow(size.height, row);
    for (int column = 0; column < size.width; ++column) {
      const Eigen::Vector3d direction = LatLongDirection(size, column, row);
      if (AngleBetween(direction, center) > far_rad) continue;
      pixels.push_back(
          {direction, 2 * pi / size.width * (above - below), &lat_long(row, column)});
    }
  }
  const double around = MedianLuminance(pixels,
                                        center,
                                        std::max(RadFromDeg(4), 4 * pixel_rad),
                                        std::max(RadFromDeg(8), 9 * pixel_rad));
  if (brightest < kBrighter * around) return std::nullopt;

  // The disc; the first brightest pixel may be on its edge
  const double least_rad = kSunRadius_rad + 1.5 * pixel_rad;
  const double step_rad = std::max(RadFromDeg(0.25), pixel_rad);
  const auto behind = [&](double radius_rad) {
    return MeanOfRing(pixels,
                      center,
                      radius_rad,
                      radius_rad + std::max(RadFromDeg(1), 2 * pixel_rad))
        .color;
  };
  for (int i = 0; i < 3; ++i) {
    const double wide_rad = least_rad + kSunRadius_rad;
    const Excess found = ExcessIn(pixels, center, wide_rad, behind(wide_rad));
    if (found.direction.norm() > 0) center = found.direction;
  }

  // Its glare
  double radius_rad = least_rad;
  Excess sun = ExcessIn(pixels, center, radius_rad, behind(radius_rad));
  while (radius_rad + step_rad <= std::max(kWidest_rad, least_rad)) {
    const Excess wider =
        ExcessIn(pixels, center, radius_rad + step_rad, behind(radius_rad + step_rad));
    if (Luminance(wider.irradiance) < (1 + kGlare) * Luminance(sun.irradiance)) break;
    sun = wider;
    if (sun.direction.norm() > 0) center = sun.direction;
    radius_rad += step_rad;
  }
  const Eigen::Array3d ring = behind(radius_rad);
  sun = ExcessIn(pixels, center, radius_rad, ring);
  const double sky_on_ground =
      ground - Luminance(sun.irradiance) * std::max(0.0, center.z());
  if (!(Luminance(sun.irradiance) > kLeastShare * sky_on_ground)) return std::nullopt;

  // Cut out
  double flat_sr = 0;
  int flat = 0;
  for (const Near& pixel : pixels) {
    if (AngleBetween(pixel.direction, center) > radius_rad) continue;
    if (Luminance(pixel.Color()) >= 0.999 * brightest) {
      flat_sr += pixel.weight_sr;
      ++flat;
    }
    for (int c = 0; c < 3; ++c) {
      (*pixel.color)[c] = std::min((*pixel.color)[c], static_cast<float>(ring[c]));
    }
  }
  const double disc_sr = pi * kSunRadius_rad * kSunRadius_rad;
  return PanoramaSun{.direction = sun.direction,
                     .irradiance = sun.irradiance,
                     .radius_rad = radius_rad,
                     .clipped = flat > 4 && flat_sr > 3 * disc_sr};
}

Panorama ReadPanorama(const std::filesystem::path& file) {
  LatLongFile read = ReadLatLong(file, kFinest);
  Panorama panorama{.file = file, .hash = HashOfFile(file), .size = read.size};
  panorama.sun = CutOutSun(read.pixels);
  panorama.sky = ShrunkLatLong(read.pixels, kKept);
  const auto unit = read.metadata.find("relight:unit");
  panorama.absolute = unit != read.metadata.end() && unit->second == "cd/m2";
  if (const auto heading = read.metadata.find("relight:heading_deg");
      heading != read.metadata.end()) {
    double degrees = 0;
    const std::string& text = heading->second;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), degrees);
    if (error != std::errc() || end != text.data() + text.size()) {
      throw InputError(file.string() + ": says relight:heading_deg \"" + text +
                       "\", which is no number; take that text out of the file");
    }
    panorama.heading_rad = RadFromDeg(degrees);
  }
  return panorama;
}

Eigen::Array3d PanoramaSky::operator()(const Eigen::Vector3d& direction) const {
  if (direction.z() < 0) return Eigen::Array3d::Zero();
  const cv::Mat3f& sky = panorama->sky;
  const double turn = (AzimuthOf(direction) - heading_rad) / (2 * pi) + 0.5;
  double x = (turn - std::floor(turn)) * sky.cols - 0.5;
  double y = (0.5 - ElevationOf(direction) / pi) * sky.rows - 0.5;
  y = std::clamp(y, 0.0, std::max(0.0, sky.rows / 2 - 1.0));  // No ground in it
  if (x < 0) x += sky.cols;
  const int left = static_cast<int>(x) % sky.cols, right = (left + 1) % sky.cols;
  const int top = static_cast<int>(y), bottom = std::min(top + 1, sky.rows - 1);
  const auto u = static_cast<float>(x - std::floor(x)), v = static_cast<float>(y - top);
  const cv::Vec3f color = (1 - v) * ((1 - u) * sky(top, left) + u * sky(top, right)) +
                          v * ((1 - u) * sky(bottom, left) + u * sky(bottom, right));
  return cd_per_m2 * Eigen::Array3d(color[0], color[1], color[2]);
}

}  // namespace relight
