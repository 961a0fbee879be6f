// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colours of foreground and background under a matte, on several levels.
//
//   [Germer20] docs/bibliography.md#germer20
//
// At every pixel i, with its four neighbours j and a_i the matte, F and B minimise
//
//   (a_i F_i + (1 - a_i) B_i - I_i)^2
//     + sum_j (r + g |a_i - a_j|) ((F_i - F_j)^2 + (B_i - B_j)^2)         (M3)
//
// solved per channel, pixel by pixel, from 1 x 1 pixel up to the photo's own size, each
// level starting from the one before. Where the matte is 0 the foreground goes on
// smoothly from where it is not, so that no colour of the sky is left on a leaf's edge.

#include "relight/base/field.h"
#include "relight/base/progress.h"

#include <opencv2/core.hpp>

namespace relight {

struct ForegroundOptions {
  double smoothness = 1e-5;      // r of (M3).
  double gradient_weight = 1.0;  // g of (M3).
  int small_iterations = 10;     // Passes on levels up to 32 pixels.
  int large_iterations = 4;      // Passes on the others.
};

template <class Visitor>
void Describe(ForegroundOptions& o, Visitor&& field) {
  field(o.smoothness, FieldInfo{"foreground-smoothness", "", "r of (M3)", Above(0)});
  field(o.gradient_weight, FieldInfo{"foreground-gradient", "", "g of (M3)", AtLeast(0)});
  field(o.small_iterations,
        FieldInfo{"foreground-small-passes", "", "passes on small levels", AtLeast(1)});
  field(o.large_iterations,
        FieldInfo{"foreground-large-passes", "", "passes on large levels", AtLeast(1)});
}

struct ForegroundColors {
  cv::Mat3f foreground;  // >= 0; exactly the photo's where alpha is 1.
  cv::Mat3f background;  // >= 0; exactly the photo's where alpha is 0.
};

// `linear`: the photo in linear light, where a pixel really is the mixture (M3) says.
// Throws InputError when the sizes differ, OptionError, Cancelled. The result does not
// depend on the threads.
ForegroundColors EstimateForeground(const cv::Mat3f& linear,
                                    const cv::Mat1f& alpha,
                                    const ForegroundOptions& options = {},
                                    const Progress& progress = {});

}  // namespace relight
