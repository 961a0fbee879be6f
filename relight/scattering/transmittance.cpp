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

RowExtents FindRowExtents(const ExtinctionGrid& grid) {
  const std::size_t rows =
      static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(grid.cells.z());
  RowExtents extents{std::vector<int>(rows, grid.cells.x()), std::vector<int>(rows, -1)};
  std::size_t index = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (int x = 0; x < grid.cells.x(); ++x, ++index) {
      if (grid.sigma_per_m[index] <= 0) continue;
      extents.first[row] = std::min(extents.first[row], x);
      extents.last[row] = x;
    }
  }
  return extents;
}

void RowOpticalDepth(const ExtinctionGrid& grid,
                     const RowExtents& rows,
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
    const auto row =
        static_cast<std::size_t>(source_y) +
        static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(source_z);
    const int from = std::max(x_begin, rows.first[row] - step.dx);
    const int to = std::min(x_end, rows.last[row] + 1 - step.dx);
    if (from >= to) continue;
    AddScaled(depth + (from - x_begin),
              step.length_m,
              &grid.sigma_per_m[grid.Index(from + step.dx, source_y, source_z)],
              static_cast<std::size_t>(to - from));
  }
}

namespace {

std::size_t RowAt(const ExtinctionGrid& grid, int y, int z) {
  return static_cast<std::size_t>(y) +
         static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(z);
}

// What row(begin, end, y, z, values) writes to values[begin … end - 1], voxel by voxel.
template <class Row>
std::vector<float> OfRows(const ExtinctionGrid& grid,
                          const OccupiedVoxels& occupied,
                          const RowExtents& rows,
                          const Row& row) {
  std::vector<float> result(occupied.cell.size());
  ParallelRanges(grid.cells.z(), 1, [&](int z_begin, int z_end) {
    std::vector<float> values(static_cast<std::size_t>(grid.cells.x()));
    for (int z = z_begin; z < z_end; ++z) {
      for (int y = 0; y < grid.cells.y(); ++y) {
        const int begin = rows.first[RowAt(grid, y, z)];
        const int end = rows.last[RowAt(grid, y, z)] + 1;
        if (begin >= end) continue;
        row(begin, end, y, z, values.data());
        for (int x = begin; x < end; ++x) {
          const int voxel = occupied.of_cell[grid.Index(x, y, z)];
          if (voxel >= 0) {
            result[static_cast<std::size_t>(voxel)] = values[static_cast<std::size_t>(x)];
          }
        }
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
  const RowExtents rows = FindRowExtents(grid);
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
  const RowExtents rows = FindRowExtents(grid);
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
        const float* sigma =
            grid.sigma_per_m.data() +
            static_cast<std::ptrdiff_t>(grid.Index(0, source_y, source_z)) + step.dx;
        steps.push_back({sigma, from, to, step.length_m});
      }
      const std::size_t count = std::min(kBundle, directions.size() - b * kBundle);
      AddBundle({steps, count, share, begin, end}, mean);
    }
  });
}

}  // namespace relight
