// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/transmittance.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/sweep_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace relight {

std::vector<PatternStep> RayPattern(const Eigen::Vector3i& cells,
                                    double cell_m,
                                    const Eigen::Vector3d& direction) {
  Require(std::abs(direction.norm() - 1) < 1e-6, "a direction has unit length");
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::array<double, 3> to_face{}, per_cell{};
  std::array<int, 3> offset{}, step{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = std::abs(direction[static_cast<Eigen::Index>(axis)]);
    per_cell[axis] = slope < 1e-12 ? kFar : cell_m / slope;
    to_face[axis] = per_cell[axis] / 2;  // From the centre
    step[axis] = direction[static_cast<Eigen::Index>(axis)] > 0 ? 1 : -1;
  }
  std::vector<PatternStep> pattern;
  double at = 0.0;
  for (;;) {
    const auto axis = static_cast<std::size_t>(
        std::min_element(to_face.begin(), to_face.end()) - to_face.begin());
    if (to_face[axis] > at) {
      pattern.push_back(
          {offset[0], offset[1], offset[2], static_cast<float>(to_face[axis] - at)});
      at = to_face[axis];
    }
    offset[axis] += step[axis];
    if (std::abs(offset[axis]) >= cells[static_cast<Eigen::Index>(axis)]) return pattern;
    to_face[axis] += per_cell[axis];
  }
}

namespace {

std::size_t RowAt(const ExtinctionGrid& grid, int y, int z) {
  return static_cast<std::size_t>(y) +
         static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(z);
}

}  // namespace

VoxelRows RowsOf(const ExtinctionGrid& grid) {
  const std::size_t count =
      static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(grid.cells.z());
  VoxelRows rows{std::vector<int>(count, grid.cells.x()),
                 std::vector<int>(count, -1),
                 std::vector<std::size_t>(count, 0),
                 {}};
  // The box's order is that of its rows, so that each voxel goes behind the one before
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    const float sigma = grid.sigma_per_m[index];
    if (sigma <= 0) return;
    const std::size_t row = RowAt(grid, y, z);
    if (rows.last[row] < 0) {
      rows.first[row] = rows.last[row] = x;
      rows.begin[row] = rows.sigma_per_m.size();
    } else {
      const auto empty = static_cast<std::size_t>(x - rows.last[row] - 1);
      rows.sigma_per_m.insert(rows.sigma_per_m.end(), empty, 0.0f);
      rows.last[row] = x;
    }
    rows.sigma_per_m.push_back(sigma);
  });
  return rows;
}

void RowOpticalDepth(const ExtinctionGrid& grid,
                     const VoxelRows& rows,
                     const std::vector<PatternStep>& pattern,
                     int x_begin,
                     int x_end,
                     int y,
                     int z,
                     float* depth) {
  std::fill(depth, depth + (x_end - x_begin), 0.0f);
  for (const PatternStep& step : pattern) {
    const int source_y = y + step.dy, source_z = z + step.dz;
    if (source_y < 0 || source_z < 0 || source_y >= grid.cells.y() ||
        source_z >= grid.cells.z()) {
      return;  // The pattern only moves on, so the row has left the grid for good
    }
    const std::size_t row = RowAt(grid, source_y, source_z);
    const int from = std::max(x_begin, rows.first[row] - step.dx);
    const int to = std::min(x_end, rows.last[row] + 1 - step.dx);
    if (from >= to) continue;
    AddScaled(depth + (from - x_begin),
              step.length_m,
              rows.At(row, from + step.dx),
              static_cast<std::size_t>(to - from));
  }
}

namespace {

// What row(begin, end, y, z, values) writes to values[begin … end - 1], voxel by voxel.
template <class Row>
std::vector<float> OfRows(const ExtinctionGrid& grid,
                          const OccupiedVoxels& occupied,
                          const VoxelRows& rows,
                          const Row& row) {
  std::vector<float> result(occupied.cell.size());
  const auto is_below = [](const Eigen::Vector3i& cell, int z) { return cell.z() < z; };
  ParallelRanges(grid.cells.z(), 1, [&](int z_begin, int z_end) {
    std::vector<float> values(static_cast<std::size_t>(grid.cells.x()));
    // Voxels lie row by row, as the grid's
    const auto end = occupied.cell.end();
    auto voxel = std::lower_bound(occupied.cell.begin(), end, z_begin, is_below);
    while (voxel != end && voxel->z() < z_end) {
      const int y = voxel->y(), z = voxel->z();
      const std::size_t at = RowAt(grid, y, z);
      row(rows.first[at], rows.last[at] + 1, y, z, values.data());
      for (; voxel != end && voxel->y() == y && voxel->z() == z; ++voxel) {
        result[static_cast<std::size_t>(voxel - occupied.cell.begin())] =
            values[static_cast<std::size_t>(voxel->x())];
      }
    }
  });
  return result;
}

}  // namespace

