// SPDX-License-Identifier: Apache-2.0
#pragma once

// What stands beside the tree and takes light from it: a house as triangles, or another
// tree's volume. In the world of the tree (docs/conventions.md#world): metres, x east,
// y north, z up.
//
//   [Moeller97] docs/bibliography.md#moeller97   whether a ray meets a triangle
//
//   T(p, w) = 0 where a triangle is on the way from p along w, else
//             exp(-integral of the occluder's sigma)                              (S8)
//
// It multiplies tau of the tree's volume for the sun and for each direction of the sky.

#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace relight {

class Occluder {
 public:
  // Hides nothing.
  Occluder() = default;
  // `faces` are numbers of `vertices`. Degenerate ones hide nothing. Throws
  // std::logic_error for a number that is none.
  Occluder(const std::vector<Eigen::Vector3d>& vertices,
           const std::vector<std::array<int, 3>>& faces);
  explicit Occluder(ExtinctionGrid grid);

  // T of (S8); `direction` is a unit vector.
  double Transmittance(const Eigen::Vector3d& point,
                       const Eigen::Vector3d& direction) const;
  // On the way between two points, either way.
  double TransmittanceBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  std::size_t triangles() const { return triangles_.size(); }
  bool empty() const { return triangles_.empty() && grid_.sigma_per_m.empty(); }

 private:
  struct Triangle {
    Eigen::Vector3d corner, edge1, edge2;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0;  // Triangle of a leaf, else the first of two children.
    int count = 0;  // Triangles of a leaf; 0: two children.
  };
  void Build(int node, int begin, int end);
  bool Hides(const Eigen::Vector3d& from,
             const Eigen::Vector3d& direction,
             double length_m) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  ExtinctionGrid grid_;
};

// An .obj: v and f of it (polygons as fans), z up, metres; or a .vdb (ImportVdb). Throws
// InputError that names the file, the line and a remedy: neither of them, no triangles, a
// number that cannot be read or is not finite, a vertex that is not there, more than 20
// million triangles.
Occluder ReadOccluder(const std::filesystem::path& file);

// -ln T per voxel for swept_transmittance.h, from T on a lattice over the occupied
// voxels, 16 steps along its longest side, with linear interpolation: the sky needs no
// sharper edge. Nothing is added, to the last bit, along a direction where T is 1 all
// over. Keeps references.
std::function<void(const Eigen::Vector3d& direction, std::span<float> depth)>
OccluderDepth(const Occluder& occluder,
              const ExtinctionGrid& grid,
              const OccupiedVoxels& occupied);

}  // namespace relight
