// SPDX-License-Identifier: Apache-2.0
#include "matting/trimap.h"

#include "relight/base/error.h"

#include <array>
#include <string>

namespace relight {

cv::Mat1b TrimapFromGray(const cv::Mat1f& gray) {
  if (gray.empty())
    throw InputError("the trimap is empty (0 x 0 pixels); give a picture");
  cv::Mat1b trimap(gray.size(), kTrimapUnknown);
  for (int y = 0; y < gray.rows; ++y) {
    for (int x = 0; x < gray.cols; ++x) {
      if (gray(y, x) < 0.02f) trimap(y, x) = kTrimapBackground;
      if (gray(y, x) > 0.98f) trimap(y, x) = kTrimapForeground;
    }
  }
  return trimap;
}

namespace {

void RequireStrokes(const cv::Mat1b& strokes, const char* what) {
  if (cv::countNonZero(strokes != kTrimapUnknown) > 0) return;
  throw InputError(std::string(what) +
                   " holds no stroke; draw on the tree in white or green, beside it in "
                   "black or red");
}

}  // namespace

cv::Mat1b StrokesFromPicture(const cv::Mat3f& display, const cv::Mat1f& alpha) {
  if (display.empty()) throw InputError("the picture of strokes is empty (0 x 0 pixels)");
  if (!alpha.empty() && alpha.size() != display.size()) {
    throw InputError("strokes and their alpha are of two sizes");
  }
  struct Ink {
    cv::Vec3f color;
    std::uint8_t label;
    std::int64_t pixels = 0;
  };
  std::array<Ink, 4> inks = {{{{1, 1, 1}, kTrimapForeground},
                              {{0, 1, 0}, kTrimapForeground},
                              {{0, 0, 0}, kTrimapBackground},
                              {{1, 0, 0}, kTrimapBackground}}};
  constexpr double kNear = 0.25;  // Edges of a stroke are softer; a JPEG is not exact
  cv::Mat1b drawn(display.size(), std::uint8_t{4});
  for (int y = 0; y < display.rows; ++y) {
    for (int x = 0; x < display.cols; ++x) {
      if (!alpha.empty() && !(alpha(y, x) > 0.5f)) continue;
      for (std::uint8_t n = 0; n < inks.size(); ++n) {
        if (cv::norm(display(y, x), inks[n].color, cv::NORM_INF) >= kNear) continue;
        drawn(y, x) = n;
        ++inks[n].pixels;
      }
    }
  }
  cv::Mat1b strokes(display.size(), kTrimapUnknown);
  for (std::uint8_t n = 0; n < inks.size(); ++n) {
    if (2 * inks[n].pixels > static_cast<std::int64_t>(display.total())) continue;
    strokes.setTo(inks[n].label, drawn == n);
  }
  RequireStrokes(strokes, "the picture");
  return strokes;
}

cv::Mat1b StrokesFromMasks(const cv::Mat1f& tree, const cv::Mat1f& not_tree) {
  if (tree.size() != not_tree.size()) {
    throw InputError("the two masks of strokes are of two sizes");
  }
  cv::Mat1b strokes(tree.size(), kTrimapUnknown);
  for (int y = 0; y < tree.rows; ++y) {
    for (int x = 0; x < tree.cols; ++x) {
      const bool is = tree(y, x) > 0.5f, is_not = not_tree(y, x) > 0.5f;
      if (is && is_not) {
        throw InputError("both masks of strokes claim the pixel (" + std::to_string(x) +
                         ", " + std::to_string(y) + "); take it out of one of them");
      }
      if (is) strokes(y, x) = kTrimapForeground;
      if (is_not) strokes(y, x) = kTrimapBackground;
    }
  }
  RequireStrokes(strokes, "neither mask");
  return strokes;
}

TrimapCounts CountLabels(const cv::Mat1b& trimap) {
  TrimapCounts counts;
  for (int y = 0; y < trimap.rows; ++y) {
    for (int x = 0; x < trimap.cols; ++x) {
      switch (trimap(y, x)) {
        case kTrimapBackground:
          ++counts.background;
          break;
        case kTrimapUnknown:
          ++counts.unknown;
          break;
        case kTrimapForeground:
          ++counts.foreground;
          break;
        default:
          throw InputError(
              "the trimap holds " + std::to_string(trimap(y, x)) + " at (" +
              std::to_string(x) + ", " + std::to_string(y) +
              "); labels are 0, 128 and 255: pass it through TrimapFromGray");
      }
    }
  }
  return counts;
}

void CheckTrimap(const cv::Mat1b& trimap) {
  if (trimap.empty())
    throw InputError("the trimap is empty (0 x 0 pixels); give a picture");
  const TrimapCounts counts = CountLabels(trimap);
  if (counts.unknown == 0) return;
  if (counts.foreground == 0) {
    throw InputError(
        "the trimap has no foreground (white) pixel; mark some of the tree that is "
        "certainly solid, e.g. its trunk, white");
  }
  if (counts.background == 0) {
    throw InputError(
        "the trimap has no background (black) pixel; mark some that certainly shows no "
        "tree, e.g. open sky, black");
  }
}

}  // namespace relight
