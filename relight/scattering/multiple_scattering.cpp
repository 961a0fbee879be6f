// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/multiple_scattering.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/sh/quadrature.h"
#include "relight/volume/ray_traversal.h"

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

constexpr int kCells = 24, kDirections = 128, kMostOrders = 64;
constexpr float kLeast = 1e-3f;  // Of the light, for one more order

// The volume and its light in large voxels.
struct Coarse {
  ExtinctionGrid grid;
  OccupiedVoxels occupied;
  std::vector<Eigen::Array3f> light;  // E_0, of the occupied.
  int factor = 1;
};

Coarse MakeCoarse(const ExtinctionGrid& grid,
                  const OccupiedVoxels& occupied,
                  const ArrivingLight& light) {
  Coarse coarse;
  coarse.factor = (grid.cells.maxCoeff() + kCells - 1) / kCells;
  coarse.grid = {NoBricks((grid.cells.array() + coarse.factor - 1) / coarse.factor,
                          grid.origin_m,
                          grid.cell_m * coarse.factor),
                 {}};
  std::vector<Eigen::Array3f> sum;
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& at = occupied.cell[v];
    const Eigen::Vector3i large = at / coarse.factor;
    const float sigma = grid.At(at.x(), at.y(), at.z());
    coarse.grid.Add(large.x(), large.y(), large.z(), sigma);
    sum.resize(coarse.grid.Size(), Eigen::Array3f::Zero());
    sum[coarse.grid.Index(large.x(), large.y(), large.z())] += sigma * light.Total(v);
  }
  coarse.occupied = FindOccupied(coarse.grid);
  for (const Eigen::Vector3i& at : coarse.occupied.cell) {
    float& sigma = coarse.grid.sigma_per_m[coarse.grid.Index(at.x(), at.y(), at.z())];
    coarse.light.push_back(sum[coarse.grid.Index(at.x(), at.y(), at.z())] / sigma);
    sigma /= static_cast<float>(coarse.factor * coarse.factor * coarse.factor);
  }
  return coarse;
}

// E_n+1 from E_n.                                                              (S12)
std::vector<Eigen::Array3f> NextOrder(const Coarse& coarse,
                                      const std::vector<Eigen::Vector3d>& directions,
                                      const Eigen::Array3f& albedo,
                                      const std::vector<Eigen::Array3f>& light) {
  constexpr double kOpaque = 1e-4;
  const ExtinctionGrid& grid = coarse.grid;
  std::vector<Eigen::Array3f> next(light.size(), Eigen::Array3f::Zero());
  ParallelRanges(static_cast<int>(light.size()), 64, [&](int begin, int end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
         ++v) {
      const Eigen::Vector3i& at = coarse.occupied.cell[v];
      const Eigen::Vector3d center = grid.Center(at.x(), at.y(), at.z());
      for (const Eigen::Vector3d& direction : directions) {
        double tau = 1.0;
        const auto visit = [&](std::size_t cell, double, double length_m) {
          const int number = coarse.occupied.of_cell[cell];
          if (number < 0) return true;
          const double share = -tau * std::expm1(-length_m * grid.sigma_per_m[cell]);
          next[v] += static_cast<float>(share) * light[static_cast<std::size_t>(number)];
          tau -= share;
          return tau > kOpaque;
        };
        TraverseRay(grid, {center, direction}, 0.0, visit);
      }
      next[v] *= albedo / static_cast<float>(directions.size());
    }
  });
  return next;
}

float Brightest(const std::vector<Eigen::Array3f>& light) {
  float most = 0;
  for (const Eigen::Array3f& color : light) most = std::max(most, color.maxCoeff());
  return most;
}

// Between the centres of large voxels that have leaves.
Eigen::Array3f Interpolated(const Coarse& coarse,
                            const std::vector<Eigen::Array3f>& values,
                            const Eigen::Vector3i& voxel) {
  const Eigen::Array3f at =
      (voxel.cast<float>().array() + 0.5f) / static_cast<float>(coarse.factor) - 0.5f;
  const Eigen::Array3i low = at.floor().cast<int>();
  Eigen::Array3f sum = Eigen::Array3f::Zero();
  float weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i step(corner & 1, corner >> 1 & 1, corner >> 2);
    const Eigen::Array3i cell = low + step;
    const std::ptrdiff_t index = coarse.grid.Find(cell.x(), cell.y(), cell.z());
    if (index < 0) continue;
    const int number = coarse.occupied.of_cell[static_cast<std::size_t>(index)];
    if (number < 0) continue;
    const float weight = (1 - (at - cell.cast<float>()).abs()).prod();
    sum += weight * values[static_cast<std::size_t>(number)];
    weights += weight;
  }
  return sum / weights;  // Its own large voxel has leaves, and a weight of 1/8 at least
}

}  // namespace

std::vector<Eigen::Array3f> MultipleScattering(const ExtinctionGrid& grid,
                                               const OccupiedVoxels& occupied,
                                               const ArrivingLight& light,
                                               const Eigen::Array3f& albedo) {
  Require((albedo >= 0).all() && (albedo <= 1).all(), "an albedo is in [0, 1]");
  const Coarse coarse = MakeCoarse(grid, occupied, light);
  const std::vector<Eigen::Vector3d> directions = SphereDirections(kDirections);
  std::vector<Eigen::Array3f> order = coarse.light;
  std::vector<Eigen::Array3f> all(order.size(), Eigen::Array3f::Zero());
  const float least = kLeast * Brightest(order);
  for (int n = 0; n < kMostOrders && Brightest(order) > least; ++n) {
    order = NextOrder(coarse, directions, albedo, order);
    for (std::size_t v = 0; v < all.size(); ++v) all[v] += order[v];
  }
  std::vector<Eigen::Array3f> result;
  result.reserve(occupied.cell.size());
  for (const Eigen::Vector3i& voxel : occupied.cell) {
    result.push_back(Interpolated(coarse, all, voxel));
  }
  return result;
}

}  // namespace relight
