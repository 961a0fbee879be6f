// SPDX-License-Identifier: Apache-2.0
#include "matting/matting_laplacian.h"

#include "relight/base/error.h"

#include <Eigen/Core>
#include <Eigen/LU>

#include <array>
#include <vector>

namespace relight {
namespace {

// Entry k of the stencil towards the pixel n of a window, from its pixel m <= n.
constexpr auto kEntryOf = [] {
  std::array<std::array<int, 9>, 9> entry{};
  for (int m = 0; m < 9; ++m) {
    for (int n = m; n < 9; ++n) {
      for (int k = 0; k < kStencil; ++k) {
        if (kStencilOffset[k][0] == n % 3 - m % 3 &&
            kStencilOffset[k][1] == n / 3 - m / 3) {
          entry[m][n] = k;
        }
      }
    }
  }
  return entry;
}();

// Slots of the pixels of a row, -1 outside the system.
void SlotsOfRow(const PixelRuns& pixels, int y, std::vector<std::int32_t>& slot) {
  std::fill(slot.begin(), slot.end(), -1);
  for (const PixelRun& run : pixels.OfRow(y)) {
    for (int i = 0; i < run.length; ++i) slot[run.x + i] = run.below[0] + i;
  }
}

using WindowSlots = std::array<std::int32_t, 9>;

void AddWindow(const cv::Mat3f& image,
               int x,
               int y,
               const WindowSlots& at,
               double epsilon,
               StencilMatrix& matrix) {
  using Column = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 3> color;
  for (int n = 0; n < 9; ++n) {
    const cv::Vec3f& pixel = image(y + n / 3 - 1, x + n % 3 - 1);
    color.row(n) << pixel[0], pixel[1], pixel[2];
  }
  color.rowwise() -= color.colwise().mean().eval();
  const Eigen::Matrix3d covariance =
      color.transpose() * color / 9 + epsilon / 9 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 9, 3> whitened = color * covariance.inverse();

  // (M2), one half of it
  for (int m = 0; m < 9; ++m) {
    if (at[m] < 0) continue;
    const Column row = color * whitened.row(m).transpose();
    for (int n = m; n < 9; ++n) {
      if (at[n] < 0) continue;
      matrix.entry[kEntryOf[m][n]][at[m]] +=
          static_cast<float>((m == n ? 1.0 : 0.0) - (1 + row[n]) / 9);
    }
  }
}

}  // namespace

void AddMattingLaplacian(const cv::Mat3f& image,
                         double epsilon,
                         StencilMatrix& matrix,
                         const Progress& progress) {
  const PixelRuns& pixels = *matrix.pixels;
  Require(image.rows == pixels.rows(), "the system is the image's");
  ForStripes(
      image.rows,
      false,
      [&](int begin, int end) {
        std::array<std::vector<std::int32_t>, 3> slot;
        for (auto& row : slot) row.resize(static_cast<std::size_t>(image.cols));
        for (int y = std::max(begin, 1); y < std::min(end, image.rows - 1); ++y) {
          bool any = false;
          for (int dy = -1; dy <= 1; ++dy) {
            SlotsOfRow(pixels, y + dy, slot[dy + 1]);
            any = any || !pixels.OfRow(y + dy).empty();
          }
          if (!any) continue;
          for (int x = 1; x + 1 < image.cols; ++x) {
            WindowSlots at{};
            bool inside = false;
            for (int n = 0; n < 9; ++n) {
              at[n] = slot[n / 3][x + n % 3 - 1];
              inside = inside || at[n] >= 0;
            }
            if (inside) AddWindow(image, x, y, at, epsilon, matrix);
          }
        }
      },
      progress);
}

}  // namespace relight
