// SPDX-License-Identifier: Apache-2.0
#include "matting/closed_form_matting.h"

#include "matting/color_prior.h"
#include "matting/laplacian_solver.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace relight {
namespace {

// L_ij of one window for its 9 pixels in reading order. (M2)
Eigen::Matrix<double, 9, 9> WindowLaplacian(const cv::Mat3f& image,
                                            int x,
                                            int y,
                                            double epsilon) {
  Eigen::Matrix<double, 9, 3> c;
  for (int n = 0; n < 9; ++n) {
    const cv::Vec3f& color = image(y + n / 3 - 1, x + n % 3 - 1);
    c.row(n) << color[0], color[1], color[2];
  }
  const Eigen::RowVector3d mean = c.colwise().mean();
  c.rowwise() -= mean;
  const Eigen::Matrix3d covariance =
      c.transpose() * c / 9 + epsilon / 9 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 9, 9> l = -(c * covariance.inverse() * c.transpose()).eval();
  l.array() -= 1;
  l /= 9;
  l.diagonal().array() += 1;
  return l;
}

struct System {
  StencilMatrix matrix;
  std::vector<double> right_side;
};

// The normal equations of (M1): (L + lambda D) alpha = lambda D alpha*.
System Assemble(const cv::Mat3f& image,
                const cv::Mat1b& trimap,
                const cv::Mat1f& fixed,
                const PixelRuns& pixels,
                const ColorPrior& prior,
                const MattingOptions& options) {
  System system{StencilMatrix(pixels),
                std::vector<double>(static_cast<std::size_t>(pixels.slots))};
  cv::Mat1i slot(image.size(), -1);
  for (const PixelRun& run : pixels.runs) {
    for (int i = 0; i < run.length; ++i) slot(run.y, run.x + i) = run.below[0] + i;
  }
  std::array<std::array<int, 5>, 3> entry_of{};  // [dy][dx + 2]
  for (int k = 0; k < kStencil; ++k) {
    entry_of[kStencilOffset[k][1]][kStencilOffset[k][0] + 2] = k;
  }

  // Windows whose pixels are all outside the system add nothing
  for (int y = 1; y + 1 < image.rows; ++y) {
    for (int x = 1; x + 1 < image.cols; ++x) {
      std::array<int, 9> at{};
      bool any = false;
      for (int n = 0; n < 9; ++n) {
        at[n] = slot(y + n / 3 - 1, x + n % 3 - 1);
        any = any || at[n] >= 0;
      }
      if (!any) continue;
      const Eigen::Matrix<double, 9, 9> l = WindowLaplacian(image, x, y, options.epsilon);
      for (int i = 0; i < 9; ++i) {
        if (at[i] < 0) continue;
        system.matrix.entry[0][at[i]] += l(i, i);
        for (int j = 0; j < 9; ++j) {
          if (j == i) continue;
          if (at[j] < 0) {
            system.right_side[at[i]] -= l(i, j) * fixed(y + j / 3 - 1, x + j % 3 - 1);
          } else if (j > i) {
            system.matrix.entry[entry_of[j / 3 - i / 3][j % 3 - i % 3 + 2]][at[i]] +=
                l(i, j);
          }
        }
      }
    }
  }
  for (const PixelRun& run : pixels.runs) {
    for (int i = 0; i < run.length; ++i) {
      const int x = run.x + i, slot_here = run.below[0] + i;
      const bool unknown = trimap(run.y, x) == kTrimapUnknown;
      const double weight =
          unknown ? options.prior * prior.confidence(run.y, x) : options.lambda;
      system.matrix.entry[0][slot_here] += weight;
      system.right_side[slot_here] +=
          weight * (unknown ? prior.alpha(run.y, x) : fixed(run.y, x));
    }
  }
  return system;
}

// Known where all four pixels are, and alike.
cv::Mat1b HalfTrimap(const cv::Mat1b& trimap) {
  cv::Mat1b half(trimap.rows / 2, trimap.cols / 2, kTrimapUnknown);
  for (int y = 0; y < half.rows; ++y) {
    for (int x = 0; x < half.cols; ++x) {
      const std::uint8_t label = trimap(2 * y, 2 * x);
      if (trimap(2 * y, 2 * x + 1) == label && trimap(2 * y + 1, 2 * x) == label &&
          trimap(2 * y + 1, 2 * x + 1) == label) {
        half(y, x) = label;
      }
    }
  }
  return half;
}

MatteEstimate Solve(const cv::Mat3f& image,
                    const cv::Mat1b& trimap,
                    const MattingOptions& options,
                    const Progress& progress) {
  // Start: the solution at half the size; at the coarsest, half-way
  constexpr int kCoarsest = 96;
  cv::Mat1f alpha(image.size(), 0.5f);
  if (std::min(image.rows, image.cols) >= 2 * kCoarsest) {
    const cv::Rect even(0, 0, image.cols / 2 * 2, image.rows / 2 * 2);
    cv::Mat half, up;
    cv::resize(image(even), half, {image.cols / 2, image.rows / 2}, 0, 0, cv::INTER_AREA);
    const MatteEstimate coarse =
        Solve(half, HalfTrimap(trimap), options, progress.Part(0.0, 0.2));
    cv::resize(coarse.alpha, up, image.size(), 0, 0, cv::INTER_LINEAR);
    alpha = up;
  }
  alpha.setTo(0.0f, trimap == kTrimapBackground);
  alpha.setTo(1.0f, trimap == kTrimapForeground);

  // The system: unknown pixels and what is within two pixels of them
  cv::Mat1b inside;
  cv::dilate(trimap == kTrimapUnknown,
             inside,
             cv::Mat::ones(5, 5, CV_8U),
             {-1, -1},
             1,
             cv::BORDER_CONSTANT,
             cv::Scalar(0));
  const PixelRuns pixels(inside);
  MatteEstimate estimate;
  estimate.summary.unknown_pixels = cv::countNonZero(trimap == kTrimapUnknown);
  const ColorPrior prior = EstimateColorPrior(image, trimap);
  const System system = Assemble(image, trimap, alpha, pixels, prior, options);
  std::vector<double> x(static_cast<std::size_t>(pixels.slots));
  for (const PixelRun& run : pixels.runs) {
    for (int i = 0; i < run.length; ++i) {
      x[static_cast<std::size_t>(run.below[0] + i)] = alpha(run.y, run.x + i);
    }
  }
  const SolveSummary solved =
      SolveByConjugateGradients(system.matrix,
                                system.right_side,
                                x,
                                {.relative_residual = options.relative_residual,
                                 .most_iterations = options.most_iterations},
                                progress.Part(0.3, 1.0));
  for (const PixelRun& run : pixels.runs) {
    for (int i = 0; i < run.length; ++i) {
      if (trimap(run.y, run.x + i) != kTrimapUnknown) continue;  // As the user said
      alpha(run.y, run.x + i) = static_cast<float>(
          std::clamp(x[static_cast<std::size_t>(run.below[0] + i)], 0.0, 1.0));
    }
  }
  estimate.summary.iterations = solved.iterations;
  estimate.summary.relative_residual = solved.relative_residual;
  estimate.alpha = alpha;
  return estimate;
}

}  // namespace

MatteEstimate EstimateMatte(const cv::Mat3f& linear,
                            const cv::Mat1b& trimap,
                            const MattingOptions& options,
                            const Progress& progress) {
  CheckFields(options);
  CheckTrimap(trimap);
  if (linear.size() != trimap.size()) {
    throw InputError("the trimap is " + std::to_string(trimap.cols) + " x " +
                     std::to_string(trimap.rows) + " pixels, the photo " +
                     std::to_string(linear.cols) + " x " + std::to_string(linear.rows) +
                     "; make the trimap at the photo's size");
  }
  if (linear.rows < 3 || linear.cols < 3) {
    throw InputError("a photo to matte is at least 3 x 3 pixels");
  }
  return Solve(linear, trimap, options, progress);
}

}  // namespace relight
