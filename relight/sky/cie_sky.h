// SPDX-License-Identifier: Apache-2.0
#pragma once

// Relative luminance of the fifteen standard skies, from overcast to clear.
//
//   [ISO15469] docs/bibliography.md#iso15469   gradation, indicatrix and their parameters
//
//   L / L_z = f(chi) phi(Z) / (f(Z_s) phi(0))                                      (K5)
//   phi(Z)  = 1 + a exp(b / cos Z)                    gradation, from zenith to horizon
//   f(chi)  = 1 + c (exp(d chi) - exp(d pi / 2)) + e cos^2 chi     indicatrix, round the
//                                                                  sun
//
// Z    zenith angle of the direction     Z_s   of the sun     chi   between the two
// L_z  luminance of the zenith           a..e  one row a type, 1 to 15
//
// At the horizon itself, where b / cos Z has no bound, phi is 1 (all b are negative).

#include <Eigen/Core>

namespace relight {

inline constexpr int kCieOvercast = 1;  // The CIE's standard overcast sky.

class CieSky {
 public:
  // `sun_in_world` needs no unit length, and may be below the horizon. Throws OptionError
  // for a type that is not 1 to 15.
  CieSky(const Eigen::Vector3d& sun_in_world, int type);

  // L / L_z of a unit direction; 0 below the horizon.
  double operator()(const Eigen::Vector3d& direction_in_world) const;

  int type() const { return type_; }

 private:
  double Gradation(double cos_zenith_angle) const;
  double Indicatrix(double angle_rad) const;

  Eigen::Vector3d sun_;
  int type_;
  double at_zenith_;  // f(Z_s) phi(0).
};

}  // namespace relight
