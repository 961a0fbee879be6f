// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far the ratio of each pixel is to be trusted, from 0 to 1:
//
//   s(x) = 1 - f (1 - min(1, w / w_0) t exp(-(d / d_0)^2))                (R6)
//
// f   1 - exp(-(gamma / gamma_0)^2) of (R3): hours that are equal are sure
// w   share of the view ray that the volume stops, w_0 = 0.05 as in (R2)
// t   how far the features of the correction are known, (R4)
// d   standard deviation of the perceptrons' answers, d_0 = 0.3
//
// A rank, not a probability: docs/validation.md has the error of relit pictures against
// it. Without a correction t = 1 and d = 0.

#include "relight/ratio/relight_view.h"

#include <opencv2/core.hpp>

namespace relight {

// `light` as RelitView made it; `sun_angle_rad`: gamma. 0 where there is no tree.
cv::Mat1f Confidence(const ViewLight& light,
                     const cv::Mat1f& alpha,
                     double sun_angle_rad);

}  // namespace relight
