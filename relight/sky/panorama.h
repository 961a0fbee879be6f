// SPDX-License-Identifier: Apache-2.0
#pragma once

// A panorama of the sky as light: its sun found, cut out and told apart from the sky.
//
// Lat-long (docs/conventions.md#panoramas): of W x H pixels, W = 2 H, pixel (c, r) is at
//
//   azimuth a_0 + 2 pi (c + 1/2) / W - pi,   elevation pi/2 - pi (r + 1/2) / H
//
// with a_0 the azimuth of the picture's middle, and has the solid angle
//
//   w = 2 pi / W (sin of its upper edge's elevation - sin of its lower edge's).
//
// The sun is looked for round the brightest pixel above the horizon. Inside of a radius
// rho, what is above L_ring, the mean colour of a ring round it, is sun:
//
//   S w_sun = sum over pixels (L - L') w,  L' = min(L, L_ring) per channel     (K10)
//
// S being its irradiance on a plane that faces it, w_sun the mean direction by luminance,
// and L' what stays in the sky: sun and sky together are the panorama, whatever rho. It
// grows from the sun's own radius and one and a half pixels, while the next ring adds
// more than 1 % of the sun (glare of a lens), to 5 degrees at most.
//
// There is a sun when its pixel is 8 times as bright as the sky 4 to 8 degrees round it
// (thin clouds leave that; the brightest standard sky has 1.3 across as much) and its
// light at least 0.5 % of the sky's on level ground. Else all stays in the sky.

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace relight {

struct PanoramaSun {
  Eigen::Vector3d direction;  // With north in the picture's middle.
  Eigen::Array3d irradiance;  // On a plane that faces it, in the panorama's unit.
  double radius_rad = 0.0;    // rho: inside of it the sky is L' of (K10).
  // Cut off at the largest value that the file holds, so that its light is too little.
  bool clipped = false;
};

struct Panorama {
  std::filesystem::path file;
  std::string hash;    // Of the file's content.
  cv::Size size;       // Of the file.
  cv::Mat3f sky = {};  // Linear Rec.709 without the sun; at most 1024 wide.
  std::optional<PanoramaSun> sun = {};
  // What a file says that relight wrote: the azimuth of its middle, and that its values
  // are cd/m2.
  std::optional<double> heading_rad = {};
  bool absolute = false;

  // Sum over the pixels above the horizon of value, solid angle and weight(direction).
  // `weight`: Vector3d -> double.
  template <class Weight>
  Eigen::Array3d Integral(const Weight& weight) const;
};

// Pixel after pixel above the horizon: take(direction, solid angle, colour). Of one that
// the horizon cuts, the part above.
template <class Take>
void ForEachSkyPixel(const cv::Mat3f& lat_long, const Take& take);

// Unit vector of a point of a lat-long picture with north in its middle, and solid angle
// of a pixel of a row above the horizon.
Eigen::Vector3d LatLongDirection(cv::Size size, double column, double row);
double LatLongSolidAngle(cv::Size size, int row);

// Takes the sun out of `lat_long`, which is changed; nothing when there is none.
std::optional<PanoramaSun> CutOutSun(cv::Mat3f& lat_long);

// Throws InputError as ReadLatLong does.
Panorama ReadPanorama(const std::filesystem::path& file);

// A panorama over a place on the Earth, in the unit of a Daylight.
struct PanoramaSky {
  std::shared_ptr<const Panorama> panorama;
  double heading_rad = 0.0;  // a_0.
  double cd_per_m2 = 1.0;    // Of a value of 1.

  // [cd/m2] from a unit direction, interpolated; 0 below the horizon.
  Eigen::Array3d operator()(const Eigen::Vector3d& direction_in_world) const;
};

// --- Bodies of the templates ---------------------------------------------------------

template <class Take>
void ForEachSkyPixel(const cv::Mat3f& lat_long, const Take& take) {
  for (int row = 0; row < (lat_long.rows + 1) / 2; ++row) {
    const double weight_sr = LatLongSolidAngle(lat_long.size(), row);
    for (int column = 0; column < lat_long.cols; ++column) {
      const cv::Vec3f& color = lat_long(row, column);
      take(LatLongDirection(lat_long.size(), column, row),
           weight_sr,
           Eigen::Array3d(color[0], color[1], color[2]));
    }
  }
}

template <class Weight>
Eigen::Array3d Panorama::Integral(const Weight& weight) const {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  ForEachSkyPixel(
      sky,
      [&](const Eigen::Vector3d& direction,
          double weight_sr,
          const Eigen::Array3d& color) { sum += weight_sr * weight(direction) * color; });
  return sum;
}

}  // namespace relight
