// SPDX-License-Identifier: Apache-2.0
#pragma once

// Any daylight drawn as a lat-long panorama, north in the middle, east on its right,
// zenith on top (docs/conventions.md#panoramas).

#include "relight/sky/daylight.h"

#include <opencv2/core.hpp>

namespace relight {

// 2 height x height, linear Rec.709 [cd/m2], black below the horizon. The sun is in it, a
// disc of its size: pixels that it covers in part have their part, and all together its
// irradiance, so that panorama.h finds the same sun again.
cv::Mat3f DrawPanorama(const Daylight& daylight, int height = 512);

// For looking at: per channel 1 - exp(-L / (2 m)), m the mean luminance by solid angle of
// all of the sky but its brightest thousandth (the sun), negative channels 0. The mean is
// then 0.39 of white, half of it 0.22, and only the sun and what is near it white.
// Linear, in [0, 1].
cv::Mat3f ToneMappedPanorama(const cv::Mat3f& panorama);

}  // namespace relight
