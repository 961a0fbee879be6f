// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/preetham_sky.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/rec709.h"

#include <Eigen/Geometry>

#include <sstream>

namespace relight {
namespace {

// (T^2, T, 1) M (theta_s^3, theta_s^2, theta_s, 1)^T                   [Preetham99]
double ZenithChromaticity(const double (&M)[3][4], double T, double theta_s) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(&M[0][0]);
  const Eigen::RowVector3d in_turbidity(T * T, T, 1.0);
  const Eigen::Vector4d in_angle(
      theta_s * theta_s * theta_s, theta_s * theta_s, theta_s, 1.0);
  return in_turbidity * matrix * in_angle;
}

// What is linear in T: slope and value at T = 0 of A, B, C, D, E.
using PerezTable = double[5][2];

struct Coefficients {
  PerezTable luminance, x, y;
  double zenith_x[3][4], zenith_y[3][4];
};

constexpr Coefficients kPaper = {.luminance = {{0.1787, -1.4630},
                                               {-0.3554, 0.4275},
                                               {-0.0227, 5.3251},
                                               {0.1206, -2.5771},
                                               {-0.0670, 0.3703}},
                                 .x = {{-0.0193, -0.2592},
                                       {-0.0665, 0.0008},
                                       {-0.0004, 0.2125},
                                       {-0.0641, -0.8989},
                                       {-0.0033, 0.0452}},
                                 .y = {{-0.0167, -0.2608},
                                       {-0.0950, 0.0092},
                                       {-0.0079, 0.2102},
                                       {-0.0441, -1.6537},
                                       {-0.0109, 0.0529}},
                                 .zenith_x = {{0.00166, -0.00375, 0.00209, 0.0},
                                              {-0.02903, 0.06377, -0.03202, 0.00394},
                                              {0.11693, -0.21196, 0.06052, 0.25886}},
                                 .zenith_y = {{0.00275, -0.00610, 0.00317, 0.0},
                                              {-0.04214, 0.08970, -0.04153, 0.00516},
                                              {0.15346, -0.26756, 0.06670, 0.26688}}};

constexpr Coefficients kProgram = {.luminance = {{0.17872, -1.46303},
                                                 {-0.35540, 0.42749},
                                                 {-0.02266, 5.32505},
                                                 {0.12064, -2.57705},
                                                 {-0.06696, 0.37027}},
                                   .x = {{-0.01925, -0.25922},
                                         {-0.06651, 0.00081},
                                         {-0.00041, 0.21247},
                                         {-0.06409, -0.89887},
                                         {-0.00325, 0.04517}},
                                   .y = {{-0.01669, -0.26078},
                                         {-0.09495, 0.00921},
                                         {-0.00792, 0.21023},
                                         {-0.04405, -1.65369},
                                         {-0.01092, 0.05291}},
                                   .zenith_x = {{0.00165, -0.00374, 0.00208, 0.0},
                                                {-0.02902, 0.06377, -0.03202, 0.00394},
                                                {0.11693, -0.21196, 0.06052, 0.25885}},
                                   .zenith_y = {{0.00275, -0.00610, 0.00316, 0.0},
                                                {-0.04214, 0.08970, -0.04153, 0.00515},
                                                {0.15346, -0.26756, 0.06669, 0.26688}}};

// Y_z = (4.0453 T - 4.9710) tan chi - 0.2155 T + 2.4192  [kcd/m2],
// chi = (4/9 - T/120) (pi - 2 theta_s)                                 [Preetham99]
double ZenithLuminance(double T, double theta_s) {
  const double chi = (4.0 / 9.0 - T / 120.0) * (std::numbers::pi - 2.0 * theta_s);
  return 1000.0 * ((4.0453 * T - 4.9710) * std::tan(chi) - 0.2155 * T + 2.4192);
}

}  // namespace

// F = (1 + A exp(B / cos theta)) (1 + C exp(D gamma) + E cos^2 gamma)  [Perez93]
double PreethamSky::Perez::operator()(double cos_theta,
                                      double gamma,
                                      double cos_gamma) const {
  return (1.0 + A * std::exp(B / cos_theta)) *
         (1.0 + C * std::exp(D * gamma) + E * cos_gamma * cos_gamma);
}

PreethamSky::PreethamSky(const Eigen::Vector3d& sun_in_world,
                         const PreethamSkyOptions& options)
    : sun_(sun_in_world.normalized()), clamp_(options.clamp) {
  CheckFields(options);
  if (!(sun_.z() > 0.0)) {
    std::ostringstream text;
    text << "the sun is at " << DegFromRad(ElevationOf(sun_in_world))
         << " degrees, and the sky model ends at the horizon; choose an hour between "
            "sunrise and sunset";
    throw InputError(text.str());
  }

  // The five coefficients of each distribution, linear in the turbidity
  const Coefficients& table =
      options.coefficients == PreethamCoefficients::kPaper ? kPaper : kProgram;
  const double T = options.turbidity;
  const auto at_turbidity = [T](const PerezTable& of) {
    const auto value = [&](int i) { return of[i][0] * T + of[i][1]; };
    return Perez{value(0), value(1), value(2), value(3), value(4)};
  };
  luminance_ = at_turbidity(table.luminance);
  x_ = at_turbidity(table.x);
  y_ = at_turbidity(table.y);

  // The zenith, and F there
  const double cos_theta_s = sun_.z();
  const double theta_s = AngleBetween(sun_, Eigen::Vector3d::UnitZ());
  zenith_ = {ZenithLuminance(T, theta_s),
             ZenithChromaticity(table.zenith_x, T, theta_s),
             ZenithChromaticity(table.zenith_y, T, theta_s)};
  Require(zenith_.luminance_cd_per_m2 > 0.0, "the zenith is bright for T in 1.7 to 10");
  luminance_at_zenith_ = luminance_(1.0, theta_s, cos_theta_s);
  x_at_zenith_ = x_(1.0, theta_s, cos_theta_s);
  y_at_zenith_ = y_(1.0, theta_s, cos_theta_s);
}

// Y, x, y = Y_z, x_z, y_z * F(theta, gamma) / F(0, theta_s)            [Preetham99]
LuminanceChromaticity PreethamSky::Color(const Eigen::Vector3d& direction) const {
  const double cos_theta = direction.z();
  if (cos_theta < 0.0) return {0.0, zenith_.x, zenith_.y};
  const double gamma = AngleBetween(direction, sun_);
  const double cos_gamma = std::cos(gamma);
  return {zenith_.luminance_cd_per_m2 * luminance_(cos_theta, gamma, cos_gamma) /
              luminance_at_zenith_,
          zenith_.x * x_(cos_theta, gamma, cos_gamma) / x_at_zenith_,
          zenith_.y * y_(cos_theta, gamma, cos_gamma) / y_at_zenith_};
}

// X = Y x / y,  Z = Y (1 - x - y) / y                                         (K3)
Eigen::Array3d PreethamSky::Xyz(const Eigen::Vector3d& direction) const {
  const auto [Y, x, y] = Color(direction);
  if (Y == 0.0) return Eigen::Array3d::Zero();
  return Eigen::Array3d(Y * x / y, Y, Y * (1.0 - x - y) / y).max(0.0);
}

Eigen::Array3d PreethamSky::operator()(const Eigen::Vector3d& direction) const {
  const Eigen::Array3d rgb = Rec709FromXyz(Xyz(direction));
  return clamp_ == SkyClamp::kRec709 ? Eigen::Array3d(rgb.max(0.0)) : rgb;
}

}  // namespace relight
