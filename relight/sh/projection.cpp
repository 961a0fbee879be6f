// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/projection.h"

#include "relight/base/error.h"

#include <cmath>

namespace relight {

namespace internal {

const ProjectionTable& DefaultProjection() {
  static const ProjectionTable table = [] {
    ProjectionTable made{SphereQuadrature(), {}};
    made.values.resize(static_cast<Eigen::Index>(made.directions.size()),
                       ShCount(kTableBands));
    for (std::size_t i = 0; i < made.directions.size(); ++i) {
      made.values.row(static_cast<Eigen::Index>(i)) =
          SphericalHarmonics(made.directions[i].direction, kTableBands).transpose();
    }
    return made;
  }();
  return table;
}

}  // namespace internal

// c'_l,m = c_l,m cos(m a) - c_l,-m sin(m a),  c'_l,-m = c_l,m sin(m a) + c_l,-m cos(m a)
//                                                                              (H6)
ShCoefficients TurnedAboutZ(const ShCoefficients& coefficients, double angle_rad) {
  ShCoefficients turned = coefficients;
  const int bands = static_cast<int>(std::lround(std::sqrt(double(coefficients.rows()))));
  Require(ShCount(bands) == coefficients.rows(), "coefficients of whole bands");
  for (int l = 1; l < bands; ++l) {
    for (int m = 1; m <= l; ++m) {
      const double c = std::cos(m * angle_rad), s = std::sin(m * angle_rad);
      const Eigen::RowVector3d even = coefficients.row(ShIndex(l, m));
      const Eigen::RowVector3d odd = coefficients.row(ShIndex(l, -m));
      turned.row(ShIndex(l, m)) = c * even - s * odd;
      turned.row(ShIndex(l, -m)) = s * even + c * odd;
    }
  }
  return turned;
}

}  // namespace relight
