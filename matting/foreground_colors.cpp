// SPDX-License-Identifier: Apache-2.0
#include "matting/foreground_colors.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace relight {
namespace {

// Both colours of pixel (x, y) from its own mixture and its neighbours. (M3)
void SolvePixel(const cv::Mat3f& image,
                const cv::Mat1f& alpha,
                const ForegroundOptions& options,
                int x,
                int y,
                ForegroundColors& colors) {
  constexpr std::array<std::array<int, 2>, 4> kNeighbours = {
      {{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  const double a = alpha(y, x);
  double pull = 0.0;
  cv::Vec3d toward_f(0, 0, 0), toward_b(0, 0, 0);
  for (const auto& [dx, dy] : kNeighbours) {
    const int nx = std::clamp(x + dx, 0, image.cols - 1);
    const int ny = std::clamp(y + dy, 0, image.rows - 1);
    const double weight =
        options.smoothness + options.gradient_weight * std::abs(a - alpha(ny, nx));
    pull += weight;
    toward_f += weight * cv::Vec3d(colors.foreground(ny, nx));
    toward_b += weight * cv::Vec3d(colors.background(ny, nx));
  }
  // [a^2 + p, a(1-a); a(1-a), (1-a)^2 + p] [F; B] = [a I + pF; (1-a) I + pB]
  const double ff = a * a + pull, fb = a * (1 - a), bb = (1 - a) * (1 - a) + pull;
  const double inverse = 1.0 / (ff * bb - fb * fb);
  const cv::Vec3d pixel = cv::Vec3d(image(y, x));
  const cv::Vec3d right_f = a * pixel + toward_f, right_b = (1 - a) * pixel + toward_b;
  for (int c = 0; c < 3; ++c) {
    colors.foreground(y, x)[c] =
        static_cast<float>(std::max(0.0, inverse * (bb * right_f[c] - fb * right_b[c])));
    colors.background(y, x)[c] =
        static_cast<float>(std::max(0.0, inverse * (ff * right_b[c] - fb * right_f[c])));
  }
}

// One pass: all pixels of one colour of the chessboard, then the others, so that threads
// change nothing.
void Relax(const cv::Mat3f& image,
           const cv::Mat1f& alpha,
           const ForegroundOptions& options,
           ForegroundColors& colors) {
  for (const int parity : {0, 1}) {
    ParallelRanges(image.rows, 32, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        for (int x = (y + parity) % 2; x < image.cols; x += 2) {
          SolvePixel(image, alpha, options, x, y, colors);
        }
      }
    });
  }
}

}  // namespace

ForegroundColors EstimateForeground(const cv::Mat3f& linear,
                                    const cv::Mat1f& alpha,
                                    const ForegroundOptions& options,
                                    const Progress& progress) {
  CheckFields(options);
  if (linear.size() != alpha.size() || linear.empty()) {
    throw InputError("the matte is " + std::to_string(alpha.cols) + " x " +
                     std::to_string(alpha.rows) + " pixels, the photo " +
                     std::to_string(linear.cols) + " x " + std::to_string(linear.rows) +
                     "; make the matte at the photo's size");
  }

  // Start from the mean colours under the matte and outside it
  cv::Vec3d sum_f(0, 0, 0), sum_b(0, 0, 0);
  double weight_f = 1e-9, weight_b = 1e-9;
  for (int y = 0; y < linear.rows; ++y) {
    for (int x = 0; x < linear.cols; ++x) {
      const double a = alpha(y, x);
      sum_f += a * a * cv::Vec3d(linear(y, x));
      sum_b += (1 - a) * (1 - a) * cv::Vec3d(linear(y, x));
      weight_f += a * a;
      weight_b += (1 - a) * (1 - a);
    }
  }
  ForegroundColors colors{cv::Mat3f(1, 1, cv::Vec3f(sum_f / weight_f)),
                          cv::Mat3f(1, 1, cv::Vec3f(sum_b / weight_b))};

  // Double the size from level to level
  const int levels =
      static_cast<int>(std::ceil(std::log2(std::max({linear.rows, linear.cols, 2}))));
  for (int level = 0; level <= levels; ++level) {
    const double share = static_cast<double>(level) / levels;
    const cv::Size size(
        std::max(1, static_cast<int>(std::lround(std::pow(linear.cols, share)))),
        std::max(1, static_cast<int>(std::lround(std::pow(linear.rows, share)))));
    cv::Mat3f image = linear;
    cv::Mat1f matte = alpha;
    if (level < levels) {
      cv::resize(linear, image, size, 0, 0, cv::INTER_AREA);
      cv::resize(alpha, matte, size, 0, 0, cv::INTER_AREA);
    }
    cv::resize(colors.foreground, colors.foreground, size, 0, 0, cv::INTER_NEAREST);
    cv::resize(colors.background, colors.background, size, 0, 0, cv::INTER_NEAREST);
    const bool small = size.width <= 32 && size.height <= 32;
    const int passes = small ? options.small_iterations : options.large_iterations;
    for (int pass = 0; pass < passes; ++pass) Relax(image, matte, options, colors);
    progress.Report((level + 1.0) / (levels + 1.0));
  }

  // Where the matte is sure, the photo is
  for (int y = 0; y < linear.rows; ++y) {
    for (int x = 0; x < linear.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        if (alpha(y, x) >= 1)
          colors.foreground(y, x)[c] = std::max(0.0f, linear(y, x)[c]);
        if (alpha(y, x) <= 0)
          colors.background(y, x)[c] = std::max(0.0f, linear(y, x)[c]);
      }
    }
  }
  return colors;
}

}  // namespace relight
