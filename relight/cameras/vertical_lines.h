// SPDX-License-Identifier: Apache-2.0
#pragma once

// The world's up in a photo from its upright lines: walls, poles, trunks of a wood.
//
// A segment's two ends have rays a, b (relight/cameras/photo_orientation.h); it is
// upright when its plane m = (a x b)/|a x b| holds the world's up n: m.n = 0. Each pair
// of long segments proposes n = m_i x m_j; the one that most length of lines agrees with
// is refined over those, w being a line's length,
//
//   n = argmin sum_i w_i (m_i.n)^2,   |n| = 1                            (C5)
//
// A lens that bends lines bends n by degrees, so that k1 of (C1) is tried in steps, and
// the one that most length agrees with is taken where it wins clearly over none.
//
// Trees are bad lines, and a wrong tilt is worse than none: nothing is answered unless
// eight lines or more agree to 0.3 degrees, hold half the length of all that are nearly
// upright, lie in several parts of the photo's width, and fix n to a degree whichever
// quarter of them is left out.

#include "relight/cameras/camera.h"

#include <opencv2/core.hpp>

#include <optional>

namespace relight {

struct UprightLines {
  Eigen::Vector3d up_in_camera;  // Unit length.
  int lines = 0;                 // That agree.
  double share = 0.0;            // Their part of the length of nearly upright lines.
  double error_deg = 0.0;        // Standard error of up_in_camera.
  Lens lens;                     // With k1 when the lines are bent; else a pinhole's.
};

// `grey` is display-encoded. Looks for a camera pitched by less than 35 and rolled by
// less than 15 degrees. `camera` has focal length and centre; its pose and lens are
// ignored. The same answer for the same picture.
std::optional<UprightLines> FindUprightLines(const cv::Mat1b& grey, const Camera& camera);

}  // namespace relight
