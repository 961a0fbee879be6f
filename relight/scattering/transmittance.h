// SPDX-License-Identifier: Apache-2.0
#pragma once

// Transmittance of the volume from the centre of a voxel u to the outside along one
// direction, the voxel's own extinction included:
//
//   tau(u, w) = exp(-integral of sigma from u along w)                    [Cabral11, Eq.
//   6]
//
// Rays from all voxel centres along one direction cross the same pattern of voxels,
// shifted. The pattern is found once, and applied to whole rows of voxels at a time.

#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <cstddef>
#include <span>
#include <vector>

namespace relight {

// One voxel of the pattern: its offset from the ray's own voxel and the length inside it.
struct PatternStep {
  int dx = 0, dy = 0, dz = 0;
  float length_m = 0.0f;
};

// All steps until the ray has left any grid of `cells` voxels, wherever it starts.
std::vector<PatternStep> RayPattern(const Eigen::Vector3i& cells,
                                    double cell_m,
                                    const Eigen::Vector3d& direction);

// A grid in rows along x, each from its first to its last non-empty voxel, one behind the
// other. All but the extinctions are per row, y + cells.y() * z.
struct VoxelRows {
  std::vector<int> first, last;    // last < first in an empty row.
  std::vector<std::size_t> begin;  // Where the row's first voxel is in
  std::vector<float> sigma_per_m;

  // Of the voxel x of a row; to be read in [first, last] only.
  const float* At(std::size_t row, int x) const {
    return sigma_per_m.data() +
           (static_cast<std::ptrdiff_t>(begin[row]) + x - first[row]);
  }
};
VoxelRows RowsOf(const ExtinctionGrid& grid);

// Optical depths along `pattern` from the centres of the voxels (x_begin … x_end - 1, y,
// z), written to depth[0 … x_end - x_begin - 1].
void RowOpticalDepth(const ExtinctionGrid& grid,
                     const VoxelRows& rows,
                     const std::vector<PatternStep>& pattern,
                     int x_begin,
                     int x_end,
                     int y,
                     int z,
                     float* depth);

// tau(u, direction) for each non-empty voxel, in the order of `occupied`, which is that
// of FindOccupied. `direction`: unit vector in the world, away from the voxel.
std::vector<float> TransmittanceAlong(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const Eigen::Vector3d& direction);

// The mean of the same over directions that lie close together, as those of the sun's
// disc: their patterns share most voxels, and are taken eight at a time. As fast for any
// directions that differ little over the grid; right for all.
std::vector<float> MeanTransmittanceAlong(const ExtinctionGrid& grid,
                                          const OccupiedVoxels& occupied,
                                          std::span<const Eigen::Vector3d> directions);

}  // namespace relight
