// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures to the bytes of a file, also for relight/composite; the only writer of pixels.
//
// Files are made in memory and put on the disk by WriteFileWhole: a full disk is noticed
// there, whatever the format's own library makes of it (the JPEG library ends the
// process).

#include "relight/photo/picture_file.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace relight {

struct PictureToEncode {
  cv::Mat samples = {};  // CV_8U, CV_16U or CV_32F, interleaved channels.
  std::vector<std::string> channels = {};  // A name each; by it an EXR finds them again.
  int alpha_channel = -1;                  // Straight but in an EXR.
  bool half = false;                       // CV_32F stored as half, which it must fit.
  int quality = 95;                        // Of a JPEG, 1 to 100.
  bool display_encoded = true;  // sRGB; else numbers that are no colours, or linear.
  std::vector<std::pair<std::string, std::string>> metadata = {};
};

// The same bytes for the same picture: no time stamp. `file` is for messages.
std::string EncodePicture(PictureFormat format,
                          const PictureToEncode& picture,
                          const std::filesystem::path& file);

}  // namespace relight
