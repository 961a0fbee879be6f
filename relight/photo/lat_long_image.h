// SPDX-License-Identifier: Apache-2.0
#pragma once

// Panoramas of the whole sphere, twice as wide as high: columns are equal steps of
// azimuth, rows of elevation from the zenith down (docs/conventions.md#panoramas).

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <map>
#include <string>

namespace relight {

struct LatLongFile {
  cv::Mat3f pixels;                             // Linear Rec.709, in the file's own unit.
  cv::Size size;                                // Of the file; `pixels` may be smaller.
  double largest = 0;                           // Of all the file's samples.
  std::map<std::string, std::string> metadata;  // Texts named "relight:…".
};

// An .exr (channels R, G, B) or .hdr (Radiance), told by its first bytes. Wider than
// `max_width` it is made smaller while it is read, so that its size on the disk does not
// matter. A negative channel is a colour outside of Rec.709 as long as the colour's XYZ
// is not negative. Throws InputError that names the file, the pixel and a remedy: another
// kind of file, not twice as wide as high, NaN, infinite, light below 0.
LatLongFile ReadLatLong(const std::filesystem::path& path,
                        int max_width,
                        const Progress& progress = {});

// Means over areas of the sphere, which keep the sum of values times solid angle. A
// picture that is no wider is answered as it is.
cv::Mat3f ShrunkLatLong(const cv::Mat3f& pixels, int width);

}  // namespace relight
