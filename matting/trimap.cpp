// SPDX-License-Identifier: Apache-2.0
#include "matting/trimap.h"

#include "relight/base/error.h"

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
