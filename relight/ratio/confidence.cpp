// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/confidence.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {

cv::Mat1f Confidence(const ViewLight& light,
                     const cv::Mat1f& alpha,
                     double sun_angle_rad) {
  constexpr float kFullWeight = 0.05f;  // w_0
  constexpr float kSpread = 0.3f;       // d_0
  const float changes = HourFade(sun_angle_rad);
  cv::Mat1f weight;
  cv::resize(light.images.weight, weight, alpha.size(), 0, 0, cv::INTER_LINEAR);
  const Correction& correction = light.correction;
  const bool corrected = !correction.log_factor.empty();
  cv::Mat1f confidence(alpha.size());
  ParallelRanges(alpha.rows, 64, [&](int begin, int end) {
    cv::Mat1f trust, spread;
    if (corrected) {
      trust = PatchRows(correction.grid, correction.trust, alpha.cols, begin, end);
      spread = PatchRows(correction.grid, correction.spread, alpha.cols, begin, end);
    }
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < alpha.cols; ++column) {
        if (!(alpha(row, column) > 0)) {
          confidence(row, column) = 0;
          continue;
        }
        float sure = std::min(1.0f, weight(row, column) / kFullWeight);
        if (corrected) {
          const float apart = spread(row - begin, column) / kSpread;
          sure *= trust(row - begin, column) * std::exp(-apart * apart);
        }
        confidence(row, column) = 1 - changes * (1 - sure);
      }
    }
  });
  return confidence;
}

}  // namespace relight
