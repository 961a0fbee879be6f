// SPDX-License-Identifier: Apache-2.0
#include "matting/stencil_matrix.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <algorithm>
#include <limits>

namespace relight {
namespace {

constexpr int kMargin = 2;       // Reach of the stencil.
constexpr int kStripeRows = 32;  // The order of a relaxation depends on it.

// (x, y) is (0, 0) at the first pixel of the margin.
struct StoredRun {
  int x = 0, end = 0;
  std::int32_t slot = 0;
};

}  // namespace

PixelRuns::PixelRuns(const cv::Mat1b& inside, const Progress& progress) {
  const int rows = inside.rows, cols = inside.cols;
  const int wide = cols + 2 * kMargin;

  // Slots: the pixels of the system and all within the reach of the stencil
  std::vector<std::vector<StoredRun>> stored(
      static_cast<std::size_t>(rows + 2 * kMargin));
  std::vector<int> reach(wide + 1);
  std::int64_t next = 0;
  for (int y = 0; y < rows + 2 * kMargin; ++y) {
    if (y % kStripeRows == 0) progress.Report(0.7 * y / (rows + 2 * kMargin));
    std::fill(reach.begin(), reach.end(), 0);
    for (int v = std::max(0, y - 2 * kMargin); v <= std::min(rows - 1, y); ++v) {
      const std::uint8_t* in = inside[v];
      for (int x = 0; x < cols; ++x) {
        if (in[x]) ++reach[x], --reach[x + 2 * kMargin + 1];
      }
    }
    int covered = 0;
    for (int x = 0; x < wide; ++x) {
      const bool was = covered > 0;
      covered += reach[x];
      if (covered > 0 && !was)
        stored[y].push_back({x, x, static_cast<std::int32_t>(next)});
      if (covered > 0) stored[y].back().end = x + 1, ++next;
    }
  }
  Require(next < std::numeric_limits<std::int32_t>::max(), "slots fit 32 bits");
  slots = static_cast<std::int32_t>(next);

  // Runs of pixels of the system, with the slots of the rows around
  const auto slot_of = [&](int x, int y) {
    const auto& row = stored[y + kMargin];
    const auto after = std::upper_bound(
        row.begin(), row.end(), x + kMargin, [](int v, const StoredRun& r) {
          return v < r.x;
        });
    const StoredRun& run = *std::prev(after);
    return run.slot + (x + kMargin - run.x);
  };
  first_of_row.reserve(rows + 1);
  for (int y = 0; y < rows; ++y) {
    if (y % kStripeRows == 0) progress.Report(0.7 + 0.3 * y / rows);
    first_of_row.push_back(static_cast<int>(runs.size()));
    for (int x = 0; x < cols;) {
      if (!inside(y, x)) {
        ++x;
        continue;
      }
      PixelRun run{.x = x, .y = y};
      while (x < cols && inside(y, x)) ++x;
      run.length = x - run.x;
      for (int d = 0; d <= kMargin; ++d) {
        run.below[d] = slot_of(run.x, y + d);
        run.above[d] = slot_of(run.x, y - d);
      }
      pixels += run.length;
      runs.push_back(run);
    }
  }
  first_of_row.push_back(static_cast<int>(runs.size()));
}

void ForStripes(int rows,
                bool upwards,
                const std::function<void(int, int)>& body,
                const Progress& progress) {
  const int stripes = (rows + kStripeRows - 1) / kStripeRows;
  for (const int phase : {0, 1}) {
    const int odd = upwards ? 1 - phase : phase;
    ParallelRanges((stripes + 1 - odd) / 2,
                   1,
                   [&](int begin, int end) {
                     for (int s = begin; s < end; ++s) {
                       const int first = (2 * s + odd) * kStripeRows;
                       body(first, std::min(rows, first + kStripeRows));
                     }
                   },
                   progress.Part(0.5 * phase, 0.5 * phase + 0.5));
  }
}

StencilMatrix::StencilMatrix(const PixelRuns& of, const Progress& progress)
    : pixels(&of) {
  // Piece by piece, for the system takes its time to hand out memory
  constexpr std::size_t kPiece = 1 << 20;
  const auto slots = static_cast<std::size_t>(of.slots);
  for (auto& e : entry) {
    e.reserve(slots);
    while (e.size() < slots) {
      progress.Report(0);
      e.resize(std::min(slots, e.size() + kPiece), 0.0f);
    }
  }
}

template <class Real>
void Multiply(const StencilMatrix& a,
              std::span<const Real> x,
              std::span<Real> product,
              const Progress& progress) {
  ParallelRanges(
      a.pixels->rows(),
      kStripeRows,
      [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
          for (const PixelRun& run : a.pixels->OfRow(y)) {
            Real* out = product.data() + run.below[0];
            const float* diagonal = a.entry[0].data() + run.below[0];
            const Real* centre = x.data() + run.below[0];
            for (int i = 0; i < run.length; ++i) out[i] = diagonal[i] * centre[i];
            for (int k = 1; k < kStencil; ++k) {
              const auto [dx, dy] = kStencilOffset[k];
              const float* later = a.entry[k].data() + run.below[0];
              const Real* x_later = x.data() + run.below[dy] + dx;
              const float* earlier = a.entry[k].data() + run.above[dy] - dx;
              const Real* x_earlier = x.data() + run.above[dy] - dx;
              for (int i = 0; i < run.length; ++i) {
                out[i] += later[i] * x_later[i] + earlier[i] * x_earlier[i];
              }
            }
          }
        }
      },
      progress);
}

