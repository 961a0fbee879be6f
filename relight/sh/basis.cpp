// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/basis.h"

#include "relight/base/error.h"

#include <array>
#include <cmath>
#include <numbers>

namespace relight {
namespace {

// Factors of (H2), made once.
struct Recurrence {
  double diagonal[kMaxShBands];        // Q_m,m / Q_m-1,m-1
  double a[kMaxShBands][kMaxShBands];  // a[l][m], before the bracket
  double b[kMaxShBands][kMaxShBands];  // b[l][m], before Q_l-2,m

  Recurrence() {
    for (int m = 0; m < kMaxShBands; ++m) {
      diagonal[m] = m == 0   ? std::sqrt(1.0 / (4.0 * std::numbers::pi))
                    : m == 1 ? std::sqrt(3.0)
                             : std::sqrt((2.0 * m + 1.0) / (2.0 * m));
      for (int l = m + 1; l < kMaxShBands; ++l) {
        const double l2 = double(l) * l, m2 = double(m) * m, k2 = (l - 1.0) * (l - 1.0);
        a[l][m] = std::sqrt((4.0 * l2 - 1.0) / (l2 - m2));
        b[l][m] = l == m + 1 ? 0.0 : std::sqrt((k2 - m2) / (4.0 * k2 - 1.0));
      }
    }
  }
};

}  // namespace

namespace internal {

// Column m of the triangle after column m - 1: Q down the column by (H2), times the real
// and imaginary part of (x + i y)^m.
void FillSphericalHarmonics(const Eigen::Vector3d& direction, int bands, double* values) {
  static const Recurrence recurrence;
  const double x = direction.x(), y = direction.y(), z = direction.z();
  double diagonal = 1.0, re = 1.0, im = 0.0;
  for (int m = 0; m < bands; ++m) {
    diagonal *= recurrence.diagonal[m];
    double before = 0.0, q = diagonal;
    for (int l = m; l < bands; ++l) {
      if (l > m) {
        const double next = recurrence.a[l][m] * (z * q - recurrence.b[l][m] * before);
        before = q;
        q = next;
      }
      values[ShIndex(l, m)] = q * re;
      if (m > 0) values[ShIndex(l, -m)] = q * im;
    }
    const double turned = re * x - im * y;
    im = re * y + im * x;
    re = turned;
  }
}

}  // namespace internal

Eigen::VectorXd SphericalHarmonics(const Eigen::Vector3d& direction, int bands) {
  Require(bands >= 1 && bands <= kMaxShBands, "1 to 32 bands of spherical harmonics");
  Eigen::VectorXd values(ShCount(bands));
  internal::FillSphericalHarmonics(direction, bands, values.data());
  return values;
}

}  // namespace relight
