// SPDX-License-Identifier: Apache-2.0
#include "matting/laplacian_solver.h"

#include "matting/color_multigrid.h"
#include "relight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace relight {
namespace {

constexpr int kPiece = 1 << 15;  // Slots a partial sum: the order of sums depends on it.

// Sums of body(slot), piece by piece in a fixed order.
template <class Body>
double Sum(std::size_t slots, const Body& body) {
  std::vector<double> part(slots / kPiece + 1);
  ParallelRanges(static_cast<int>(slots), kPiece, [&](int begin, int end) {
    double sum = 0;
    for (int i = begin; i < end; ++i) sum += body(static_cast<std::size_t>(i));
    part[static_cast<std::size_t>(begin / kPiece)] = sum;
  });
  return std::accumulate(part.begin(), part.end(), 0.0);
}

double Dot(std::span<const float> a, std::span<const float> b) {
  return Sum(a.size(), [&](std::size_t i) { return static_cast<double>(a[i]) * b[i]; });
}

}  // namespace

SolveSummary SolveLaplacian(const StencilMatrix& a,
                            const cv::Mat3f& image,
                            std::span<const float> b,
                            std::span<float> x,
                            const SolveOptions& options,
                            const Progress& progress) {
  SolveSummary summary;
  std::fill(x.begin(), x.end(), 0.0f);
  const double size_b = std::sqrt(Dot(b, b));
  if (size_b == 0) return summary;
  ColorMultigrid multigrid(a, image, progress.Part(0, 0.1));
  std::vector<float> r(b.begin(), b.end()), z(b.size()), p(b.size()), ap(b.size());
  double rz = 0, step = 0;
  for (;;) {
    // How far: residuals fall by a factor an iteration
    summary.relative_residual = std::sqrt(Dot(r, r)) / size_b;
    const double done = std::clamp(std::log(std::max(summary.relative_residual, 1e-30)) /
                                       std::log(std::min(options.relative_residual, 0.5)),
                                   0.0,
                                   1.0);
    const Progress here = progress.Part(0.1 + 0.9 * done, 0.1 + 0.9 * done);
    here.Report(1);
    if (summary.relative_residual <= options.relative_residual ||
        summary.iterations == options.most_iterations) {
      return summary;
    }
    multigrid.Apply(r, z, here);
    // The cycle is not quite linear: conjugate to the direction before by its own
    // residual
    const double before = rz;
    rz = Dot(r, z);
    const double turn = before == 0 ? 0 : -step * Dot(z, ap) / before;
    for (std::size_t i = 0; i < p.size(); ++i) {
      p[i] = z[i] + static_cast<float>(turn) * p[i];
    }
    Multiply<float>(a, p, ap, here);
    step = Dot(r, p) / Dot(p, ap);
    for (std::size_t i = 0; i < p.size(); ++i) {
      x[i] += static_cast<float>(step) * p[i];
      r[i] -= static_cast<float>(step) * ap[i];
    }
    ++summary.iterations;
    if (options.enough && options.enough(x)) return summary;
  }
}

}  // namespace relight
