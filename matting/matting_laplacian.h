// SPDX-License-Identifier: Apache-2.0
#pragma once

// The matting Laplacian of an image over some of its pixels.
//
//   [Levin08] docs/bibliography.md#levin08
//
// The sum over the windows w of 9 pixels, with mean mu and covariance Sigma of colour, of
//
//   L_ij = delta_ij - (1 + (I_i - mu)^T (Sigma + eps/9 Id)^-1 (I_j - mu)) / 9   (M2)

#include "matting/stencil_matrix.h"

#include <opencv2/core.hpp>

namespace relight {

// Adds L to `matrix`: all windows of `image` that hold a pixel of the system; what
// couples to pixels outside the system is left out. Sums are made in double precision per
// window. The same bytes for any number of threads. Throws Cancelled.
void AddMattingLaplacian(const cv::Mat3f& image,
                         double epsilon,
                         StencilMatrix& matrix,
                         const Progress& progress = {});

}  // namespace relight
