// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solves the system of a matting Laplacian by conjugate gradients, preconditioned by
// color_multigrid.h: some tens of iterations at every size of photo.
//
// Numbers are single precision, sums double: the right side of a matting system is known
// to 8 bits, and the minimum found is within 1/255 of a direct solver's in double
// precision on the photographs of tests/benchmark (benchmark_matting prints how near).

#include "matting/stencil_matrix.h"
#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <functional>
#include <span>

namespace relight {

struct SolveOptions {
  double relative_residual = 1e-8;  // |b - A x| / |b| that is enough.
  int most_iterations = 500;
  // Told x after every iteration; false: it is good enough. For measurements.
  std::function<bool(std::span<const float>)> enough = {};
};

struct SolveSummary {
  int iterations = 0;
  double relative_residual = 0.0;  // Above the wanted one: iterations were not enough.
};

// Solves A x = b, A the matting Laplacian of `image` plus a diagonal that is not
// negative and somewhere positive. All spans have a value a slot; those outside the
// system are 0 and stay so. Starts from what the coarse grids alone say. The same bytes
// for any number of threads. Throws Cancelled, soon after it was asked to.
SolveSummary SolveLaplacian(const StencilMatrix& a,
                            const cv::Mat3f& image,
                            std::span<const float> b,
                            std::span<float> x,
                            const SolveOptions& options = {},
                            const Progress& progress = {});

}  // namespace relight
