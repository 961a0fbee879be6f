// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras that look past what the others look at.
//
// The axes of cameras around a tree pass near one point of it. Candidates for that point
// are halfway between two axes where these are nearest; the one that most cameras have in
// their pictures is taken. A camera is strange when the point is behind it, or outside
// its picture by more than a quarter of the picture's width or height: one that cuts the
// tree off at its border is not.
//
// Nothing is said of cameras that do not go around anything: fewer than four, axes nearly
// parallel (a drone looking down, a row of pictures of one side), or no point that two
// thirds of them have in their pictures.

#include "relight/cameras/calibrated_scene.h"

#include <span>
#include <string>
#include <vector>

namespace relight {

struct ViewOfAnotherTree {
  std::string view;
  double off_axis_deg = 0.0;  // Between its axis and the point of the others; to 180.
};

// In the order of `cameras`; mostly empty.
std::vector<ViewOfAnotherTree> ViewsOfAnotherTree(std::span<const NamedCamera> cameras);

}  // namespace relight
