// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/cie_sky.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <cmath>
#include <numbers>
#include <string>

namespace relight {
namespace {

struct Parameters {
  double a, b, c, d, e;
};

constexpr Parameters kTypes[] = {
    {4.0, -0.7, 0.0, -1.0, 0.0},       // 1 overcast, steep, the same all round
    {4.0, -0.7, 2.0, -1.5, 0.15},      // 2 overcast, steep, a little brighter at the sun
    {1.1, -0.8, 0.0, -1.0, 0.0},       // 3 overcast, moderate, the same all round
    {1.1, -0.8, 2.0, -1.5, 0.15},      // 4 overcast, moderate, a little brighter
    {0.0, -1.0, 0.0, -1.0, 0.0},       // 5 uniform
    {0.0, -1.0, 2.0, -1.5, 0.15},      // 6 partly cloudy, a little brighter at the sun
    {0.0, -1.0, 5.0, -2.5, 0.3},       // 7 partly cloudy, brighter round the sun
    {0.0, -1.0, 10.0, -3.0, 0.45},     // 8 partly cloudy, a corona
    {-1.0, -0.55, 2.0, -1.5, 0.15},    // 9 partly cloudy, the sun hidden
    {-1.0, -0.55, 5.0, -2.5, 0.3},     // 10 partly cloudy, brighter round the sun
    {-1.0, -0.55, 10.0, -3.0, 0.45},   // 11 white-blue, a corona
    {-1.0, -0.32, 10.0, -3.0, 0.45},   // 12 clear, low turbidity
    {-1.0, -0.32, 16.0, -3.0, 0.3},    // 13 clear, polluted
    {-1.0, -0.15, 16.0, -3.0, 0.3},    // 14 cloudless, turbid, a broad corona
    {-1.0, -0.15, 24.0, -2.8, 0.15}};  // 15 white-blue, turbid, a broad corona

const Parameters& Of(int type) { return kTypes[type - 1]; }

}  // namespace

CieSky::CieSky(const Eigen::Vector3d& sun_in_world, int type)
    : sun_(sun_in_world.normalized()), type_(type) {
  if (type < 1 || type > 15) {
    throw OptionError("the type of a CIE sky must be 1 to 15, got " +
                      std::to_string(type));
  }
  at_zenith_ = Indicatrix(AngleBetween(sun_, Eigen::Vector3d::UnitZ())) * Gradation(1.0);
}

double CieSky::Gradation(double cos_zenith_angle) const {
  if (cos_zenith_angle <= 0) return 1.0;
  return 1 + Of(type_).a * std::exp(Of(type_).b / cos_zenith_angle);
}

double CieSky::Indicatrix(double angle_rad) const {
  const auto& [a, b, c, d, e] = Of(type_);
  const double cosine = std::cos(angle_rad);
  return 1 + c * (std::exp(d * angle_rad) - std::exp(d * std::numbers::pi / 2)) +
         e * cosine * cosine;
}

// L / L_z = f(chi) phi(Z) / (f(Z_s) phi(0))                                      (K5)
double CieSky::operator()(const Eigen::Vector3d& direction) const {
  if (direction.z() < 0) return 0.0;
  return Indicatrix(AngleBetween(sun_, direction)) * Gradation(direction.z()) /
         at_zenith_;
}

}  // namespace relight
