// SPDX-License-Identifier: Apache-2.0
#pragma once

// The matte of a photo from clusters of colour.
//
//   [Reche04] §4, Eq. 3     docs/bibliography.md#reche04
//   [Ruzon00]               docs/bibliography.md#ruzon00
//
// What the trimap knows of tree and of background is clustered in CIE LAB, each cluster a
// Gaussian. A pixel is a linear interpolation there of a foreground and a background,
//
//   C_p = alpha C_f + (1 - alpha) C_b                                     [Reche04, Eq.
//   3]
//
// and alpha is that whose Gaussians, interpolated in mean and covariance between every
// pair of clusters and weighted by their shares, make its colour likeliest. Pixels do not
// know their neighbours. Clusters are those of the whole photo, for the zones that
// [Reche04]'s user draws are; [Ruzon00] clusters along the object's edge.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

namespace relight {

// `display`: the photo, display values in [0, 1]. `trimap`: trimap.h. Known pixels come
// back as they are. Throws InputError as CheckTrimap does, and when the sizes differ;
// Cancelled. The result does not depend on the threads.
cv::Mat1f EstimateClusterMatte(const cv::Mat3f& display,
                               const cv::Mat1b& trimap,
                               const Progress& progress = {});

}  // namespace relight
