// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/lat_long_image.h"

#include "relight/base/error.h"
#include "relight/photo/picture_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr char kPrefix[] = "relight:";

// Sine of the elevation of the edge above row `row` of `rows`.
double SineAbove(double row, int rows) {
  return std::sin((0.5 - row / rows) * std::numbers::pi);
}

// Rows in any order to a smaller picture of the same sphere. A row's share of a row is
// measured by its solid angle, a column's by its width.
class Shrinker {
 public:
  Shrinker(cv::Size from, cv::Size to)
      : from_(from),
        sums_(cv::Mat_<cv::Vec3d>::zeros(to)),
        band_(static_cast<std::size_t>(to.width)) {}

  void Add(int row, const cv::Vec3f* pixels) {
    // Means over columns
    const int width = sums_.cols;
    const double ratio = static_cast<double>(from_.width) / width;
    for (int x = 0; x < width; ++x) {
      const double begin = x * ratio, end = (x + 1) * ratio;
      cv::Vec3d sum(0, 0, 0);
      for (int i = static_cast<int>(begin); i < std::min<double>(from_.width, end); ++i) {
        const double share = std::min<double>(i + 1, end) - std::max<double>(i, begin);
        for (int c = 0; c < 3; ++c) sum[c] += share * pixels[i][c];
      }
      band_[static_cast<std::size_t>(x)] = sum / ratio;
    }

    // Onto the rows that it overlaps
    const double scale = static_cast<double>(sums_.rows) / from_.height;
    const double top = row * scale, bottom = (row + 1) * scale;
    for (int y = static_cast<int>(top); y < std::min<double>(sums_.rows, bottom); ++y) {
      const double share = SineAbove(std::max<double>(y, top), sums_.rows) -
                           SineAbove(std::min<double>(y + 1, bottom), sums_.rows);
      const double whole = SineAbove(y, sums_.rows) - SineAbove(y + 1, sums_.rows);
      for (int x = 0; x < width; ++x) {
        sums_(y, x) += share / whole * band_[static_cast<std::size_t>(x)];
      }
    }
  }

  cv::Mat3f Result() const {
    cv::Mat3f result;
    sums_.convertTo(result, CV_32F);
    return result;
  }

 private:
  cv::Size from_;
  cv::Mat_<cv::Vec3d> sums_;
  std::vector<cv::Vec3d> band_;
};

// XYZ of linear Rec.709, as relight/sky/rec709.h.
constexpr double kXyz[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                               {0.2126729, 0.7151522, 0.0721750},
                               {0.0193339, 0.1191920, 0.9503041}};

// Nothing when the colour is one of light.
std::optional<std::string> FaultOf(const cv::Vec3f& color) {
  for (int c = 0; c < 3; ++c) {
    if (std::isnan(color[c])) return "NaN";
    if (std::isinf(color[c])) return "an infinite value";
  }
  const double size =
      std::max({std::abs(color[0]), std::abs(color[1]), std::abs(color[2])});
  for (const auto& row : kXyz) {
    const double value = row[0] * color[0] + row[1] * color[1] + row[2] * color[2];
    // Below it, a colour on the edge is rounded to a float or to a half
    if (value < -1e-3 * size) return "light below 0";
  }
  return std::nullopt;
}

void RequireWholeSphere(const PictureFile& file) {
  const cv::Size size = file.size();
  if (size.width == 2 * size.height && size.height >= 8) return;
  const std::string is =
      "is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
      " pixels, and a panorama of the whole sphere is twice as wide as high (lat-long, "
      "equirectangular)";
  if (size.height < 8) file.Refuse(is + ", from 16 x 8 on; give a larger one");
  if (size.width == 4 * size.height) {
    file.Refuse(is + "; of the upper half alone, add as many black rows below");
  }
  if (size.width == size.height) {
    file.Refuse(is + "; of a mirror ball or an angular map, make one of that kind first");
  }
  file.Refuse(is + "; pad it with black where it is cut off, or give another");
}

std::array<int, 3> ColorsOf(const PictureFile& file) {
  std::array<int, 3> found{};
  std::string list;
  for (const std::string& name : file.channels())
    list += (list.empty() ? "" : ", ") + name;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name(1, "RGB"[c]);
    const auto& names = file.channels();
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
      file.Refuse("has no channel " + name + ", but " + list +
                  "; save the panorama as R, G, B");
    }
    found[c] = static_cast<int>(at - names.begin());
  }
  return found;
}

}  // namespace

LatLongFile ReadLatLong(const fs::path& path, int max_width, const Progress& progress) {
  PictureFile file(path, /*takes_hdr=*/true);
  if (file.format() != PictureFormat::kExr && file.format() != PictureFormat::kHdr) {
    file.Refuse(
        "is neither OpenEXR nor Radiance .hdr; a panorama of the sky needs values above "
        "white, which other formats do not hold");
  }
  file.CheckSize();
  RequireWholeSphere(file);
  const std::array<int, 3> rgb = ColorsOf(file);

  LatLongFile read;
  read.size = file.size();
  const int width = std::min(read.size.width, max_width / 2 * 2);
  Shrinker smaller(read.size, {width, width / 2});
  if (width == read.size.width) read.pixels.create(read.size);
  std::vector<cv::Vec3f> row(static_cast<std::size_t>(read.size.width));
  file.ReadBands(
      [&](int first_row, const cv::Mat& band) {
        cv::Mat floats;
        band.convertTo(floats, CV_32F);
        const int channels = floats.channels();
        for (int y = 0; y < floats.rows; ++y) {
          const float* from = floats.ptr<float>(y);
          for (int x = 0; x < floats.cols; ++x, from += channels) {
            const cv::Vec3f color(from[rgb[0]], from[rgb[1]], from[rgb[2]]);
            if (const auto fault = FaultOf(color)) {
              file.Refuse("holds " + *fault + " at column " + std::to_string(x) +
                          ", row " + std::to_string(first_row + y) +
                          "; mend that pixel, or export the panorama again");
            }
            for (int c = 0; c < 3; ++c) {
              read.largest = std::max<double>(read.largest, color[c]);
            }
            row[static_cast<std::size_t>(x)] = color;
          }
          if (read.pixels.empty()) {
            smaller.Add(first_row + y, row.data());
          } else {
            std::copy(row.begin(), row.end(), read.pixels.ptr<cv::Vec3f>(first_row + y));
          }
        }
      },
      progress);
  if (read.pixels.empty()) read.pixels = smaller.Result();
  for (const std::string& name : file.TextNames()) {
    if (name.rfind(kPrefix, 0) == 0) read.metadata[name] = *file.Text(name);
  }
  return read;
}

cv::Mat3f ShrunkLatLong(const cv::Mat3f& pixels, int width) {
  if (pixels.cols <= width) return pixels;
  Shrinker smaller(pixels.size(), {width, width / 2});
  for (int y = 0; y < pixels.rows; ++y) smaller.Add(y, pixels.ptr<cv::Vec3f>(y));
  return smaller.Result();
}

}  // namespace relight
