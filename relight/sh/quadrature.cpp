// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/quadrature.h"

#include "relight/base/error.h"

#include <cmath>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

struct Node {
  double x = 0.0;
  double weight = 0.0;
};

Eigen::Vector3d DirectionAt(double z, double phi) {
  const double s = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {s * std::cos(phi), s * std::sin(phi), z};
}

// Nodes on (0, 1): roots of P_n by Newton, weight 2 / ((1 - x^2) P_n'(x)^2) on (-1, 1).
//                                                                     [Gauss1814]
std::vector<Node> GaussLegendre01(int n) {
  std::vector<Node> nodes;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(pi * (i + 0.75) / (n + 0.5)), derivative = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double before = 0.0, p = 1.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
        before = p;
        p = next;
      }
      derivative = n * (x * p - before) / (x * x - 1.0);
      const double step = p / derivative;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative)});
  }
  return nodes;
}

}  // namespace

std::vector<WeightedDirection> SphereQuadrature(const SphereQuadratureOptions& options) {
  Require(options.heights_per_side >= 1 && options.azimuths >= 1,
          "a quadrature has nodes");
  const double step_rad = 2.0 * pi / options.azimuths;
  std::vector<WeightedDirection> directions;
  for (const double side : {+1.0, -1.0}) {
    for (const Node& node : GaussLegendre01(options.heights_per_side)) {
      for (int i = 0; i < options.azimuths; ++i) {
        directions.push_back(
            {DirectionAt(side * node.x, (i + 0.5) * step_rad), node.weight * step_rad});
      }
    }
  }
  return directions;
}

// z_i = 1 - (2 i + 1) / count,   phi_i = i pi (3 - sqrt 5)                       (H3)
std::vector<Eigen::Vector3d> SphereDirections(int count) {
  Require(count >= 1, "one direction or more");
  const double golden_angle = pi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    directions.push_back(DirectionAt(1.0 - (2.0 * i + 1.0) / count, i * golden_angle));
  }
  return directions;
}

}  // namespace relight
