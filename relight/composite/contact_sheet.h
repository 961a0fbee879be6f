// SPDX-License-Identifier: Apache-2.0
#pragma once

// All frames of a day on one picture: under each its hour, and a small compass that shows
// the sun as one sees it on a plan with the camera below, looking up the page: a dot for
// the sun, the nearer to the middle the higher, and an arrow the way its light falls.

#include "relight/photo/write_photo.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <string>

namespace relight {

class ContactSheet {
 public:
  // `frames` of one shape are to come.
  ContactSheet(int frames, cv::Size frame_size);

  // The next frame, as PreviewOf makes it. The sun is 0 straight ahead of the camera,
  // pi/2 on its right. `label` in ASCII.
  void Add(const cv::Mat3b& preview,
           const std::string& label,
           double sun_from_heading_rad,
           double sun_elevation_rad);

  const cv::Mat3b& picture() const { return picture_; }

 private:
  cv::Size cell_, thumbnail_;
  int frames_ = 0, columns_ = 1, added_ = 0;
  cv::Mat3b picture_;
};

// A picture of 8 bits as PNG or JPEG, by extension; whole or not at all.
void WriteSheet(const std::filesystem::path& path,
                const cv::Mat3b& picture,
                const Provenance& provenance);

// The same as the bytes of a JPEG.
std::string JpegOf(const cv::Mat3b& picture, int quality);

}  // namespace relight
