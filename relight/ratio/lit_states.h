// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which of a patch's leaves the photo shows in the sun, and what another hour makes of
// each: a leaf seen is either lit or in shade, and a bright pixel is more likely a lit
// one. For pixels of luminance I, with p the share of the samples along the patch's rays
// that the volume has in the sun, E_shade the sky's light there, E_lit = E_shade + S, and
// a the reflectance around,
//
//   P(lit | I) = p g(I; a E_lit) / (p g(I; a E_lit) + (1 - p) g(I; a E_shade))
//   ratio = sum I [P(lit | I) T_lit / E_lit + P(shade | I) T_shade / E_shade] / sum I
//   (R8)
//
// g normal in ln I with mean ln(a E) - s^2 / 2 and deviation s, the spread of leaves'
// brightness. T is the light of the wanted hour of what is in that state now: the sky's,
// and the sun's by how often samples are lit at both hours,
//
//   P(lit then | lit) = m + (1 - m) h,   P(lit then | shade) = n (1 - h)         (R9)
//
// with m, n the shares of the lit, and of the shaded, samples that are lit then, and h
// falling from 1 as the suns part, so that equal hours have the ratio 1.

#include <array>

namespace relight {

// Pixels by luminance, relative to the picture's mean: bin b holds those of
// [kLowest + b kWidth, kLowest + (b + 1) kWidth) in ln.
struct LuminanceBins {
  static constexpr int kCount = 16;
  static constexpr double kLowest = -4.0, kWidth = 0.4;
  static int Of(double relative_luminance);
  static double Center(int bin);  // Luminance, not its logarithm.
};

// Light of a patch, any one unit; shares in [0, 1].
struct PatchLight {
  double lit_now = 0, lit_then = 0, lit_both = 0;  // Shares of the samples.
  double sky_now = 0, sky_then = 0;                // Means over the samples.
  double sun_now = 0, sun_then = 0;                // Unshaded.
  double between_suns_rad = 0;
};

struct LitStates {
  double ratio = 1;      // (R8)
  double lit_share = 0;  // Mean of P(lit | I).
};

// `pixels`: weights of the bins, all >= 0; nothing when their sum is 0. `reflectance`: a,
// relative luminance over light.
LitStates EstimateLitStates(const std::array<float, LuminanceBins::kCount>& pixels,
                            const PatchLight& light,
                            double reflectance,
                            double spread);

}  // namespace relight
