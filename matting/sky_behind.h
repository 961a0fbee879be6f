// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sky behind a tree: where it shows, its colour all over the picture, also behind the
// crown, and how far a pixel is from it.
//
// Sky is smooth, reaches the upper border, and is blue or bright there. Its colour s(x,
// y) is a polynomial, linear across and quadratic in height, and what that leaves
// averaged over rows, then locally. Of a pixel's colour c, both in CIELAB (L* 0 to 100),
//
//   d = |c - s|                                                           (M9)
//
// is 0 for sky and grows with alpha up to the tree's contrast, the 90th percentile of
// what stands before the sky. Where pixels are like s, as in the holes of a crown, they
// are sky too and s is found anew: three times over.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

namespace relight {

// All lengths of colour in units of CIELAB; masks are 255 or 0, at the picture's size.
struct SkyBehind {
  double share = 0;    // Of the upper border, [0, 1]. 0: no sky, and d is 0 all over.
  cv::Mat3f color;     // s of (M9), a cell each 8 x 8 pixels; empty without sky.
  cv::Mat1f distance;  // d of (M9), at the picture's size.
  cv::Mat1b known, ground;  // Seen to be sky; smooth and at the lower border.
  double spread = 1;        // Standard deviation of the sky itself, at least 1.
  double contrast = 0;      // The tree's.
  int horizon = -1;  // The lowest row that shows sky, three rows up: it is blurred.
};

// `display`: display-encoded RGB, not empty; some 400 000 pixels tell all that a photo
// says. A photo without sky is an answer: share 0. Throws Cancelled.
SkyBehind FindSky(const cv::Mat3f& display, const Progress& progress = {});

// d of (M9) for the rows from `first` on of a photo of `photo_rows` rows, of any size:
// the sky's colour is stretched over it. NaN is black. The sky must have a share.
cv::Mat1f DistanceToSky(const cv::Mat3f& display_rows,
                        int first,
                        int photo_rows,
                        const SkyBehind& sky);

// The sky's spread in a photo of any size, from a sample of its rows: larger than at the
// reduced size, where noise was averaged; never smaller.
double SkySpread(const cv::Mat3f& display, const SkyBehind& sky);

}  // namespace relight
