// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/montage.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"

#include <algorithm>

namespace relight {
namespace {

constexpr int kRowsAtOnce = 16;

float Encoded(float linear) { return SrgbFromLinear(std::clamp(linear, 0.f, 1.f)); }

}  // namespace

// D = (1 - a) D_b D_s + a D_t                                                   (G3)
cv::Mat3f FlatDisplay(const Montage& montage) {
  const cv::Size size = montage.tree.size();
  Require(montage.alpha.size() == size &&
              (montage.shadow.empty() || montage.shadow.size() == size) &&
              (montage.backdrop.empty() || montage.backdrop.size() == size),
          "layers of one size");
  cv::Mat3f flat(size);
  ParallelRanges(size.height, kRowsAtOnce, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const float a = std::clamp(montage.alpha(row, column), 0.f, 1.f);
        for (int c = 0; c < 3; ++c) {
          float below = 1;
          if (!montage.backdrop.empty()) {
            below *= Encoded(montage.backdrop(row, column)[c]);
          }
          if (!montage.shadow.empty()) below *= Encoded(montage.shadow(row, column)[c]);
          flat(row, column)[c] =
              (1 - a) * below + (a > 0 ? a * Encoded(montage.tree(row, column)[c]) : 0);
        }
      }
    }
  });
  return flat;
}

cv::Mat3f FlatPicture(const Montage& montage) {
  return LinearFromDisplay(FlatDisplay(montage));
}

}  // namespace relight
