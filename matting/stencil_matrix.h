// SPDX-License-Identifier: Apache-2.0
#pragma once

// Symmetric matrices over some pixels of an image, where a pixel is coupled to the 5 x 5
// pixels around it: what the matting Laplacian, summed over 3 x 3 windows, makes.
//
// Memory is that of the pixels in the system, not of the image: 13 numbers each (the
// diagonal and the 12 neighbours that come later in reading order), in runs along rows,
// so that a neighbour needs no index of its own.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <functional>
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
// belongs to no run: its entries and values stay 0. Below 2^31 slots. Throws Cancelled.
struct PixelRuns {
  explicit PixelRuns(const cv::Mat1b& inside, const Progress& progress = {});

  std::vector<PixelRun> runs;     // In reading order.
  std::vector<int> first_of_row;  // Image height + 1; runs of row y are half-open.
  std::int32_t slots = 0;
  std::int64_t pixels = 0;  // Slots that are inside.

  std::span<const PixelRun> OfRow(int y) const {
    return {runs.data() + first_of_row[y], runs.data() + first_of_row[y + 1]};
  }
  int rows() const { return static_cast<int>(first_of_row.size()) - 1; }
};

// Calls body(first row, end row) for stripes of rows, every second one at a time, so that
// stripes that touch never run together: a body may change what lies up to two rows
// outside its own. The order is the same for any number of threads. Throws Cancelled.
void ForStripes(int rows,
                bool upwards,
                const std::function<void(int, int)>& body,
                const Progress& progress = {});

// entry[k][i]: coupling of the pixel in slot i with its neighbour k; 0 where either is
// outside the system.
struct StencilMatrix {
  // Zero. Throws Cancelled.
  explicit StencilMatrix(const PixelRuns& pixels, const Progress& progress = {});

  const PixelRuns* pixels;  // Not owned.
  std::array<std::vector<float>, kStencil> entry;
};

// A x. Same bytes for any number of threads. `Real` is float or double.
template <class Real>
void Multiply(const StencilMatrix& a,
              std::span<const Real> x,
              std::span<Real> product,
              const Progress& progress = {});

// One pass of Gauss and Seidel over A x = b; backwards it is the adjoint of forwards.
void Relax(const StencilMatrix& a,
           std::span<const float> b,
           std::span<float> x,
           bool backwards,
           const Progress& progress = {});

}  // namespace relight
