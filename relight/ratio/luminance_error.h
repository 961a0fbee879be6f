// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a relit picture is too bright or too dark against the true one.
//
//   D = (Y(g result) - Y(truth)) / p                                              (E7)
//
// with Y the luminance of Rec.709, g the gain per channel and p the 99th percentile of
// (E1) and (E2), relight/ratio/relighting_score.h: a wrong exposure does not show, a
// wrong shadow does.

#include "relight/ratio/relighting_score.h"

#include <opencv2/core.hpp>

namespace relight {

// (E7) inside, 0 elsewhere. `score` is that of the same pictures and options.
cv::Mat1f LuminanceError(const RelightingPictures& pictures,
                         const RelightingScore& score,
                         const RelightingScoreOptions& options = {});

// What is in full colour in the picture: half of p.
inline constexpr double kFullColorError = 0.5;

// 8-bit sRGB: white where right, to red where the result is brighter by kFullColorError
// or more, to blue where darker; outside dark grey.
cv::Mat3b LuminanceErrorPicture(const cv::Mat1f& error, const cv::Mat1b& inside);

}  // namespace relight
