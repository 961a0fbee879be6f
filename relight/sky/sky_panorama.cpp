// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sky_panorama.h"

#include "relight/base/angles.h"
#include "relight/base/parallel.h"
#include "relight/sky/panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace relight {
namespace {

constexpr double kSunRadius_rad = 0.004652;  // Seen from the Earth's mean distance

// Shares of the pixels that the disc covers, on a fine grid in each.
struct Covered {
  cv::Point pixel;
  double weight_sr;  // Solid angle under the disc
};

std::vector<Covered> PixelsOfSun(cv::Size size, const Eigen::Vector3d& sun) {
  constexpr int kFine = 16;
  const double reach_rad = kSunRadius_rad + std::numbers::pi / size.height;
  std::vector<Covered> covered;
  for (int row = 0; row < size.height; ++row) {
    const double elevation_rad = (0.5 - (row + 0.5) / size.height) * std::numbers::pi;
    if (std::abs(elevation_rad - ElevationOf(sun)) > reach_rad) continue;
    for (int column = 0; column < size.width; ++column) {
      if (AngleBetween(LatLongDirection(size, column, row), sun) > 1.5 * reach_rad)
        continue;
      double weight_sr = 0;
      for (int i = 0; i < kFine; ++i) {
        const double y = row + (i + 0.5) / kFine - 0.5;
        const double cell_sr =
            2 * std::numbers::pi * std::numbers::pi / size.width / size.height /
            (kFine * kFine) *
            std::cos((0.5 - (y + 0.5) / size.height) * std::numbers::pi);
        for (int j = 0; j < kFine; ++j) {
          const double x = column + (j + 0.5) / kFine - 0.5;
          if (AngleBetween(LatLongDirection(size, x, y), sun) <= kSunRadius_rad) {
            weight_sr += cell_sr;
          }
        }
      }
      if (weight_sr > 0) covered.push_back({{column, row}, weight_sr});
    }
  }
  return covered;
}

// Of a whole pixel, below the horizon too.
double PixelSolidAngle(cv::Size size, int row) {
  const auto sine = [&](int edge) {
    return std::sin((0.5 - double(edge) / size.height) * std::numbers::pi);
  };
  return 2 * std::numbers::pi / size.width * (sine(row) - sine(row + 1));
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

}  // namespace

cv::Mat3f DrawPanorama(const Daylight& daylight, int height) {
  cv::Mat3f image(height, 2 * height);
  ParallelRanges(height, 8, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const Eigen::Array3d radiance =
            daylight.SkyRadiance(LatLongDirection(image.size(), column, row));
        for (int c = 0; c < 3; ++c) {
          image(row, column)[c] = static_cast<float>(radiance[c]);
        }
      }
    }
  });
  if (!(daylight.sun_irradiance > 0).any()) return image;
  const auto covered = PixelsOfSun(image.size(), daylight.sun_direction);
  double all_sr = 0;
  for (const Covered& each : covered) all_sr += each.weight_sr;
  for (const Covered& each : covered) {
    const double mean =
        each.weight_sr / all_sr / PixelSolidAngle(image.size(), each.pixel.y);
    for (int c = 0; c < 3; ++c) {
      image(each.pixel)[c] += static_cast<float>(daylight.sun_irradiance[c] * mean);
    }
  }
  return image;
}

cv::Mat3f ToneMappedPanorama(const cv::Mat3f& panorama) {
  // Mean of the sky without the sun's few pixels
  std::vector<std::pair<double, double>> sky;  // Luminance, solid angle
  ForEachSkyPixel(
      panorama,
      [&](const Eigen::Vector3d&, double weight_sr, const Eigen::Array3d& color) {
        sky.emplace_back(Luminance(color), weight_sr);
      });
  std::sort(sky.begin(), sky.end());
  double sum = 0, weight_sr = 0;
  for (const auto& [luminance, weight] : sky) {
    if (weight_sr > 0.999 * 2 * std::numbers::pi) break;
    sum += luminance * weight;
    weight_sr += weight;
  }
  const double mean = weight_sr > 0 && sum > 0 ? sum / weight_sr : 1.0;
  cv::Mat3f mapped(panorama.size());
  for (int row = 0; row < mapped.rows; ++row) {
    for (int column = 0; column < mapped.cols; ++column) {
      for (int c = 0; c < 3; ++c) {
        const double value = std::max(0.0f, panorama(row, column)[c]) / (2 * mean);
        mapped(row, column)[c] = static_cast<float>(-std::expm1(-value));
      }
    }
  }
  return mapped;
}

}  // namespace relight
