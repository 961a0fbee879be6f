// SPDX-License-Identifier: Apache-2.0
#pragma once

// A first guess of the matte from colours alone, for pixels that no smoothness reaches:
// sky seen through a crown, where every window is leaf on one side and sky on the other.
//
// Each unknown pixel is taken as a mixture of a foreground and a background colour from
// samples: the nearest known blocks of 4 x 4 pixels in eight directions (where none is in
// sight, the commonest colours of all known ones). With F, B such a pair,
//
//   a = (I - B)(F - B) / |F - B|^2 in [0, 1],   r = |I - a F - (1 - a) B|        (M4)
//   cost = (r / s)^2 + 4 p a (1 - a)                                             (M5)
//
// with every channel's difference multiplied by the slope of the sRGB curve at I, so that
// r is in display values. p prefers a pure colour to a mixture that explains as well.
// alpha* is the mean of the pairs' a, weighted by exp(-cost / 2); the confidence that it
// enters D of (M1) with falls with r, with the spread of a over the pairs, and where F
// and B are alike.
//
// Leaves in the sun are brighter than those that are surely tree, for a bright leaf is
// nearer to the sky: a mixture of dark leaf and sky is taken for them, with colours that
// are too dark. Light changes a leaf's brightness more than its hue. For a tree that was
// found before the sky, F is each sample f made brighter, as the pixel tells itself:
//
//   F = t f,  t in [1, brightest] of the p f + q B nearest to I, t = p / (1 - q)   (M11)
//
// so that a leaf of any brightness is told from sky by its hue, as before a blue screen.
// For other things, and with trimaps that are given, it explains too much, and is off.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

namespace relight {

struct ColorPriorOptions {
  double sigma = 0.045;    // s of (M5), in display values.
  double purity = 10.0;    // p of (M5).
  double agreement = 0.1;  // Standard deviation of a over the pairs that still says much.
  double brightest = 1.0;  // Of (M11); 1: samples as they are.
};

struct ColorPrior {
  cv::Mat1f alpha;       // alpha* of unknown pixels; 0 elsewhere. Empty: no prior.
  cv::Mat1f confidence;  // [0, 1]; 0 for known pixels.
};

// `linear`: the photo in linear light, where a pixel is the mixture (M4) says. Throws
// Cancelled. The result does not depend on the threads.
ColorPrior EstimateColorPrior(const cv::Mat3f& linear,
                              const cv::Mat1b& trimap,
                              const ColorPriorOptions& options = {},
                              const Progress& progress = {});

}  // namespace relight
