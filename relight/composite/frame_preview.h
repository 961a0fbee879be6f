// SPDX-License-Identifier: Apache-2.0
#pragma once

// A frame as a screen shows it, small: for contact sheets, pages and videos.

#include "relight/photo/photo.h"

#include <opencv2/core.hpp>

namespace relight {

// 8-bit sRGB in the order R, G, B, no side longer than `longest_px`; means over the
// photo's pixels in linear light. Transparency is laid over a light grey.
cv::Mat3b PreviewOf(const Photo& photo, int longest_px);

// The same of a preview, as tall or wide as fits into `size`.
cv::Mat3b Smaller(const cv::Mat3b& preview, cv::Size size);

}  // namespace relight
