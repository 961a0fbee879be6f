// SPDX-License-Identifier: Apache-2.0
#pragma once

// Luminance and colour of the clear and hazy sky.
//
//   [Preetham99] docs/bibliography.md#preetham99   the model and its coefficients
//   [Perez93]    docs/bibliography.md#perez93      the distribution F
//
//   F(theta, gamma) = (1 + A exp(B / cos theta)) (1 + C exp(D gamma) + E cos^2 gamma)
//                                                                       [Perez93]
//   Y, x, y = Y_z, x_z, y_z * F(theta, gamma) / F(0, theta_s)           [Preetham99]
//
// theta   zenith angle of the direction       theta_s  of the sun      gamma  between
// both T       turbidity: 2 clear, 3 fair, 6 hazy. A..E are linear in T, one set each for
// Y, x, y Y       luminance [cd/m2]; x, y chromaticity (CIE 1931)
//
// Limits. The model knows no sun below the horizon: the zenith luminance Y_z falls to 0
// just under it, and is negative for T > 11. Below T = 1.7 the luminance near the zenith
// is negative. We take 1.7 <= T <= 10 and a sun above the horizon, and refuse the rest.
// There x, y and 1 - x - y are positive, so that XYZ needs no clamp; Rec.709 does only
// for T below 4 and a sun in the last degrees above the horizon.

#include "relight/base/field.h"

#include <Eigen/Core>

namespace relight {

// What is done to colours that the model puts outside of what can be shown.
enum class SkyClamp {
  kXyz,     // Negative X or Z to 0; Rec.709 keeps its negative channels (a wider gamut).
  kRec709,  // Negative R, G, B to 0, as [Cabral11] has it.
};

// The coefficients are in the paper with four decimals, in its authors' own program with
// five: luminances part by less than 0.1 %, Z by up to 0.8 % under a low sun in haze.
enum class PreethamCoefficients { kPaper, kProgram };

struct PreethamSkyOptions {
  double turbidity = 3.0;
  SkyClamp clamp = SkyClamp::kXyz;
  PreethamCoefficients coefficients = PreethamCoefficients::kPaper;
};

template <class Visitor>
void Describe(PreethamSkyOptions& o, Visitor&& field) {
  field(o.turbidity,
        {"turbidity", "", "haze of the air: 2 clear, 6 hazy", Between(1.7, 10)});
  field(o.clamp, {"sky-clamp", "", "where negative colours are set to 0"});
  field(o.coefficients,
        {"sky-coefficients", "", "of the paper, or of its authors' program"});
}

// A colour as luminance [cd/m2] and chromaticity.
struct LuminanceChromaticity {
  double luminance_cd_per_m2 = 0.0;
  double x = 0.0;
  double y = 0.0;
};

class PreethamSky {
 public:
  // `sun_in_world` needs no unit length. Throws OptionError, and InputError when the sun
  // is not above the horizon.
  explicit PreethamSky(const Eigen::Vector3d& sun_in_world,
                       const PreethamSkyOptions& options = {});

  // Linear Rec.709 radiance [cd/m2 per channel] from a unit direction; 0 below the
  // horizon.
  Eigen::Array3d operator()(const Eigen::Vector3d& direction_in_world) const;

  // The same as CIE 1931 XYZ, X and Z never negative; 0 below the horizon.
  Eigen::Array3d Xyz(const Eigen::Vector3d& direction_in_world) const;

  // The model as it is written, nothing clamped; luminance 0 below the horizon.
  LuminanceChromaticity Color(const Eigen::Vector3d& direction_in_world) const;

  const LuminanceChromaticity& zenith() const { return zenith_; }

 private:
  struct Perez {
    double A, B, C, D, E;
    double operator()(double cos_theta, double gamma, double cos_gamma) const;
  };

  Eigen::Vector3d sun_;
  SkyClamp clamp_;
  LuminanceChromaticity zenith_;
  Perez luminance_, x_, y_;                                 // F of Y, x and y.
  double luminance_at_zenith_, x_at_zenith_, y_at_zenith_;  // Their F(0, theta_s).
};

}  // namespace relight
