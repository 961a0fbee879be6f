// SPDX-License-Identifier: Apache-2.0
#pragma once

// How strong the sky is beside the sun, and how dense the volume, by the shading that the
// photo itself shows; [Cabral11, §7.1] chose the density by hand. Over patches i of the
// crown (1/20 of its height) with the photo's mean luminance P_i and the simulation's,
// A_i by the sun and B_i by the rest,
//
//   ln P_i = c + ln(A_i + e^k B_i) + noise
//   L(k) = (n / 2) ln var + k^2 / (2 d_0^2)                              (R7)
//
// with var the weighted variance of what is left over, c free, n patches, and a prior of
// d_0 = 0.3 around the simulation as it is; k is where L is least, its deviation
// 1 / sqrt(L''). The density s has the same prior on ln s, and each s the best k.
//
// Where light from all sides shades alike, L is flat and the photo cannot tell: then the
// answer is the prior's, and `flat` says so.

#include "relight/base/field.h"
#include "relight/scattering/single_scattering.h"

#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace relight {

struct LightFitOptions {
  bool fit_light = false;
};

template <class Visitor>
void Describe(LightFitOptions& o, Visitor&& field) {
  field(
      o.fit_light,
      FieldInfo{"fit-light",
                "",
                "strength of the sky and density of the tree by the photo's own shading, "
                "as far as it tells them"});
}

// One number a patch, all positive.
struct ShadingPatches {
  std::vector<double> photo, sun, rest, weight;
};

// `colors` linear and straight, and `alpha`, of the images' size or larger.
ShadingPatches ShadingOf(const IrradianceImage& input,
                         const cv::Mat3f& colors,
                         const cv::Mat1f& alpha);

struct FittedNumber {
  double log_value = 0.0;
  double deviation = 0.0;
  bool flat = true;  // The photo says less than the prior.
};

// What L is at one density.
struct SkyFit {
  FittedNumber sky;       // k
  double least = 0.0;     // L at k
  double spread = 0.0;    // Square root of var at k, and
  double unfitted = 0.0;  // at k = 0.
};

// Of a view: both, and what they repay.
struct LightFit {
  FittedNumber density;   // ln s
  FittedNumber sky;       // k
  double spread = 0.0;    // Of ln P - ln(A + e^k B), fitted, and
  double unfitted = 0.0;  // as the simulation is.
};

// "by the photo's own shading the sky is 0.83 (0.71 to 0.97) times …": what is shown.
std::string FitInWords(const LightFit& fit);

// Fewer than 8 patches tell nothing: the prior.
SkyFit FitSky(const ShadingPatches& patches);

// The least of L over ln s by a parabola through the three samples around it;
// `log_scales` ascending and evenly spaced, L without the prior of s in `costs`.
FittedNumber FitScale(const std::vector<double>& log_scales,
                      const std::vector<double>& costs);

}  // namespace relight
