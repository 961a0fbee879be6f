// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes whose light is known in closed form.

#include "relight/base/parallel.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

namespace relight::tests {

// Gives each voxel of the box value(x, y, z), x fastest.
template <class Value>
void Fill(ExtinctionGrid& grid, Value&& value) {
  for (int z = 0; z < grid.cells.z(); ++z) {
    for (int y = 0; y < grid.cells.y(); ++y) {
      for (int x = 0; x < grid.cells.x(); ++x) {
        grid.Set(x, y, z, static_cast<float>(value(x, y, z)));
      }
    }
  }
}

// Of each voxel of the box, in bricks or not, x fastest.
inline std::vector<float> AllValues(const ExtinctionGrid& grid) {
  std::vector<float> values;
  for (int z = 0; z < grid.cells.z(); ++z) {
    for (int y = 0; y < grid.cells.y(); ++y) {
      for (int x = 0; x < grid.cells.x(); ++x) values.push_back(grid.At(x, y, z));
    }
  }
  return values;
}

// The same extinction everywhere: a slab that is as wide as the grid, its lower face in
// z = 0 and its middle on the z axis.
inline ExtinctionGrid Slab(const Eigen::Vector3i& cells,
                           double cell_m,
                           double sigma_per_m) {
  const Eigen::Vector3d origin_m(
      -0.5 * cell_m * cells.x(), -0.5 * cell_m * cells.y(), 0.0);
  ExtinctionGrid grid{NoBricks(cells, origin_m, cell_m), {}};
  Fill(grid, [&](int, int, int) { return sigma_per_m; });
  return grid;
}

// A ball of radius `radius_m` around `center`: voxels whose centre is inside it.
inline ExtinctionGrid Ball(const Eigen::Vector3d& center,
                           double radius_m,
                           double sigma_per_m,
                           int cells) {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(radius_m);
  ExtinctionGrid grid = EmptyGrid({center - reach, center + reach}, cells);
  Fill(grid, [&](int x, int y, int z) {
    return (grid.Center(x, y, z) - center).norm() > radius_m ? 0.0 : sigma_per_m;
  });
  return grid;
}

// A ball of radius 1.5 m around (0, 0, 2) m, every third voxel empty.
inline ExtinctionGrid BallWithHoles() {
  ExtinctionGrid ball = Ball({0, 0, 2}, 1.5, 1.2, 24);
  std::size_t at = 0;
  Fill(ball,
       [&](int x, int y, int z) { return at++ % 3 == 0 ? 0.0f : ball.At(x, y, z); });
  return ball;
}

// Extinctions of 0 to `most_per_m`, a third of the voxels empty.
inline ExtinctionGrid RandomCanopy(const Eigen::Vector3i& cells,
                                   double cell_m,
                                   double most_per_m,
                                   unsigned seed) {
  ExtinctionGrid grid = Slab(cells, cell_m, 0.0);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 1.0);
  Fill(grid, [&](int, int, int) { return std::max(0.0, uniform(random)) * most_per_m; });
  return grid;
}

// Threads of this process for the length of a scope.
class WithThreads {
 public:
  explicit WithThreads(int threads) { SetThreadCount(threads); }
  ~WithThreads() { SetThreadCount(0); }
  WithThreads(const WithThreads&) = delete;
  WithThreads& operator=(const WithThreads&) = delete;
};

// Equal to the last bit, NaN included.
template <class Value>
bool SameBytes(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}
inline bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && a.isContinuous() &&
         b.isContinuous() && std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

}  // namespace relight::tests
