// SPDX-License-Identifier: Apache-2.0
#pragma once

// How near a relit picture is to the true picture of that hour.
//
//   [Wang04] docs/bibliography.md#wang04   structural similarity
//
// Inside means alpha > 0.5 in the truth and in the matte; what the result says of its own
// alpha decides nothing. A truth without alpha, a photo, is bounded by the matte alone.
// With Y the luminance of Rec.709, p the 99th percentile of the truth's, and L(c) the
// mean of c over a box of side 13/300 of the height, over the inside:
//
//   PSNR(e)  = 10 log10(p^2 / mean(e^2))                                         (E1)
//   g        = sum L(result) L(truth) / sum L(result)^2, per channel             (E2)
//   psnr_low = PSNR(g L(result) - L(truth)),  corr_low = corr(Y L(result), Y L(truth))
//   contrast = (std(Y - Y L) / mean(Y L)) of the result over that of the truth   (E3)
//   level    = mean Y over the truth's
//   colour   = (|ln g_R / g_G| + |ln g_B / g_G|) / 2                             (E4)
//   ring     = PSNR(g alpha_result result - alpha truth) where 0.05 < alpha < 0.5 in the
//              truth
//
// The figures agree with reference/score_relight.py, written apart from them.

#include "relight/base/field.h"

#include <opencv2/core.hpp>

#include <array>
#include <optional>

namespace relight {

// One row. PSNRs in dB; all others are ratios without a unit.
struct RelightingFigures {
  double psnr_low = 0.0;   // Low frequencies after the best gain per channel.
  double corr_low = 0.0;   // Of the low luminance, in [-1, 1]; 0 when one is constant.
  double contrast = 0.0;   // Local contrast as a ratio to the truth's; 1 is best.
  double corr_high = 0.0;  // Of what the low luminance leaves; 0 when one is constant.
  double level = 0.0;      // Mean luminance as a ratio to the truth's; 1 is best.
  double colour = 0.0;     // How far the channels' gains part; 0 is best.
  std::optional<double> ring;       // Of half-covered pixels; none when there are none.
  double psnr = 0.0;                // Absolute, no gain.
  double ssim = 0.0;                // [Wang04] of the luminance.
  std::array<double, 3> gain = {};  // (E2), R, G, B.
};

struct RelightingScore {
  RelightingFigures result;
  // With a source: itself, as if the hour did not matter, and with the truth's colours
  // given to it (relight/ratio/color_transfer.h).
  std::optional<RelightingFigures> nothing = {};
  std::optional<RelightingFigures> histogram = {};
  std::optional<RelightingFigures> reinhard = {};
  std::optional<RelightingFigures> monge_kantorovich = {};
  int pixels = 0;     // Inside.
  double peak = 0.0;  // p.
};

// Straight linear Rec.709 colours, height x width, and their coverage.
struct ScoredPicture {
  cv::Mat3f color;
  cv::Mat1f alpha = {};  // In [0, 1]; empty: the picture has none (release() empties).
};

struct RelightingPictures {
  ScoredPicture result;       // Without alpha: the matte's is taken for `ring`.
  ScoredPicture truth;        // Without alpha: there is no `ring`.
  ScoredPicture source = {};  // What was relit; its alpha is not used. May be empty.
  cv::Mat1f matte = {};       // The true matte, in [0, 1]; empty: the truth's alpha.
};

struct RelightingScoreOptions {
  double scale = 1.0;  // What the source was multiplied by; the result is divided by it.
};

template <class Visitor>
void Describe(RelightingScoreOptions& o, Visitor&& field) {
  field(o.scale,
        {"scale", "", "what the source was multiplied by before relighting", Above(0)});
}

// The inside of these pictures: 255, and 0 elsewhere. Throws InputError for pictures of
// different sizes, neither a matte nor an alpha that leaves anything out, and nothing
// inside.
cv::Mat1b ScoredInside(const RelightingPictures& pictures);

// Throws what ScoredInside throws; InputError for a truth that is black inside, and a
// picture that is not finite inside; OptionError.
RelightingScore ScoreRelighting(const RelightingPictures& pictures,
                                const RelightingScoreOptions& options = {});

}  // namespace relight
