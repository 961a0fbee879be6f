// SPDX-License-Identifier: Apache-2.0
#pragma once

// Trimap of what stands before a blue or green screen, and its colours without the
// screen's light on them.
//
// How much of a pixel is screen shows in how far the screen's channel stands out,
// whatever the light on it:
//
//   k = (c_s - max of the other two) / c_s                                    (M8)
//
// over the same of the screen's own colour: above 0.9 screen, below 0.1 none, between
// unknown, with two pixels around. A pixel too dark to tell is unknown.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <optional>
#include <string>

namespace relight {

struct Screen {
  cv::Vec3f color;  // Linear light, R, G, B.
  int channel = 2;  // The one that stands out: 1 green, 2 blue.
};

// "auto" (the colour found in the photo), "blue", "green" (of that hue, found), or
// "R,G,B" of 0 to 255 display values. Throws OptionError for other words, InputError when
// the photo shows no such screen.
Screen FindScreen(const cv::Mat3f& linear, const std::string& words);

// Labels of trimap.h. Throws InputError when nothing stands before it, Cancelled.
cv::Mat1b TrimapFromScreen(const cv::Mat3f& linear,
                           const Screen& screen,
                           const Progress& progress = {});

// Takes the screen's light off colours: its channel is never above both others. Leaves
// before a green screen lose their green by it: blue is the screen for trees.
void RemoveSpill(cv::Mat3f& foreground, const Screen& screen);

}  // namespace relight
