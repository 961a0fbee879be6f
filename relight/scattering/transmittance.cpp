// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/transmittance.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/sweep_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

std::vector<float> TransmittanceAlong(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const Eigen::Vector3d& direction) {
  return TransmittanceAlong(grid, occupied, FindRowExtents(grid), direction);
}

std::vector<float> TransmittanceAlong(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const RowExtents& rows,
                                      const Eigen::Vector3d& direction) {
  const std::vector<PatternStep> pattern = RayPattern(grid.cells, grid.cell_m, direction);
  std::vector<float> transmittance(occupied.cell.size());
  ParallelRanges(grid.cells.z(), 1, [&](int z_begin, int z_end) {
    std::vector<float> depth(static_cast<std::size_t>(grid.cells.x()));
    for (int z = z_begin; z < z_end; ++z) {
      for (int y = 0; y < grid.cells.y(); ++y) {
        const auto row =
            static_cast<std::size_t>(y) +
            static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(z);
        const int begin = rows.first[row], end = rows.last[row] + 1;
        if (begin >= end) continue;
        RowOpticalDepth(grid, rows, pattern, begin, end, y, z, depth.data());
        ExpOfNegative(depth.data(), static_cast<std::size_t>(end - begin));
        for (int x = begin; x < end; ++x) {
          const int voxel = occupied.of_cell[grid.Index(x, y, z)];
          if (voxel >= 0) {
            transmittance[static_cast<std::size_t>(voxel)] =
                depth[static_cast<std::size_t>(x - begin)];
          }
        }
      }
    }
  });
  return transmittance;
}

}  // namespace relight
