// SPDX-License-Identifier: Apache-2.0
#include "matting/closed_form_matting.h"

#include "matting/color_prior.h"
#include "matting/laplacian_solver.h"
#include "matting/matting_laplacian.h"
#include "matting/trimap.h"
#include "relight/base/error.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace relight {
namespace {

// Between two looks at whether to go on: no photo is so wide that these take long.
constexpr int kBandRows = 128;

// The pixels of the system: the unknown ones and what is within two pixels of them.
PixelRuns SystemOf(const cv::Mat1b& trimap, const Progress& progress) {
  const cv::Mat1b unknown = trimap == kTrimapUnknown;
  cv::Mat1b inside(trimap.size());
  for (int y = 0; y < trimap.rows; y += kBandRows) {
    progress.Report(0);
    // What lies beyond the band is read, too
    const cv::Range band(y, std::min(trimap.rows, y + kBandRows));
    cv::Mat1b out = inside.rowRange(band);
    cv::dilate(unknown.rowRange(band),
               out,
               cv::Mat::ones(5, 5, CV_8U),
               {-1, -1},
               1,
               cv::BORDER_CONSTANT,
               cv::Scalar(0));
  }
  return PixelRuns(inside, progress);
}

template <class Body>
void ForPixels(const PixelRuns& pixels, const Body& body, const Progress& progress) {
  int reported = -1;
  for (const PixelRun& run : pixels.runs) {
    if (run.y / kBandRows != reported) {
      reported = run.y / kBandRows;
      progress.Report(1);
    }
    for (int i = 0; i < run.length; ++i) body(run.x + i, run.y, run.below[0] + i);
  }
}

}  // namespace

MattingSystem MakeMattingSystem(const cv::Mat3f& image,
                                const cv::Mat1b& trimap,
                                const ColorPrior& prior,
                                const MattingOptions& options,
                                const Progress& progress) {
  auto pixels = std::make_unique<PixelRuns>(SystemOf(trimap, progress.Part(0, 0.1)));
  StencilMatrix matrix(*pixels, progress.Part(0.1, 0.1));
  AddMattingLaplacian(image, options.epsilon, matrix, progress.Part(0.1, 1));

  // The normal equations of (M1): (L + lambda D) alpha = lambda D alpha*
  std::vector<float> right_side(static_cast<std::size_t>(pixels->slots));
  ForPixels(
      *pixels,
      [&](int x, int y, std::int32_t slot) {
        const std::uint8_t label = trimap(y, x);
        double weight = options.lambda, alpha = label == kTrimapForeground ? 1 : 0;
        if (label == kTrimapUnknown) {
          weight =
              prior.alpha.empty() ? 0.0 : options.prior_weight * prior.confidence(y, x);
          alpha = prior.alpha.empty() ? 0.0 : prior.alpha(y, x);
        }
        matrix.entry[0][slot] += static_cast<float>(weight);
        right_side[slot] = static_cast<float>(weight * alpha);
      },
      progress);
  return {std::move(pixels), std::move(matrix), std::move(right_side)};
}

namespace {

MatteEstimate Solve(const cv::Mat3f& image,
                    const cv::Mat1b& trimap,
                    const MattingOptions& options,
                    const Progress& progress) {
  MatteEstimate estimate;
  estimate.alpha.create(image.size());
  for (int y = 0; y < image.rows; ++y) {
    if (y % kBandRows == 0) progress.Report(0);
    for (int x = 0; x < image.cols; ++x) {
      estimate.alpha(y, x) = trimap(y, x) == kTrimapForeground ? 1.0f : 0.0f;
    }
  }
  estimate.summary.unknown_pixels = cv::countNonZero(trimap == kTrimapUnknown);
  if (estimate.summary.unknown_pixels == 0) return estimate;

  const ColorPrior prior =
      options.prior_weight > 0
          ? EstimateColorPrior(
                image, trimap, {.brightest = options.brightest}, progress.Part(0, 0.3))
          : ColorPrior();
  const MattingSystem system =
      MakeMattingSystem(image, trimap, prior, options, progress.Part(0.3, 0.4));
  std::vector<float> x(system.right_side.size());
  const SolveSummary solved =
      SolveLaplacian(system.matrix,
                     image,
                     system.right_side,
                     x,
                     {.relative_residual = options.relative_residual,
                      .most_iterations = options.most_iterations},
                     progress.Part(0.4, 1.0));
  ForPixels(
      *system.pixels,
      [&](int px, int py, std::int32_t slot) {
        if (trimap(py, px) != kTrimapUnknown) return;  // As the user said
        estimate.alpha(py, px) = std::clamp(x[slot], 0.0f, 1.0f);
      },
      progress);
  estimate.summary.iterations = solved.iterations;
  estimate.summary.relative_residual = solved.relative_residual;
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
  for (int y = 0; y < linear.rows; y += kBandRows) {
    progress.Report(0);
    if (!cv::checkRange(linear.rowRange(y, std::min(linear.rows, y + kBandRows)))) {
      throw InputError("the photo holds pixels that are no numbers (NaN) or infinite");
    }
  }
  if (linear.rows >= 3 && linear.cols >= 3) {
    return Solve(linear, trimap, options, progress);
  }
  // No window of 3 x 3 fits: borders are repeated until one does
  cv::Mat wide_image, wide_trimap;
  const int rows = std::max(0, 3 - linear.rows), cols = std::max(0, 3 - linear.cols);
  cv::copyMakeBorder(linear, wide_image, 0, rows, 0, cols, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(trimap, wide_trimap, 0, rows, 0, cols, cv::BORDER_REPLICATE);
  MatteEstimate estimate = Solve(wide_image, wide_trimap, options, progress);
  estimate.alpha = estimate.alpha({0, 0, linear.cols, linear.rows}).clone();
  estimate.summary.unknown_pixels = CountLabels(trimap).unknown;
  return estimate;
}

}  // namespace relight
