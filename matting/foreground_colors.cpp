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

// Three rows of an image around one, the outermost repeated at the border.
template <class T>
struct RowsAround {
  RowsAround(const cv::Mat_<T>& image, int y)
      : above(image[std::max(y - 1, 0)]),
        here(image[y]),
        below(image[std::min(y + 1, image.rows - 1)]) {}
  const T *above, *here, *below;
};

// Both colours of every second pixel of a row, from its own mixture and its neighbours.
// (M3)
void RelaxRow(const cv::Mat3f& image,
              const cv::Mat1f& alpha,
              const ForegroundOptions& options,
              int y,
              int first,
              ForegroundColors& colors) {
  const auto smoothness = static_cast<float>(options.smoothness);
  const auto gradient = static_cast<float>(options.gradient_weight);
  const RowsAround<float> a(alpha, y);
  const RowsAround<cv::Vec3f> f(colors.foreground, y), b(colors.background, y);
  cv::Vec3f* out_f = colors.foreground[y];
  cv::Vec3f* out_b = colors.background[y];
  for (int x = first; x < image.cols; x += 2) {
    const int left = std::max(x - 1, 0), right = std::min(x + 1, image.cols - 1);
    const float own = a.here[x], rest = 1 - own;
    const float wl = smoothness + gradient * std::abs(own - a.here[left]);
    const float wr = smoothness + gradient * std::abs(own - a.here[right]);
    const float wa = smoothness + gradient * std::abs(own - a.above[x]);
    const float wb = smoothness + gradient * std::abs(own - a.below[x]);
    const float pull = wl + wr + wa + wb;
    // [a^2 + p, a(1-a); a(1-a), (1-a)^2 + p] [F; B] = [a I + pF; (1-a) I + pB]; the
    // determinant written out, for a difference of products would lose the small p
    const float ff = own * own + pull, fb = own * rest, bb = rest * rest + pull;
    const float inverse = 1 / (pull * (own * own + rest * rest + pull));
    for (int c = 0; c < 3; ++c) {
      const float pixel = image(y, x)[c];
      const float to_f = own * pixel + wl * f.here[left][c] + wr * f.here[right][c] +
                         wa * f.above[x][c] + wb * f.below[x][c];
      const float to_b = rest * pixel + wl * b.here[left][c] + wr * b.here[right][c] +
                         wa * b.above[x][c] + wb * b.below[x][c];
      out_f[x][c] = std::max(0.0f, inverse * (bb * to_f - fb * to_b));
      out_b[x][c] = std::max(0.0f, inverse * (ff * to_b - fb * to_f));
    }
  }
}

// One pass: all pixels of one colour of the chessboard, then the others, so that threads
// change nothing.
void Relax(const cv::Mat3f& image,
           const cv::Mat1f& alpha,
           const ForegroundOptions& options,
           ForegroundColors& colors,
           const Progress& progress) {
  for (const int parity : {0, 1}) {
    ParallelRanges(
        image.rows,
        32,
        [&](int begin, int end) {
          for (int y = begin; y < end; ++y) {
            RelaxRow(image, alpha, options, y, (y + parity) % 2, colors);
          }
        },
        progress);
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
    const double done =
        std::pow(0.25, levels - level);  // Each level has 4 times the work
    for (int pass = 0; pass < passes; ++pass) {
      Relax(image, matte, options, colors, progress.Part(done, done));
    }
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
