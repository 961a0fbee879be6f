// SPDX-License-Identifier: Apache-2.0
#include "matting/mask_trimap.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace relight {
namespace {

constexpr int kSide = 32;       // Cells of the histogram along a channel.
constexpr float kShare = 0.1f;  // s of (M7).

int CellOf(const cv::Vec3f& color) {
  int cell = 0;
  for (int c = 0; c < 3; ++c) {
    cell = cell * kSide + std::clamp(static_cast<int>(color[c] * kSide), 0, kSide - 1);
  }
  return cell;
}

// Shares of the cells among the pixels of one label, blurred by a cell so that a colour
// between two cells is in both.
std::vector<float> Histogram(const cv::Mat3f& display,
                             const cv::Mat1b& trimap,
                             std::uint8_t label) {
  std::vector<float> count(kSide * kSide * kSide, 0.0f);
  double total = 0;
  for (int y = 0; y < display.rows; ++y) {
    for (int x = 0; x < display.cols; ++x) {
      if (trimap(y, x) != label) continue;
      ++count[static_cast<std::size_t>(CellOf(display(y, x)))];
      ++total;
    }
  }
  for (const int step : {1, kSide, kSide * kSide}) {
    const std::vector<float> before = count;
    for (int i = 0; i < static_cast<int>(count.size()); ++i) {
      const int place = i / step % kSide;
      const float left = place > 0 ? before[i - step] : 0.0f;
      const float right = place + 1 < kSide ? before[i + step] : 0.0f;
      count[i] = 0.25f * left + 0.5f * before[i] + 0.25f * right;
    }
  }
  for (float& share : count) share = static_cast<float>(share / std::max(total, 1.0));
  return count;
}

}  // namespace

cv::Mat1b TrimapFromMask(const cv::Mat3f& display,
                         const cv::Mat1f& mask,
                         const MaskTrimapOptions& options,
                         const Progress& progress) {
  CheckFields(options);
  if (display.size() != mask.size() || display.empty()) {
    throw InputError("the mask is " + std::to_string(mask.cols) + " x " +
                     std::to_string(mask.rows) + " pixels, the photo " +
                     std::to_string(display.cols) + " x " + std::to_string(display.rows) +
                     "; make the mask at the photo's size");
  }
  const double band = options.band_px > 0
                          ? options.band_px
                          : std::max(3.0, std::min(mask.rows, mask.cols) / 150.0);

  // Sure: further than the band from all that is not
  cv::Mat1b trimap = TrimapFromGray(mask);
  cv::Mat1f from_edge;
  for (const std::uint8_t label : {kTrimapForeground, kTrimapBackground}) {
    progress.Report(label == kTrimapForeground ? 0.1 : 0.3);
    const cv::Mat1b inside = trimap == label;
    if (cv::countNonZero(inside) == static_cast<int>(inside.total())) break;
    cv::distanceTransform(inside, from_edge, cv::DIST_L2, cv::DIST_MASK_5);
    trimap.setTo(kTrimapUnknown, inside & (from_edge <= band));
  }
  const TrimapCounts counts = CountLabels(trimap);
  if (counts.foreground == 0 || counts.background == 0) {
    throw InputError(std::string("the mask ") +
                     (counts.foreground == 0 ? "holds no tree" : "leaves nothing out") +
                     ", " + std::to_string(std::lround(band)) +
                     " pixels from its edge and more; give the mask of a tree, 1 inside "
                     "and 0 outside, or a smaller --refine-band");
  }

  // Holes that were filled. (M7)
  progress.Report(0.5);
  const auto inside = Histogram(display, trimap, kTrimapForeground);
  progress.Report(0.6);
  const auto outside = Histogram(display, trimap, kTrimapBackground);
  cv::Mat1b hole(mask.size(), std::uint8_t{0});
  ParallelRanges(
      mask.rows,
      64,
      [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
          for (int x = 0; x < mask.cols; ++x) {
            if (trimap(y, x) != kTrimapForeground) continue;
            const auto cell = static_cast<std::size_t>(CellOf(display(y, x)));
            hole(y, x) = outside[cell] > kShare * inside[cell] ? 255 : 0;
          }
        }
      },
      progress.Part(0.7, 0.9));
  // With what is around, which leaf and sky share
  const int reach = static_cast<int>(std::lround(band)) + 1;
  cv::dilate(hole, hole, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  trimap.setTo(kTrimapUnknown, hole & (trimap == kTrimapForeground));
  CheckTrimap(trimap);
  progress.Report(1);
  return trimap;
}

}  // namespace relight
