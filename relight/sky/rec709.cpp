// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/rec709.h"

#include <Eigen/LU>

namespace relight {
namespace {

// Chromaticities of the primaries and the white fix the matrix: its columns are the
// primaries' XYZ, scaled so that they add up to the white with Y = 1.     [IEC61966]
Eigen::Matrix3d MatrixXyzFromRec709() {
  const auto xyz_of = [](double x, double y) {
    return Eigen::Vector3d(x / y, 1.0, (1.0 - x - y) / y);
  };
  Eigen::Matrix3d primaries;
  primaries << xyz_of(0.64, 0.33), xyz_of(0.30, 0.60), xyz_of(0.15, 0.06);
  const Eigen::Vector3d white(0.95047, 1.0, 1.08883);  // D65 in five digits
  return primaries * (primaries.inverse() * white).asDiagonal();
}

}  // namespace

Eigen::Array3d XyzFromRec709(const Eigen::Array3d& rgb) {
  static const Eigen::Matrix3d matrix = MatrixXyzFromRec709();
  return (matrix * rgb.matrix()).array();
}

Eigen::Array3d Rec709FromXyz(const Eigen::Array3d& xyz) {
  static const Eigen::Matrix3d matrix = MatrixXyzFromRec709().inverse();
  return (matrix * xyz.matrix()).array();
}

}  // namespace relight
