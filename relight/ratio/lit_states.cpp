// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/lit_states.h"

#include "relight/base/angles.h"

#include <algorithm>
#include <cmath>

namespace relight {

int LuminanceBins::Of(double relative_luminance) {
  const double at = (std::log(std::max(1e-9, relative_luminance)) - kLowest) / kWidth;
  return static_cast<int>(std::clamp(at, 0.0, kCount - 1.0));
}

double LuminanceBins::Center(int bin) { return std::exp(kLowest + (bin + 0.5) * kWidth); }

LitStates EstimateLitStates(const std::array<float, LuminanceBins::kCount>& pixels,
                            const PatchLight& light,
                            double reflectance,
                            double spread) {
  constexpr double kLeast = 0.01;  // No sample is surely lit, nor surely in shade
  const double lit = std::clamp(light.lit_now, kLeast, 1 - kLeast);
  const double both = std::clamp(light.lit_both, 0.0, light.lit_then);
  const double part = light.between_suns_rad / RadFromDeg(10);
  const double same = std::exp(-part * part);
  const double stays = std::min(1.0, both / lit);
  const double becomes = std::min(1.0, (light.lit_then - both) / (1 - lit));
  const double shade_now = std::max(1e-9, light.sky_now);
  const double lit_now = shade_now + light.sun_now;
  const double of_lit =
      (light.sky_then + light.sun_then * (stays + (1 - stays) * same)) / lit_now;
  const double of_shade =
      (light.sky_then + light.sun_then * becomes * (1 - same)) / shade_now;

  // Of a luminance's logarithm, but for what both states have in common
  const auto log_likelihood = [&](double log_luminance, double light_now) {
    const double mean = std::log(reflectance * light_now) - spread * spread / 2;
    const double off = (log_luminance - mean) / spread;
    return -off * off / 2;
  };
  double sum = 0, luminance_sum = 0, relit = 0, lit_sum = 0;
  for (int bin = 0; bin < LuminanceBins::kCount; ++bin) {
    const double weight = pixels[static_cast<std::size_t>(bin)];
    const double luminance = LuminanceBins::Center(bin);
    const double log_luminance = std::log(luminance);
    const double shade_to_lit = (1 - lit) / lit *
                                std::exp(log_likelihood(log_luminance, shade_now) -
                                         log_likelihood(log_luminance, lit_now));
    const double p = 1 / (1 + shade_to_lit);
    sum += weight;
    luminance_sum += weight * luminance;
    relit += weight * luminance * (p * of_lit + (1 - p) * of_shade);
    lit_sum += weight * p;
  }
  if (!(sum > 0)) return {};
  return {relit / luminance_sum, lit_sum / sum};
}

}  // namespace relight
