// SPDX-License-Identifier: Apache-2.0
#pragma once

// Coefficients of a function on the sphere in real spherical harmonics, and back.
//
//   [Sloan02] docs/bibliography.md#sloan02
//
//   c_lm = integral over the sphere of f(omega) Y_lm(omega) d omega               (H4)
//   f(omega) ~ sum_lm c_lm Y_lm(omega)                                            (H5)
//
// By SphereQuadrature: exact for functions of few waves on each side of the horizon, with
// any step at the horizon itself.

#include "relight/sh/basis.h"
#include "relight/sh/quadrature.h"

#include <Eigen/Core>

#include <vector>

namespace relight {

// bands^2 rows; a column a channel.
using ShCoefficients = Eigen::Matrix<double, Eigen::Dynamic, 3>;

namespace internal {

// The default quadrature and its functions, made once: values[direction][function] of
// kTableBands bands.
inline constexpr int kTableBands = 8;
struct ProjectionTable {
  std::vector<WeightedDirection> directions;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
};
const ProjectionTable& DefaultProjection();

}  // namespace internal

// c_lm of f: Vector3d -> double.                                                (H4)
template <class Function>
Eigen::VectorXd ProjectOnSh(const Function& f,
                            int bands = kSkyBands,
                            const SphereQuadratureOptions& options = {}) {
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(ShCount(bands));
  for (const auto& [direction, weight_sr] : SphereQuadrature(options)) {
    coefficients += weight_sr * f(direction) * SphericalHarmonics(direction, bands);
  }
  return coefficients;
}

// c_lm of f: Vector3d -> Array3d, channel by channel.                           (H4)
template <class Function>
ShCoefficients ProjectColorOnSh(const Function& f,
                                int bands = kSkyBands,
                                const SphereQuadratureOptions& options = {}) {
  ShCoefficients coefficients = ShCoefficients::Zero(ShCount(bands), 3);
  if (options == SphereQuadratureOptions{} && bands <= internal::kTableBands) {
    const internal::ProjectionTable& table = internal::DefaultProjection();
    for (std::size_t i = 0; i < table.directions.size(); ++i) {
      const auto& [direction, weight_sr] = table.directions[i];
      const Eigen::RowVector3d value = f(direction).matrix().transpose();
      if (value.isZero(0.0)) continue;
      coefficients.noalias() += table.values.row(static_cast<Eigen::Index>(i))
                                    .head(ShCount(bands))
                                    .transpose() *
                                (weight_sr * value);
    }
    return coefficients;
  }
  for (const auto& [direction, weight_sr] : SphereQuadrature(options)) {
    const Eigen::RowVector3d value = f(direction).matrix().transpose();
    if (value.isZero(0.0)) continue;
    coefficients += SphericalHarmonics(direction, bands) * (weight_sr * value);
  }
  return coefficients;
}

// The coefficients of the function turned about +z by `angle_rad`, from +x to +y:
// orders m and -m of a band turn by m times the angle.
//   c'_l,m  = c_l,m cos(m a) - c_l,-m sin(m a)
//   c'_l,-m = c_l,m sin(m a) + c_l,-m cos(m a)                                  (H6)
ShCoefficients TurnedAboutZ(const ShCoefficients& coefficients, double angle_rad);

}  // namespace relight
