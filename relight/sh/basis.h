// SPDX-License-Identifier: Apache-2.0
#pragma once

// Real spherical harmonics, orthonormal, z up, no Condon-Shortley phase
// (docs/conventions.md#spherical-harmonics). `bands` bands have bands^2 functions; band
// l, order m is at index l (l + 1) + m.
//
//   [Sloan02] docs/bibliography.md#sloan02
//
//   Y_l,m  = N_l,m P_l^m(cos theta) cos(m phi)        m > 0
//   Y_l,-m = N_l,m P_l^m(cos theta) sin(m phi)        m > 0
//   Y_l,0  = N_l,0 P_l(cos theta)                                                (H1)
//
// theta is the angle from +z, phi from +x to +y. As polynomials in x, y, z: sin^m theta
// cos(m phi) and sin(m phi) are the real and imaginary part of (x + i y)^m, and
// Q_l,m = N_l,m P_l^m / sin^m theta obeys
//
//   Q_0,0 = 1 / sqrt(4 pi),  Q_1,1 = sqrt(3) Q_0,0,
//   Q_m,m = sqrt((2m + 1) / (2m)) Q_m-1,m-1,        m > 1
//   Q_l,m = sqrt((4 l^2 - 1) / (l^2 - m^2)) (z Q_l-1,m
//           - sqrt(((l - 1)^2 - m^2) / (4 (l - 1)^2 - 1)) Q_l-2,m)              (H2)
//
// in this normalisation, with sqrt(2) of m > 0 counted in.

#include <Eigen/Core>

namespace relight {

// The sky's and the light volume's: 6 bands, 36 coefficients.
inline constexpr int kSkyBands = 6;

// More bands than this are refused (Require).
inline constexpr int kMaxShBands = 32;

constexpr int ShCount(int bands) { return bands * bands; }
constexpr int ShIndex(int l, int m) { return l * (l + 1) + m; }

namespace internal {
void FillSphericalHarmonics(const Eigen::Vector3d& direction, int bands, double* values);
}  // namespace internal

// All functions of `bands` bands at a unit direction.
Eigen::VectorXd SphericalHarmonics(const Eigen::Vector3d& direction, int bands);

// The same with the size known when compiling, and nothing allocated.
template <int kBands>
Eigen::Matrix<double, ShCount(kBands), 1> SphericalHarmonics(
    const Eigen::Vector3d& direction) {
  static_assert(kBands >= 1 && kBands <= kMaxShBands);
  Eigen::Matrix<double, ShCount(kBands), 1> values;
  internal::FillSphericalHarmonics(direction, kBands, values.data());
  return values;
}

}  // namespace relight