template void Multiply(const StencilMatrix&,
                       std::span<const float>,
                       std::span<float>,
                       const Progress&);
template void Multiply(const StencilMatrix&,
                       std::span<const double>,
                       std::span<double>,
                       const Progress&);

namespace {

// x of one run from all its neighbours; those of its own row that the pass has met, one
// by one, after all others.
void RelaxRun(const StencilMatrix& a,
              const PixelRun& run,
              std::span<const float> b,
              std::span<float> x,
              bool backwards,
              std::vector<float>& scratch) {
  const int n = run.length;
  if (static_cast<int>(scratch.size()) < 2 * n) scratch.resize(2 * n);
  float* rest = scratch.data();
  float* inverse = rest + n;
  std::copy_n(b.data() + run.below[0], n, rest);
  const float* diagonal = a.entry[0].data() + run.below[0];
  for (int i = 0; i < n; ++i) inverse[i] = 1 / diagonal[i];
  for (int k = 1; k < kStencil; ++k) {
    const auto [dx, dy] = kStencilOffset[k];
    const float* later = a.entry[k].data() + run.below[0];
    const float* x_later = x.data() + run.below[dy] + dx;
    const float* earlier = a.entry[k].data() + run.above[dy] - dx;
    const float* x_earlier = x.data() + run.above[dy] - dx;
    if (dy > 0) {
      for (int i = 0; i < n; ++i) {
        rest[i] -= later[i] * x_later[i] + earlier[i] * x_earlier[i];
      }
    } else if (backwards) {
      for (int i = 0; i < n; ++i) rest[i] -= earlier[i] * x_earlier[i];
    } else {
      for (int i = 0; i < n; ++i) rest[i] -= later[i] * x_later[i];
    }
  }
  const float* one = a.entry[1].data() + run.below[0];
  const float* two = a.entry[2].data() + run.below[0];
  float* here = x.data() + run.below[0];
  float near = 0, far = 0;  // Nothing is coupled beyond the run's end
  if (backwards) {
    for (int i = n - 1; i >= 0; --i) {
      const float next = (rest[i] - two[i] * far - one[i] * near) * inverse[i];
      far = near;
      here[i] = near = next;
    }
  } else {
    for (int i = 0; i < n; ++i) {
      const float next = (rest[i] - two[i - 2] * far - one[i - 1] * near) * inverse[i];
      far = near;
      here[i] = near = next;
    }
  }
}

}  // namespace

void Relax(const StencilMatrix& a,
           std::span<const float> b,
           std::span<float> x,
           bool backwards,
           const Progress& progress) {
  ForStripes(
      a.pixels->rows(),
      backwards,
      [&](int begin, int end) {
        std::vector<float> scratch;
        for (int step = 0; step < end - begin; ++step) {
          const auto row = a.pixels->OfRow(backwards ? end - 1 - step : begin + step);
          for (std::size_t n = 0; n < row.size(); ++n) {
            RelaxRun(
                a, row[backwards ? row.size() - 1 - n : n], b, x, backwards, scratch);
          }
        }
      },
      progress);
}

}  // namespace relight