std::vector<float> TransmittanceAlong(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const Eigen::Vector3d& direction) {
  const std::vector<PatternStep> pattern = RayPattern(grid.cells, grid.cell_m, direction);
  const VoxelRows rows = RowsOf(grid);
  return OfRows(grid, occupied, rows, [&](int begin, int end, int y, int z, float* tau) {
    RowOpticalDepth(grid, rows, pattern, begin, end, y, z, tau + begin);
    ExpOfNegative(tau + begin, static_cast<std::size_t>(end - begin));
  });
}

namespace {

// Voxels that some of eight rays cross, and how far each of them is inside.
struct BundleStep {
  int dx = 0, dy = 0, dz = 0;
  std::array<float, kBundle> length_m{};
};

// A ray's steps go one voxel on along one axis, so that the number of voxels away orders
// each ray's steps as they are.
std::vector<BundleStep> BundlePattern(const ExtinctionGrid& grid,
                                      std::span<const Eigen::Vector3d> directions) {
  std::vector<BundleStep> steps;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (const PatternStep& one : RayPattern(grid.cells, grid.cell_m, directions[i])) {
      BundleStep step{one.dx, one.dy, one.dz, {}};
      step.length_m[i] = one.length_m;
      steps.push_back(step);
    }
  }
  const auto key = [](const BundleStep& s) {
    return std::tuple(std::abs(s.dx) + std::abs(s.dy) + std::abs(s.dz), s.dz, s.dy, s.dx);
  };
  std::stable_sort(
      steps.begin(), steps.end(), [&](const BundleStep& a, const BundleStep& b) {
        return key(a) < key(b);
      });
  std::vector<BundleStep> merged;
  for (const BundleStep& step : steps) {
    if (merged.empty() || key(merged.back()) != key(step)) {
      merged.push_back(step);
      continue;
    }
    for (std::size_t i = 0; i < kBundle; ++i) {
      merged.back().length_m[i] += step.length_m[i];
    }
  }
  return merged;
}

}  // namespace

std::vector<float> MeanTransmittanceAlong(const ExtinctionGrid& grid,
                                          const OccupiedVoxels& occupied,
                                          std::span<const Eigen::Vector3d> directions) {
  Require(!directions.empty(), "one direction or more");
  if (directions.size() == 1) return TransmittanceAlong(grid, occupied, directions[0]);
  std::vector<std::vector<BundleStep>> bundles;
  for (std::size_t i = 0; i < directions.size(); i += kBundle) {
    bundles.push_back(BundlePattern(
        grid, directions.subspan(i, std::min(kBundle, directions.size() - i))));
  }
  const VoxelRows rows = RowsOf(grid);
  const float share = 1.0f / static_cast<float>(directions.size());
  return OfRows(grid, occupied, rows, [&](int begin, int end, int y, int z, float* mean) {
    std::vector<RowStep> steps;
    std::fill(mean + begin, mean + end, 0.0f);
    for (std::size_t b = 0; b < bundles.size(); ++b) {
      // What the row's rays meet
      steps.clear();
      for (const BundleStep& step : bundles[b]) {
        const int source_y = y + step.dy, source_z = z + step.dz;
        if (source_y < 0 || source_z < 0 || source_y >= grid.cells.y() ||
            source_z >= grid.cells.z()) {
          continue;
        }
        const std::size_t source = RowAt(grid, source_y, source_z);
        const int from = std::max(begin, rows.first[source] - step.dx);
        const int to = std::min(end, rows.last[source] + 1 - step.dx);
        if (from >= to) continue;
        // Of x = 0, which need not be in the row
        steps.push_back({rows.At(source, step.dx), from, to, step.length_m});
      }
      const std::size_t count = std::min(kBundle, directions.size() - b * kBundle);
      AddBundle({steps, count, share, begin, end}, mean);
    }
  });
}

}  // namespace relight
