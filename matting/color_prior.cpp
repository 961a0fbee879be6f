// SPDX-License-Identifier: Apache-2.0
#include "matting/color_prior.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace relight {
namespace {

constexpr std::array<std::array<int, 2>, 8> kDirections = {
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

// For each block, the nearest known one against `direction`, as y * cols + x; -1 where
// there is none. One sweep: each asks the one before it.
cv::Mat1i NearestAlong(const cv::Mat1b& known, std::array<int, 2> direction) {
  const auto [dx, dy] = direction;
  cv::Mat1i nearest(known.size(), -1);
  const bool down = dy > 0 || (dy == 0 && dx > 0);
  for (int row = 0; row < known.rows; ++row) {
    const int y = down ? row : known.rows - 1 - row;
    for (int column = 0; column < known.cols; ++column) {
      const int x = dx > 0 ? column : known.cols - 1 - column;
      if (known(y, x)) {
        nearest(y, x) = y * known.cols + x;
        continue;
      }
      const int before_x = x - dx, before_y = y - dy;
      if (before_x < 0 || before_y < 0 || before_x >= known.cols ||
          before_y >= known.rows) {
        continue;
      }
      nearest(y, x) = nearest(before_y, before_x);
    }
  }
  return nearest;
}

// Means of the fullest cells of a 12 x 12 x 12 histogram of the known blocks.
std::vector<cv::Vec3f> CommonColors(const cv::Mat3f& blocks, const cv::Mat1b& known) {
  constexpr int kSide = 12;  // Cells of equal size in sqrt(linear), near to what is seen
  constexpr int kMost = 24;
  struct HistogramCell {
    cv::Vec3d sum{0, 0, 0};
    std::int64_t count = 0;
  };
  std::vector<HistogramCell> cells(kSide * kSide * kSide);
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) {
      if (!known(y, x)) continue;
      int index = 0;
      for (int c = 0; c < 3; ++c) {
        const float root = std::sqrt(std::max(blocks(y, x)[c], 0.0f));
        index = index * kSide + std::clamp(static_cast<int>(root * kSide), 0, kSide - 1);
      }
      cells[static_cast<std::size_t>(index)].sum += cv::Vec3d(blocks(y, x));
      ++cells[static_cast<std::size_t>(index)].count;
    }
  }
  std::stable_sort(
      cells.begin(), cells.end(), [](const HistogramCell& a, const HistogramCell& b) {
        return a.count > b.count;
      });
  std::vector<cv::Vec3f> colors;
  for (int n = 0; n < kMost && cells[static_cast<std::size_t>(n)].count > 0; ++n) {
    const HistogramCell& cell = cells[static_cast<std::size_t>(n)];
    colors.push_back(cv::Vec3f(cell.sum / static_cast<double>(cell.count)));
  }
  return colors;
}

struct Guess {
  float alpha = 0, confidence = 0;
};

// How much a step of linear light shows on a display, per channel: the slope of the sRGB
// curve, held below its toe.
cv::Vec3f DisplaySlope(const cv::Vec3f& linear) {
  cv::Vec3f slope;
  for (int c = 0; c < 3; ++c) {
    slope[c] = 0.44f * std::pow(std::max(linear[c], 0.003f), -0.5833f);
  }
  return slope;
}

// How many times brighter than its sample the foreground is: t of the mixture p F + q B
// that is nearest to the pixel, with t = p / (1 - q), within [1, brightest]. (M11)
float Brightness(const cv::Vec3f& pixel,
                 const cv::Vec3f& f,
                 const cv::Vec3f& b,
                 double brightest) {
  const double ff = f.dot(f), fb = f.dot(b), bb = b.dot(b);
  const double pf = pixel.dot(f), pb = pixel.dot(b), determinant = ff * bb - fb * fb;
  if (determinant < 1e-6 * ff * bb) return 1;  // One hue: brightness is alpha
  const double q = (pb * ff - pf * fb) / determinant;
  const double p = q < 0 ? pf / ff : (pf * bb - pb * fb) / determinant;
  constexpr double kLeast = 0.02;  // Of alpha: below it nothing is seen of F
  return static_cast<float>(
      std::clamp(p / std::clamp(1 - q, kLeast, 1.0), 1.0, brightest));
}

// Colours that lie this far apart on a display tell alpha as surely as any.
constexpr double kApart = 0.6;

