// SPDX-License-Identifier: Apache-2.0
#pragma once

// Symmetric positive definite systems A x = b over some pixels of an image, where a pixel
// is coupled to the 5 x 5 pixels around it: what the matting Laplacian, summed over 3 x 3
// windows, makes. Solved by preconditioned conjugate gradients, the preconditioner an
// incomplete Cholesky factor of the same stencil.
//
// Memory is that of the pixels in the system, not of the image: 13 numbers each (the
// diagonal and the 12 neighbours that come later in reading order), in runs along rows,
// so that a neighbour needs no index of its own.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace relight {

// Half of the 5 x 5 stencil: (dx, dy) of neighbour k.
inline constexpr int kStencil = 13;
inline constexpr std::array<std::array<int, 2>, kStencil> kStencilOffset = {{{0, 0},
                                                                             {1, 0},
                                                                             {2, 0},
                                                                             {-2, 1},
                                                                             {-1, 1},
                                                                             {0, 1},
                                                                             {1, 1},
                                                                             {2, 1},
                                                                             {-2, 2},
                                                                             {-1, 2},
                                                                             {0, 2},
                                                                             {1, 2},
                                                                             {2, 2}}};

// Pixels (x ... x + length - 1, y) of the system, in consecutive slots. below[d] is the
// slot of pixel (x, y + d), so pixel (x + i + dx, y + d) has slot below[d] + i + dx for
// every |dx| <= 2: the slots exist though a pixel there may be outside the system.
struct PixelRun {
  int x = 0, y = 0, length = 0;
  std::array<std::int32_t, 3> below = {};  // below[0] is the run's own first slot.
  std::array<std::int32_t, 3> above = {};
};

// Slots of the pixels where `inside` is not 0, and of a margin of 2 around them that
// belongs to no run: its entries and values stay 0.
struct PixelRuns {
  explicit PixelRuns(const cv::Mat1b& inside);

  std::vector<PixelRun> runs;  // In reading order.
  std::vector<int>
      first_of_row;  // Image height + 1; runs of row y are a half-open range.
  std::int32_t slots = 0;
  std::int64_t pixels = 0;  // Slots that are inside.
};

// entry[k][i]: coupling of the pixel in slot i with its neighbour k; 0 where either is
// outside the system.
struct StencilMatrix {
  explicit StencilMatrix(const PixelRuns& pixels);

  const PixelRuns* pixels;  // Not owned.
  std::array<std::vector<double>, kStencil> entry;
};

// A x. Same bytes for any number of threads.
void Multiply(const StencilMatrix& a,
              std::span<const double> x,
              std::span<double> product);

struct SolveOptions {
  double relative_residual = 1e-6;  // |b - A x| / |b| that is enough.
  int most_iterations = 2000;
};

struct SolveSummary {
  int iterations = 0;
  double relative_residual =
      0.0;  // Above the wanted one: most_iterations were not enough.
};

// Solves A x = b from the x given. All spans have a value a slot; those outside the
// system are 0 and stay so. The same bytes for any number of threads. Throws Cancelled.
SolveSummary SolveByConjugateGradients(const StencilMatrix& a,
                                       std::span<const double> b,
                                       std::span<double> x,
                                       const SolveOptions& options = {},
                                       const Progress& progress = {});

}  // namespace relight
