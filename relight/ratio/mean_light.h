// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light that a pixel's leaves receive: the mean over its view ray,
//
//   M(x) = E(x) / sum of tau sigma du                                     (R1)
//
// Rays that meet next to no volume though the matte is not empty have no mean of their
// own. With w = sum of tau sigma du, their light is blended from neighbours inside the
// matte, each counting by its own w, over a pyramid so that any gap is filled:
//
//   M'(x) = a M(x) + (1 - a) N(x),   a = min(1, w / w_0)                  (R2)
//
// The ratio of two hours is that of their M', and where a = 1 that of their E.

#include "relight/scattering/single_scattering.h"

#include <opencv2/core.hpp>

namespace relight {

struct MeanLightOptions {
  double full_weight = 0.05;  // w_0 of (R2).
  double smoothing_px = 0.0;  // Standard deviation of a blur of E and w first; 0: none.
};

// `irradiance` and `weight` as SingleScattering made them, `inside` non-zero in the
// matte. 0 outside, and everywhere when no ray meets the volume.
cv::Mat3f MeanLight(const cv::Mat3f& irradiance,
                    const cv::Mat1f& weight,
                    const cv::Mat1b& inside,
                    const MeanLightOptions& options = {});

}  // namespace relight
