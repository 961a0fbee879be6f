// SPDX-License-Identifier: Apache-2.0
#pragma once

// The layers of a montage, and what they make when they are flat.
//
// Editors keep layers in 8 bits, encoded as sRGB, and blend those values. With D the
// encoded value (relight/photo/color.h) of tree t, shadow s and backdrop b, cut to [0,
// 1], and a the tree's alpha,
//
//   D = (1 - a) D_b D_s + a D_t                                                 (G3)
//
// which is what GIMP 2.10 makes of an 8-bit sRGB image: *multiply (legacy)* under *normal
// (legacy)*. The flat picture is computed without the layers' rounding to 8 bits, and
// lies within two steps of the one that is computed with it.
//
// A product of encoded values is nearly the encoded product: sRGB is close to a power
// law.

#include <opencv2/core.hpp>

namespace relight {

// All of one size, linear Rec.709.
struct Montage {
  cv::Mat3f tree;           // Straight.
  cv::Mat1f alpha;          // Of the tree, in [0, 1].
  cv::Mat3f shadow = {};    // To multiply with, in [0, 1]; empty: none.
  cv::Mat3f backdrop = {};  // Empty: white.
};

// D of (G3), in [0, 1].
cv::Mat3f FlatDisplay(const Montage& montage);

// The same as linear light.
cv::Mat3f FlatPicture(const Montage& montage);

}  // namespace relight
