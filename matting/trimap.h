// SPDX-License-Identifier: Apache-2.0
#pragma once

// Trimap: what is known of a matte before matting. One byte a pixel, of three labels.

#include <opencv2/core.hpp>

#include <cstdint>

namespace relight {

inline constexpr std::uint8_t kTrimapBackground = 0;
inline constexpr std::uint8_t kTrimapUnknown = 128;
inline constexpr std::uint8_t kTrimapForeground = 255;

// Labels of a picture drawn as a trimap, in [0, 1]: below 0.02 is background, above 0.98
// foreground (so a JPEG's or a resampling's rounding does no harm), all between and NaN
// are unknown. Throws InputError for an empty picture.
cv::Mat1b TrimapFromGray(const cv::Mat1f& gray);

// Strokes drawn by a user, as labels: kTrimapForeground and kTrimapBackground where
// somebody drew, kTrimapUnknown elsewhere.
//
// From a picture, display values in [0, 1]: white or green is tree, black or red is not.
// With `alpha` (empty: none) what is more than half transparent is not drawn. One of the
// four colours that covers more than half of the picture is its canvas, not a stroke.
// Throws InputError when no stroke of either kind is there, or the sizes differ.
cv::Mat1b StrokesFromPicture(const cv::Mat3f& display, const cv::Mat1f& alpha);

// From two masks in [0, 1]: drawn where above 0.5. Throws InputError when the sizes
// differ, a mask is empty, or both claim one pixel.
cv::Mat1b StrokesFromMasks(const cv::Mat1f& tree, const cv::Mat1f& not_tree);

struct TrimapCounts {
  std::int64_t background = 0, unknown = 0, foreground = 0;
};

// Throws InputError when a byte is none of the three labels.
TrimapCounts CountLabels(const cv::Mat1b& trimap);

// Throws InputError, with the remedy, for a trimap nothing can be estimated from: empty,
// a byte that is no label, or unknown pixels without any foreground or any background.
// A trimap without unknown pixels is fine whatever it holds.
void CheckTrimap(const cv::Mat1b& trimap);

}  // namespace relight
