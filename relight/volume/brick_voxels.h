// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels of a regular grid of cubes that hold something, in bricks of 8 x 8 x 8
// (docs/conventions.md#world). What is not in a brick takes no memory; values live in
// arrays of Size() entries beside it, a brick's 512 together, x fastest.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace relight {

struct BrickVoxels {
  static constexpr int kEdge = 8, kPerBrick = kEdge * kEdge * kEdge;

  Eigen::Vector3i cells = {0, 0, 0};      // Voxels along x, y, z.
  Eigen::Vector3d origin_m = {0, 0, 0};   // Lower corner of voxel (0, 0, 0), ENU.
  double cell_m = 0.0;                    // Edge of a voxel.
  Eigen::Vector3i bricks = {0, 0, 0};     // Places of bricks along x, y, z.
  std::vector<std::int32_t> brick_of;     // Per place, x fastest: the brick there, or -1.
  std::vector<Eigen::Vector3i> brick_at;  // Per brick: its lowest voxel.

  std::size_t Size() const { return brick_at.size() * kPerBrick; }
  // Of the whole box, in bricks or not.
  std::size_t Count() const {
    return static_cast<std::size_t>(cells.x()) * static_cast<std::size_t>(cells.y()) *
           static_cast<std::size_t>(cells.z());
  }
  Eigen::Vector3d Center(int x, int y, int z) const {
    return origin_m + cell_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
  }
  Eigen::AlignedBox3d Bounds() const {
    return {origin_m, origin_m + cell_m * cells.cast<double>()};
  }
  bool Contains(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < cells.x() && y < cells.y() && z < cells.z();
  }

  // Of a voxel of the box: its brick, or -1; and its place in any brick.
  std::int32_t BrickOf(int x, int y, int z) const {
    return brick_of[PlaceOf(x >> 3, y >> 3, z >> 3)];
  }
  static int Local(int x, int y, int z) { return (z & 7) << 6 | (y & 7) << 3 | (x & 7); }
  // Where the value of a voxel that is in a brick lies.
  std::size_t Index(int x, int y, int z) const {
    return static_cast<std::size_t>(BrickOf(x, y, z)) * kPerBrick +
           static_cast<std::size_t>(Local(x, y, z));
  }
  // The same, or -1: outside the box, and where there is no brick.
  std::ptrdiff_t Find(int x, int y, int z) const {
    if (!Contains(x, y, z) || BrickOf(x, y, z) < 0) return -1;
    return static_cast<std::ptrdiff_t>(Index(x, y, z));
  }
  // The same for any voxel of the box, whose brick is made where there is none: arrays
  // beside have to grow to Size() then.
  std::size_t Make(int x, int y, int z) {
    std::int32_t& brick = brick_of[PlaceOf(x >> 3, y >> 3, z >> 3)];
    if (brick < 0) {
      brick = static_cast<std::int32_t>(brick_at.size());
      brick_at.emplace_back(x & ~7, y & ~7, z & ~7);
    }
    return Index(x, y, z);
  }
  // The voxel whose value lies there; the inverse of Index.
  Eigen::Vector3i VoxelAt(std::size_t index) const {
    const auto local = static_cast<int>(index % kPerBrick);
    return brick_at[index / kPerBrick] +
           Eigen::Vector3i(local & 7, local >> 3 & 7, local >> 6);
  }
  // Of memory.
  std::size_t Bytes() const {
    return brick_of.capacity() * sizeof(brick_of[0]) +
           brick_at.capacity() * sizeof(brick_at[0]);
  }

 protected:
  std::size_t PlaceOf(int x, int y, int z) const {
    return static_cast<std::size_t>(x + bricks.x() * (y + bricks.y() * z));
  }
};

// A box of voxels without any brick.
inline BrickVoxels NoBricks(const Eigen::Vector3i& cells,
                            const Eigen::Vector3d& origin_m,
                            double cell_m) {
  BrickVoxels voxels;
  voxels.cells = cells;
  voxels.origin_m = origin_m;
  voxels.cell_m = cell_m;
  voxels.bricks = (cells.array() + 7) / 8;
  voxels.brick_of.assign(static_cast<std::size_t>(voxels.bricks.prod()), -1);
  return voxels;
}

// Calls visit(x, y, z, index of the value) for each voxel that is in a brick, in the
// order of the box: x fastest, then y, then z.
template <class Visit>
void ForEachVoxel(const BrickVoxels& voxels, Visit&& visit) {
  for (int z = 0; z < voxels.cells.z(); ++z) {
    for (int y = 0; y < voxels.cells.y(); ++y) {
      for (int low = 0; low < voxels.cells.x(); low += BrickVoxels::kEdge) {
        if (voxels.BrickOf(low, y, z) < 0) continue;
        const int high = std::min(low + BrickVoxels::kEdge, voxels.cells.x());
        std::size_t index = voxels.Index(low, y, z);
        for (int x = low; x < high; ++x, ++index) visit(x, y, z, index);
      }
    }
  }
}

}  // namespace relight
