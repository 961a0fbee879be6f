// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ratio image and what it does to a photograph, per channel, in linear light:
//
//   I_r = E_targ / E_in,   I_targ = I_r I_in               [Cabral11, Eq. 3] [Cabral11,
//   Eq. 4]
//
// Departs from [Cabral11, Eq. 3]: both lights are floored at one small value, for the
// ratio has no bound where the volume is black at the input hour. Equal lights still
// give 1.

#include <opencv2/core.hpp>

namespace relight {

struct RatioOptions {
  double floor =
      0.005;  // Of the mean of the input's light over the pixels that have any.
};

// The light below which both hours are taken as equal, per channel.
cv::Vec3f RatioFloor(const cv::Mat3f& input_light, const RatioOptions& options = {});

// E_targ / E_in per channel; 1 exactly where the two are equal, and where both are 0.
cv::Mat3f RatioImage(const cv::Mat3f& input_light,
                     const cv::Mat3f& target_light,
                     const cv::Vec3f& floor);

}  // namespace relight