Guess GuessOf(const cv::Vec3f& pixel,
              const std::vector<cv::Vec3f>& foreground,
              const std::vector<cv::Vec3f>& background,
              const ColorPriorOptions& options) {
  double weight_sum = 0, alpha_sum = 0, square_sum = 0, best_cost = 1e30,
         best_residual = 1, best_apart = 0;
  const double inverse_variance = 1 / (options.sigma * options.sigma);
  const cv::Vec3f slope = DisplaySlope(pixel);
  for (const cv::Vec3f& b : background) {
    const cv::Vec3f from_b = (pixel - b).mul(slope);
    for (const cv::Vec3f& f : foreground) {
      const float t =
          options.brightest > 1
              ? Brightness(
                    pixel.mul(slope), f.mul(slope), b.mul(slope), options.brightest)
              : 1;
      const cv::Vec3f line = (t * f - b).mul(slope);
      const double apart2 = line.dot(line);
      if (apart2 < 1e-4) continue;
      const double a = std::clamp(from_b.dot(line) / apart2, 0.0, 1.0);
      const cv::Vec3f error = from_b - static_cast<float>(a) * line;
      const double residual2 = error.dot(error);
      const double cost = residual2 * inverse_variance + 4 * options.purity * a * (1 - a);
      const double weight = std::exp(-0.5 * std::min(cost, 100.0));
      weight_sum += weight;
      alpha_sum += weight * a;
      square_sum += weight * a * a;
      if (cost < best_cost) {
        best_cost = cost;
        best_residual = std::sqrt(residual2);
        best_apart = std::sqrt(apart2);
      }
    }
  }
  if (weight_sum <= 0) return {};
  const double fit = std::exp(-0.5 * std::pow(best_residual / (2 * options.sigma), 2));
  const double mean = alpha_sum / weight_sum;
  const double variance = std::max(0.0, square_sum / weight_sum - mean * mean);
  const double agreement =
      std::exp(-0.5 * variance / (options.agreement * options.agreement));
  return {static_cast<float>(mean),
          static_cast<float>(fit * agreement * std::min(1.0, best_apart / kApart))};
}

// What the trimap knows with one label, in blocks of pixels: the mean colour of each
// block, and for every block the nearest such ones against eight directions.
struct KnownBlocks {
  cv::Mat3f color;
  std::array<cv::Mat1i, kDirections.size()> nearest;  // As NearestAlong says; -1: none.
  std::vector<cv::Vec3f> common;  // For blocks that see none in any direction.

  KnownBlocks(const cv::Mat3f& image,
              const cv::Mat1b& trimap,
              std::uint8_t label,
              const Progress& progress)
      : color((image.rows + kBlock - 1) / kBlock, (image.cols + kBlock - 1) / kBlock) {
    cv::Mat1b known(color.size(), std::uint8_t{0});
    ParallelRanges(
        color.rows,
        16,
        [&](int begin, int end) {
          for (int y = begin; y < end; ++y) {
            for (int x = 0; x < color.cols; ++x)
              FindMean(image, trimap, label, x, y, known);
          }
        },
        progress);
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
      progress.Report(1);
      nearest[d] = NearestAlong(known, kDirections[d]);
    }
    common = CommonColors(color, known);
  }

  // The colours nearest to pixel (x, y).
  void ColorsAround(int x, int y, std::vector<cv::Vec3f>& colors) const {
    colors.clear();
    for (const cv::Mat1i& along : nearest) {
      const int block = along(y / kBlock, x / kBlock);
      if (block >= 0) colors.push_back(color(block / color.cols, block % color.cols));
    }
    if (colors.empty()) colors = common;
  }

 private:
  static constexpr int kBlock = 4;  // Pixels; the mean of 16 takes out noise.

  void FindMean(const cv::Mat3f& image,
                const cv::Mat1b& trimap,
                std::uint8_t label,
                int x,
                int y,
                cv::Mat1b& known) {
    cv::Vec3d sum(0, 0, 0);
    int count = 0;
    for (int py = y * kBlock; py < std::min((y + 1) * kBlock, image.rows); ++py) {
      for (int px = x * kBlock; px < std::min((x + 1) * kBlock, image.cols); ++px) {
        if (trimap(py, px) != label) continue;
        sum += cv::Vec3d(image(py, px));
        ++count;
      }
    }
    if (count == 0) return;
    known(y, x) = 1;
    color(y, x) = cv::Vec3f(sum / count);
  }
};

}  // namespace

ColorPrior EstimateColorPrior(const cv::Mat3f& linear,
                              const cv::Mat1b& trimap,
                              const ColorPriorOptions& options,
                              const Progress& progress) {
  Require(linear.size() == trimap.size(), "photo and trimap have one size");
  ColorPrior prior{cv::Mat1f::zeros(linear.size()), cv::Mat1f::zeros(linear.size())};
  const KnownBlocks foreground(linear, trimap, kTrimapForeground, progress.Part(0, 0.15));
  const KnownBlocks background(
      linear, trimap, kTrimapBackground, progress.Part(0.15, 0.3));
  ParallelRanges(
      linear.rows,
      16,
      [&](int begin, int end) {
        std::vector<cv::Vec3f> near_foreground, near_background;
        for (int y = begin; y < end; ++y) {
          for (int x = 0; x < linear.cols; ++x) {
            if (trimap(y, x) != kTrimapUnknown) continue;
            foreground.ColorsAround(x, y, near_foreground);
            background.ColorsAround(x, y, near_background);
            const Guess guess =
                GuessOf(linear(y, x), near_foreground, near_background, options);
            prior.alpha(y, x) = guess.alpha;
            prior.confidence(y, x) = guess.confidence;
          }
        }
      },
      progress.Part(0.3, 1));
  return prior;
}

}  // namespace relight
