// SPDX-License-Identifier: Apache-2.0
#pragma once

// A photograph as the program computes with it.

#include <opencv2/core.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace relight {

// Upright, height x width. Finite; negative values occur (colours outside Rec.709).
struct Photo {
  cv::Mat3f
      pixels;  // Scene-linear Rec.709 in the order R, G, B; straight, not premultiplied.
  cv::Mat1f alpha = {};  // In [0, 1]; empty when the file has none.

  // What a user should know about how the file was read, one sentence each.
  std::vector<std::string> notes = {};
  // Pixels that held NaN or infinity and are black now.
  std::int64_t non_finite_pixels = 0;
};

}  // namespace relight
