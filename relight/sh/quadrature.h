// SPDX-License-Identifier: Apache-2.0
#pragma once

// Directions with weights: sums over them are integrals over the sphere.
//
//   [Gauss1814]   docs/bibliography.md#gauss1814    nodes of Gauss-Legendre
//   [Gonzalez10]  docs/bibliography.md#gonzalez10   the Fibonacci lattice on the sphere

#include <Eigen/Core>

#include <vector>

namespace relight {

struct WeightedDirection {
  Eigen::Vector3d direction;  // Unit vector.
  double weight_sr = 0.0;
};

struct SphereQuadratureOptions {
  int heights_per_side =
      48;             // Gauss-Legendre nodes above the horizon, and as many below.
  int azimuths = 96;  // Equal steps round the horizon.

  bool operator==(const SphereQuadratureOptions&) const = default;
};

// The product of Gauss-Legendre in z and equal steps of azimuth, split at the horizon: a
// function that is a polynomial of degree 2 heights_per_side - 1 on each side of it, and
// has less than `azimuths` waves round it, is integrated exactly, its step included.
// Weights add up to 4 pi.
std::vector<WeightedDirection> SphereQuadrature(
    const SphereQuadratureOptions& options = {});

// `count` well spread directions of equal weight 4 pi / count, from the zenith down:
//   z_i = 1 - (2 i + 1) / count,   phi_i = i pi (3 - sqrt 5)                    (H3)
std::vector<Eigen::Vector3d> SphereDirections(int count);

}  // namespace relight
