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

// The background as it shows around a place: colour, and how far single pixels are from
// it. Cells of kCell pixels a side, filled in from larger ones where none of it shows.
constexpr int kCell = 8;

struct BackgroundAround {
  cv::Mat3f color;     // Empty when no background shows anywhere.
  cv::Mat1f variance;  // Mean of the channels'.
};

// The two cells that a pixel lies between along one side, and the share of the latter.
struct Between {
  int low, high;
  float share;
};
Between CellsAt(int pixel, int cells) {
  const float at = (static_cast<float>(pixel) + 0.5f) / kCell - 0.5f;
  const int low = std::clamp(static_cast<int>(std::floor(at)), 0, cells - 1);
  return {low,
          std::min(low + 1, cells - 1),
          std::clamp(at - static_cast<float>(low), 0.0f, 1.0f)};
}

template <class Value>
Value At(const cv::Mat_<Value>& cells, const Between& x, const Between& y) {
  const Value above =
      (1 - x.share) * cells(y.low, x.low) + x.share * cells(y.low, x.high);
  const Value below =
      (1 - x.share) * cells(y.high, x.low) + x.share * cells(y.high, x.high);
  return (1 - y.share) * above + y.share * below;
}

// Mean and square of a cell's shown pixels, and the share that shows.
struct Moments {
  cv::Mat3f sum, square;  // Times `weight`.
  cv::Mat1f weight;
};

// What cells lack comes from cells of twice their size: there the mean is over a wider
// part of the background, and so is the variance.
void FillIn(Moments& cells) {
  if (cells.weight.rows == 1 && cells.weight.cols == 1) return;
  const cv::Size size = cells.weight.size(),
                 half((size.width + 1) / 2, (size.height + 1) / 2);
  Moments wide;
  cv::resize(cells.sum, wide.sum, half, 0, 0, cv::INTER_AREA);
  cv::resize(cells.square, wide.square, half, 0, 0, cv::INTER_AREA);
  cv::resize(cells.weight, wide.weight, half, 0, 0, cv::INTER_AREA);
  FillIn(wide);
  cv::resize(wide.sum, wide.sum, size);
  cv::resize(wide.square, wide.square, size);
  cv::resize(wide.weight, wide.weight, size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float lacks = std::max(0.0f, 0.25f - cells.weight(y, x));
      const float part = lacks / std::max(wide.weight(y, x), 1e-6f);
      cells.sum(y, x) += part * wide.sum(y, x);
      cells.square(y, x) += part * wide.square(y, x);
      cells.weight(y, x) += part * wide.weight(y, x);
    }
  }
}

BackgroundAround FindBackground(const cv::Mat3f& linear,
                                const cv::Mat1f& alpha,
                                const Progress& progress) {
  constexpr float kShows = 0.02f;  // Alpha up to which a pixel is background
  const cv::Size size((linear.cols + kCell - 1) / kCell,
                      (linear.rows + kCell - 1) / kCell);
  Moments cells{cv::Mat3f(size), cv::Mat3f(size), cv::Mat1f(size)};
  ParallelRanges(
      size.height,
      4,
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) {
          for (int column = 0; column < size.width; ++column) {
            const cv::Rect cell = cv::Rect(column * kCell, row * kCell, kCell, kCell) &
                                  cv::Rect({0, 0}, linear.size());
            cv::Vec3f sum(0, 0, 0), square(0, 0, 0);
            int count = 0;
            for (int y = cell.y; y < cell.br().y; ++y) {
              for (int x = cell.x; x < cell.br().x; ++x) {
                if (alpha(y, x) > kShows) continue;
                sum += linear(y, x);
                square += linear(y, x).mul(linear(y, x));
                ++count;
              }
            }
            const auto area = static_cast<float>(cell.area());
            cells.sum(row, column) = sum / area;
            cells.square(row, column) = square / area;
            cells.weight(row, column) = static_cast<float>(count) / area;
          }
        }
      },
      progress);
  if (cv::countNonZero(cells.weight) == 0) return {};
  FillIn(cells);
  BackgroundAround around{cv::Mat3f(size), cv::Mat1f(size)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float weight = cells.weight(y, x);
      const cv::Vec3f mean = cells.sum(y, x) / weight;
      const cv::Vec3f variance = cells.square(y, x) / weight - mean.mul(mean);
      around.color(y, x) = mean;
      around.variance(y, x) =
          std::max(0.0f, (variance[0] + variance[1] + variance[2]) / 3);
    }
  }
  return around;
}

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

// Both colours of row y as the pixel and the background around tell them, beside what
// smoothness says. (M12)
void UpdateRow(const cv::Mat3f& linear,
               const cv::Mat1f& alpha,
               const BackgroundAround& around,
               int y,
               ForegroundColors& colors) {
  constexpr float kSpread = 0.5f;  // Of leaves' brightness about the smooth F
  constexpr float kNoise = 0.03f;  // Of a pixel
  const Between row = CellsAt(y, around.color.rows);
  for (int x = 0; x < linear.cols; ++x) {
    const float a = alpha(y, x), rest = 1 - a;
    if (a <= 0 || a >= 1) continue;
    const Between column = CellsAt(x, around.color.cols);
    const cv::Vec3f b = At(around.color, column, row);
    cv::Vec3f& f = colors.foreground(y, x);
    const float level = (f[0] + f[1] + f[2] + b[0] + b[1] + b[2]) / 6;
    const float of_f = kSpread * level, noise = kNoise * level;
    const float f_part = a * of_f * of_f,
                b_part = rest * At(around.variance, column, row);
    const float of_pixel = a * f_part + rest * b_part + noise * noise;
    if (!(of_pixel > 0)) continue;
    const cv::Vec3f left = (linear(y, x) - a * f - rest * b) / of_pixel;
    for (int c = 0; c < 3; ++c) {
      f[c] = std::max(0.0f, f[c] + f_part * left[c]);
      colors.background(y, x)[c] = std::max(0.0f, b[c] + b_part * left[c]);
    }
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

  const BackgroundAround around = FindBackground(linear, alpha, progress.Part(1, 1));
  if (!around.color.empty()) {
    ParallelRanges(
        linear.rows,
        32,
        [&](int begin, int end) {
          for (int y = begin; y < end; ++y) UpdateRow(linear, alpha, around, y, colors);
        },
        progress.Part(1, 1));
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
