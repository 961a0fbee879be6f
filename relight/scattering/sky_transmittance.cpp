// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/sky_transmittance.h"

#include "relight/base/parallel.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/basis.h"
#include "relight/sh/quadrature.h"

#include <cmath>
#include <numbers>

namespace relight {

SkyTransmittance ProjectTransmittance(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const SkyTransmittanceOptions& options,
                                      const Progress& progress) {
  CheckFields(options);
  const auto count =
      static_cast<std::size_t>(options.bands) * static_cast<std::size_t>(options.bands);
  SkyTransmittance result;
  result.bands = options.bands;
  result.coefficients.assign(count, std::vector<float>(occupied.cell.size(), 0.0f));

  // Patterns and weighted basis functions of all directions
  const std::vector<Eigen::Vector3d> directions = SphereDirections(options.directions);
  const double weight = 4 * std::numbers::pi / options.directions;
  std::vector<std::vector<PatternStep>> patterns;
  std::vector<float> basis;
  for (const Eigen::Vector3d& direction : directions) {
    patterns.push_back(RayPattern(grid.cells, grid.cell_m, direction));
    for (const double y : SphericalHarmonics(direction, options.bands)) {
      basis.push_back(static_cast<float>(weight * y));
    }
  }

  // Row by row, so that the sums of a row stay in the cache over all directions
  const RowExtents rows = FindRowExtents(grid);
  const int row_count = grid.cells.y() * grid.cells.z();
  ParallelRanges(
      row_count,
      16,
      [&](int row_begin, int row_end) {
        const auto width = static_cast<std::size_t>(grid.cells.x());
        std::vector<float> tau(width), sums(count * width);
        for (int r = row_begin; r < row_end; ++r) {
          const auto row = static_cast<std::size_t>(r);
          const int begin = rows.first[row], end = rows.last[row] + 1;
          if (begin >= end) continue;
          const int y = r % grid.cells.y(), z = r / grid.cells.y();
          const int length = end - begin;
          std::fill(sums.begin(), sums.end(), 0.0f);
          for (std::size_t d = 0; d < directions.size(); ++d) {
            RowOpticalDepth(grid, rows, patterns[d], begin, end, y, z, tau.data());
            for (int i = 0; i < length; ++i)
              tau[static_cast<std::size_t>(i)] =
                  std::exp(-tau[static_cast<std::size_t>(i)]);
            for (std::size_t c = 0; c < count; ++c) {
              const float factor = basis[d * count + c];
              float* __restrict sum = &sums[c * width];
              const float* __restrict t = tau.data();
              for (int i = 0; i < length; ++i) sum[i] += factor * t[i];
            }
          }
          for (int x = begin; x < end; ++x) {
            const int voxel = occupied.of_cell[grid.Index(x, y, z)];
            if (voxel < 0) continue;
            for (std::size_t c = 0; c < count; ++c) {
              result.coefficients[c][static_cast<std::size_t>(voxel)] =
                  sums[c * width + static_cast<std::size_t>(x - begin)];
            }
          }
        }
      },
      progress);
  return result;
}

}  // namespace relight
