// SPDX-License-Identifier: Apache-2.0
#pragma once

// Turbidity of the air from the colours of a clear sky in photographs.
//
//   [Preetham99] docs/bibliography.md#preetham99   colours and gradient of the sky
//   [BT.2087]    docs/bibliography.md#bt2087        Rec.2020 from Rec.709
//
// A photo tells a sky's colour up to its exposure. Of sample i with the colour c_i and
// the model's colour p_i(T) in its direction,
//
//   r_i = ln (c_R / c_G) - ln (p_R / p_G),   b_i = ln (c_B / c_G) - ln (p_B / p_G),
//   y_i = ln c_Y - ln p_Y - mean over the samples of its photo
//
//   ln P(T) = -n/2 mean_i (rho(r_i / s_c) + rho(b_i / s_c) + rho(y_i / s_y))
//             - (ln T - ln 3)^2 / (2 s_T^2)                                     (K9)
//
// rho  Huber's: x^2 up to 1, 2 |x| - 1 beyond, so that a cloud or a roof pulls little
// s_c  0.10, what white balances and the model err by in colour     s_y  0.30 in the
//      gradient, which lenses darken towards the corners            s_T  0.40
// n    4: samples of one sky err together, so that many say little more than a few
//
// Cameras deepen the colours of a sky. Where no T makes the model's colours those of the
// photos, both logarithms of p_i are taken times one more unknown g, of each T the best:
//
//   g(T) = sum_i c_i . p_i / sum_i p_i . p_i, from 1 to 3;
//   P(T) also has the factor exp(-(ln g)^2 / (2 s_g^2)),   s_g = 0.7             (K11)
//
// with c_i, p_i the pairs of logarithms, in Rec.2020's primaries [BT.2087], for such
// colours are outside of Rec.709's. T then rests on how the colours change over the
// sky, and on the gradient.
//
// T is the mean of ln T under P, its spread the standard deviation. Samples lower than 6
// degrees (haze and smoke of the horizon, which the model has not) and nearer to the sun
// than 15 degrees are left out.

#include <Eigen/Core>

#include <span>
#include <string>

namespace relight {

struct SkySample {
  Eigen::Vector3d direction_in_world = Eigen::Vector3d::UnitZ();  // Unit vector.
  Eigen::Vector3d sun_in_world = Eigen::Vector3d::UnitZ();        // When it was taken.
  Eigen::Array3d color = Eigen::Array3d::Zero();  // Linear Rec.709, of any exposure.
  int photo = 0;                                  // Samples of one have one exposure.
};

struct TurbidityEstimate {
  double turbidity = 3.0;
  double spread = 0.0;    // Standard deviation of ln T.
  double misfit = 0.0;    // Root mean square of r and b at that T.
  double deepened = 1.0;  // g of (K11) at that T.
  int samples = 0;        // Used.
  int photos = 0;         // They are from.
  bool sure = false;
  std::string doubt = {};  // Why it is not sure: "no open sky", "clouds"; else empty.
};

// Sure: at least 24 samples, a spread of 0.2 at most, colours that fit within 0.15, and T
// below 7.5: beyond, haze and thin cloud look alike. Same samples, same answer.
TurbidityEstimate TurbidityFromSky(std::span<const SkySample> samples);

}  // namespace relight
