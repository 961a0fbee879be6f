// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images that are no photos: mattes, and linear layers between the stages. No colour is
// converted; EXIF orientation is applied as for photos.

#include <opencv2/core.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace relight {

// A matte in [0, 1]: the alpha channel where the file has one that is not opaque all
// over, else the values of a grey picture (or one of equal R, G, B), divided by the
// largest its samples can hold. Floats are clipped to [0, 1]. Throws InputError when the
// file is missing, damaged, coloured, or holds NaN or floats above 1.5 (0 to 255 as
// floats, say).
cv::Mat1f ReadMatte(const std::filesystem::path& path);

// 16-bit grey PNG: off by 1/131070 at most. Values are clipped to [0, 1], NaN is refused
// (std::logic_error). Throws InputError when the file cannot be written whole.
void WriteMatte(const std::filesystem::path& path, const cv::Mat1f& matte);

// One image of a linear file. Channels of "sun" are sun.R, sun.G, sun.B, or sun.Y for a
// single one; of "" they are R, G, B, or Y.
struct LinearLayer {
  std::string name;
  cv::Mat values;  // CV_32FC3 in the order R, G, B, or CV_32FC1.
};

struct LinearFile {
  std::vector<LinearLayer> layers;  // By name.
  std::map<std::string, std::string>
      metadata;  // Texts whose name begins with "relight:".
};

enum class LinearDepth { kFloat, kHalf };

// OpenEXR, losslessly compressed; the same layers give the same bytes. What does not fit
// a half float (above 65504) becomes its largest. Names of `metadata` begin with
// "relight:". All layers are of one size, names are distinct. Throws InputError when the
// file cannot be written whole.
void WriteLinear(const std::filesystem::path& path,
                 const std::vector<LinearLayer>& layers,
                 const std::map<std::string, std::string>& metadata = {},
                 LinearDepth depth = LinearDepth::kFloat);

// All of it, as written, NaN included. Throws InputError.
LinearFile ReadLinearFile(const std::filesystem::path& path);

// The layer `name` of it as RGB; a single channel three times. Throws InputError that
// lists the layers when it is not there.
cv::Mat3f ReadLinear(const std::filesystem::path& path, const std::string& name = "");

}  // namespace relight
