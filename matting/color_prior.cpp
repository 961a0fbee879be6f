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

// For each pixel, the nearest pixel labelled `label` against `direction`, as y * cols +
// x; -1 where there is none. One sweep: each pixel asks the one before it.
cv::Mat1i NearestAlong(const cv::Mat1b& trimap,
                       std::uint8_t label,
                       std::array<int, 2> direction) {
  const auto [dx, dy] = direction;
  cv::Mat1i nearest(trimap.size(), -1);
  const bool down = dy > 0 || (dy == 0 && dx > 0);
  for (int row = 0; row < trimap.rows; ++row) {
    const int y = down ? row : trimap.rows - 1 - row;
    for (int column = 0; column < trimap.cols; ++column) {
      const int x = dx > 0 ? column : trimap.cols - 1 - column;
      if (trimap(y, x) == label) {
        nearest(y, x) = y * trimap.cols + x;
        continue;
      }
      const int before_x = x - dx, before_y = y - dy;
      if (before_x < 0 || before_y < 0 || before_x >= trimap.cols ||
          before_y >= trimap.rows) {
        continue;
      }
      nearest(y, x) = nearest(before_y, before_x);
    }
  }
  return nearest;
}

// Means of the fullest cells of a 12 x 12 x 12 histogram of the pixels labelled `label`.
std::vector<cv::Vec3f> CommonColors(const cv::Mat3f& image,
                                    const cv::Mat1b& trimap,
                                    std::uint8_t label,
                                    int count) {
  constexpr int kSide = 12;  // Cells of equal size in sqrt(linear), near to what is seen
  struct Cell {
    cv::Vec3d sum{0, 0, 0};
    std::int64_t pixels = 0;
    int number = 0;
  };
  std::vector<Cell> cells(kSide * kSide * kSide);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].number = static_cast<int>(i);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (trimap(y, x) != label) continue;
      const cv::Vec3f& color = image(y, x);
      int index = 0;
      for (int c = 0; c < 3; ++c) {
        index = index * kSide +
                std::clamp(static_cast<int>(std::sqrt(std::max(color[c], 0.0f)) * kSide),
                           0,
                           kSide - 1);
      }
      cells[static_cast<std::size_t>(index)].sum += cv::Vec3d(color);
      ++cells[static_cast<std::size_t>(index)].pixels;
    }
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.pixels != b.pixels ? a.pixels > b.pixels : a.number < b.number;
  });
  std::vector<cv::Vec3f> colors;
  for (const Cell& cell : cells) {
    if (cell.pixels == 0 || static_cast<int>(colors.size()) == count) break;
    colors.push_back(cv::Vec3f(cell.sum / static_cast<double>(cell.pixels)));
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
      const cv::Vec3f line = (f - b).mul(slope);
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
          static_cast<float>(fit * agreement * std::min(1.0, best_apart / 0.2))};
}

}  // namespace

ColorPrior EstimateColorPrior(const cv::Mat3f& linear,
                              const cv::Mat1b& trimap,
                              const ColorPriorOptions& options) {
  Require(linear.size() == trimap.size(), "photo and trimap have one size");
  ColorPrior prior{cv::Mat1f::zeros(linear.size()), cv::Mat1f::zeros(linear.size())};
  std::array<cv::Mat1i, kDirections.size()> near_foreground, near_background;
  for (std::size_t d = 0; d < kDirections.size(); ++d) {
    near_foreground[d] = NearestAlong(trimap, kTrimapForeground, kDirections[d]);
    near_background[d] = NearestAlong(trimap, kTrimapBackground, kDirections[d]);
  }
  const auto common_foreground =
      CommonColors(linear, trimap, kTrimapForeground, options.common_colors);
  const auto common_background =
      CommonColors(linear, trimap, kTrimapBackground, options.common_colors);
  ParallelRanges(linear.rows, 16, [&](int begin, int end) {
    std::vector<cv::Vec3f> foreground, background;
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < linear.cols; ++x) {
        if (trimap(y, x) != kTrimapUnknown) continue;
        foreground = common_foreground;
        background.clear();
        for (std::size_t d = 0; d < kDirections.size(); ++d) {
          const int f = near_foreground[d](y, x), b = near_background[d](y, x);
          if (f >= 0) foreground.push_back(linear(f / linear.cols, f % linear.cols));
          if (b >= 0) background.push_back(linear(b / linear.cols, b % linear.cols));
        }
        if (background.empty()) background = common_background;
        const Guess guess = GuessOf(linear(y, x), foreground, background, options);
        prior.alpha(y, x) = guess.alpha;
        prior.confidence(y, x) = guess.confidence;
      }
    }
  });
  return prior;
}

}  // namespace relight
