// SPDX-License-Identifier: Apache-2.0
#include "matting/laplacian_solver.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace relight {
namespace {

constexpr int kMargin = 2;      // Reach of the stencil.
constexpr int kGrainRuns = 64;  // Runs a task: only speed depends on it.
constexpr int kGrainSlots =
    1 << 15;  // Slots a partial sum: the order of sums depends on it.

// (x, y) is (0, 0) at the first pixel of the margin.
struct StoredRun {
  int x = 0, end = 0;
  std::int32_t slot = 0;
};

}  // namespace

PixelRuns::PixelRuns(const cv::Mat1b& inside) {
  const int rows = inside.rows, cols = inside.cols;
  const int wide = cols + 2 * kMargin;

  // Slots: the pixels of the system and all within the reach of the stencil
  std::vector<std::vector<StoredRun>> stored(
      static_cast<std::size_t>(rows + 2 * kMargin));
  std::vector<int> reach(wide + 1);
  std::int64_t next = 0;
  for (int y = 0; y < rows + 2 * kMargin; ++y) {
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

StencilMatrix::StencilMatrix(const PixelRuns& of) : pixels(&of) {
  for (auto& e : entry) e.assign(static_cast<std::size_t>(of.slots), 0.0);
}

void Multiply(const StencilMatrix& a,
              std::span<const double> x,
              std::span<double> product) {
  const auto& runs = a.pixels->runs;
  ParallelRanges(static_cast<int>(runs.size()), kGrainRuns, [&](int begin, int end) {
    for (int r = begin; r < end; ++r) {
      const PixelRun& run = runs[r];
      double* out = product.data() + run.below[0];
      const double* diagonal = a.entry[0].data() + run.below[0];
      const double* centre = x.data() + run.below[0];
      for (int i = 0; i < run.length; ++i) out[i] = diagonal[i] * centre[i];
      for (int k = 1; k < kStencil; ++k) {
        const auto [dx, dy] = kStencilOffset[k];
        const double* later = a.entry[k].data() + run.below[0];
        const double* x_later = x.data() + run.below[dy] + dx;
        const double* earlier = a.entry[k].data() + run.above[dy] - dx;
        const double* x_earlier = x.data() + run.above[dy] - dx;
        for (int i = 0; i < run.length; ++i) {
          out[i] += later[i] * x_later[i] + earlier[i] * x_earlier[i];
        }
      }
    }
  });
}

namespace {

// Where the product of neighbours k and m of an eliminated pixel falls: on the entry n of
// the pixel at k, the one towards m. Products that fall outside the stencil are dropped.
struct Fill {
  int k, m, n;
};

std::vector<Fill> MakeFills() {
  std::vector<Fill> fills;
  for (int k = 1; k < kStencil; ++k) {
    for (int m = k; m < kStencil; ++m) {
      for (int n = 0; n < kStencil; ++n) {
        if (kStencilOffset[n][0] == kStencilOffset[m][0] - kStencilOffset[k][0] &&
            kStencilOffset[n][1] == kStencilOffset[m][1] - kStencilOffset[k][1]) {
          fills.push_back({k, m, n});
        }
      }
    }
  }
  return fills;
}

// A ~ L D L^T with L unit lower triangular and of A's own pattern: IC(0).
class IncompleteCholesky {
 public:
  explicit IncompleteCholesky(const StencilMatrix& a) : pixels_(*a.pixels) {
    // A is no M-matrix, so that a pivot may fail: then again with a heavier diagonal
    for (double shift = 0.0; !Factorise(a, shift);
         shift = shift == 0 ? 1e-3 : 4 * shift) {
      Require(shift < 1e3, "a heavy diagonal can be factorised");
    }
  }

  // z = (L D L^T)^-1 r
  void Apply(std::span<const double> r, std::span<double> z) const {
    for (const PixelRun& run : pixels_.runs) {
      double* out = z.data() + run.below[0];
      std::copy_n(r.data() + run.below[0], run.length, out);
      for (int k = 3; k < kStencil; ++k) {
        const auto [dx, dy] = kStencilOffset[k];
        const float* l = factor_[k].data() + run.above[dy] - dx;
        const double* earlier = z.data() + run.above[dy] - dx;
        for (int i = 0; i < run.length; ++i) out[i] -= l[i] * earlier[i];
      }
      const float* l1 = factor_[1].data() + run.below[0];
      const float* l2 = factor_[2].data() + run.below[0];
      for (int i = 1; i < run.length; ++i) {
        out[i] -= l1[i - 1] * out[i - 1];
        if (i > 1) out[i] -= l2[i - 2] * out[i - 2];
      }
    }
    for (auto reverse = pixels_.runs.rbegin(); reverse != pixels_.runs.rend();
         ++reverse) {
      const PixelRun& run = *reverse;
      double* out = z.data() + run.below[0];
      const float* inverse = factor_[0].data() + run.below[0];
      for (int i = 0; i < run.length; ++i) out[i] *= inverse[i];
      for (int k = 3; k < kStencil; ++k) {
        const auto [dx, dy] = kStencilOffset[k];
        const float* l = factor_[k].data() + run.below[0];
        const double* later = z.data() + run.below[dy] + dx;
        for (int i = 0; i < run.length; ++i) out[i] -= l[i] * later[i];
      }
      const float* l1 = factor_[1].data() + run.below[0];
      const float* l2 = factor_[2].data() + run.below[0];
      for (int i = run.length - 2; i >= 0; --i) {
        out[i] -= l1[i] * out[i + 1];
        if (i + 2 < run.length) out[i] -= l2[i] * out[i + 2];
      }
    }
  }

 private:
  bool Factorise(const StencilMatrix& a, double shift) {
    static const std::vector<Fill> fills = MakeFills();
    std::array<std::vector<double>, kStencil> l = a.entry;
    for (double& diagonal : l[0]) diagonal *= 1 + shift;
    for (const PixelRun& run : pixels_.runs) {
      for (int i = 0; i < run.length; ++i) {
        const auto slot = static_cast<std::size_t>(run.below[0] + i);
        const double pivot = l[0][slot];
        if (!(pivot > 1e-4 * a.entry[0][slot])) return false;
        std::array<double, kStencil> value{};
        std::array<std::size_t, kStencil> at{};
        for (int k = 1; k < kStencil; ++k) {
          value[k] = l[k][slot];
          at[k] = static_cast<std::size_t>(run.below[kStencilOffset[k][1]] + i +
                                           kStencilOffset[k][0]);
        }
        for (const Fill& fill : fills) {
          l[fill.n][at[fill.k]] -= value[fill.k] * value[fill.m] / pivot;
        }
        for (int k = 1; k < kStencil; ++k) l[k][slot] = value[k] / pivot;
        l[0][slot] = 1 / pivot;
      }
    }
    for (int k = 0; k < kStencil; ++k) factor_[k].assign(l[k].begin(), l[k].end());
    return true;
  }

  const PixelRuns& pixels_;
  std::array<std::vector<float>, kStencil>
      factor_;  // [0]: 1 / D. It only has to be near.
};

// Summed piece by piece in a fixed order.
double Dot(std::span<const double> a, std::span<const double> b) {
  const int pieces = static_cast<int>(a.size() / kGrainSlots) + 1;
  std::vector<double> part(static_cast<std::size_t>(pieces));
  ParallelRanges(static_cast<int>(a.size()), kGrainSlots, [&](int begin, int end) {
    double sum = 0;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
         ++i) {
      sum += a[i] * b[i];
    }
    part[static_cast<std::size_t>(begin / kGrainSlots)] = sum;
  });
  return std::accumulate(part.begin(), part.end(), 0.0);
}

}  // namespace

SolveSummary SolveByConjugateGradients(const StencilMatrix& a,
                                       std::span<const double> b,
                                       std::span<double> x,
                                       const SolveOptions& options,
                                       const Progress& progress) {
  SolveSummary summary;
  const double size_b = std::sqrt(Dot(b, b));
  if (size_b == 0) {
    std::fill(x.begin(), x.end(), 0.0);
    return summary;
  }
  const IncompleteCholesky preconditioner(a);
  std::vector<double> r(b.size()), z(b.size()), p(b.size()), ap(b.size());
  Multiply(a, x, ap);
  for (std::size_t i = 0; i < b.size(); ++i) r[i] = b[i] - ap[i];
  preconditioner.Apply(r, z);
  p = z;
  double rz = Dot(r, z);
  const double first = std::max(std::sqrt(Dot(r, r)) / size_b, options.relative_residual);
  for (;;) {
    summary.relative_residual = std::sqrt(Dot(r, r)) / size_b;
    if (summary.relative_residual <= options.relative_residual ||
        summary.iterations == options.most_iterations) {
      return summary;
    }
    const double span = std::log(options.relative_residual / first);
    progress.Report(
        span < 0
            ? std::clamp(std::log(summary.relative_residual / first) / span, 0.0, 1.0)
            : 1.0);
    Multiply(a, p, ap);
    const double step = rz / Dot(p, ap);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] += step * p[i];
      r[i] -= step * ap[i];
    }
    preconditioner.Apply(r, z);
    const double next_rz = Dot(r, z);
    const double turn = next_rz / rz;
    rz = next_rz;
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = z[i] + turn * p[i];
    ++summary.iterations;
  }
}

}  // namespace relight
