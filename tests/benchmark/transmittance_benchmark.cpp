// SPDX-License-Identifier: Apache-2.0

// Transmittance of all voxels of a crown along one direction: rows at a time, as the
// light volume is made, against a ray traversal from each voxel; and a copy of as many
// floats as the volume has, for scale. Read the ratios, not the times.

#include "relight/scattering/transmittance.h"
#include "relight/volume/ray_traversal.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <random>

namespace relight {
namespace {

// A porous ball of 100 voxels across, a tenth of them full.
ExtinctionGrid Crown() {
  ExtinctionGrid grid =
      EmptyGrid({Eigen::Vector3d::Constant(-5), Eigen::Vector3d::Constant(5)}, 100);
  std::mt19937 random(1);
  for (int z = 0; z < 100; ++z) {
    for (int y = 0; y < 100; ++y) {
      for (int x = 0; x < 100; ++x) {
        if (grid.Center(x, y, z).norm() < 5 && random() % 10 == 0) {
          grid.Set(x, y, z, 2.0f);
        }
      }
    }
  }
  return grid;
}

const Eigen::Vector3d kDirection = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();

void ByRows(benchmark::State& state) {
  const ExtinctionGrid grid = Crown();
  const OccupiedVoxels occupied = FindOccupied(grid);
  for (auto _ : state) {
    benchmark::DoNotOptimize(TransmittanceAlong(grid, occupied, kDirection).data());
  }
}
BENCHMARK(ByRows)->Unit(benchmark::kMillisecond)->UseRealTime();

void ByRays(benchmark::State& state) {
  const ExtinctionGrid grid = Crown();
  const OccupiedVoxels occupied = FindOccupied(grid);
  std::vector<float> transmittance(occupied.cell.size());
  for (auto _ : state) {
    for (std::size_t v = 0; v < transmittance.size(); ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      transmittance[v] = static_cast<float>(std::exp(
          -OpticalDepth(grid, {grid.Center(at.x(), at.y(), at.z()), kDirection})));
    }
    benchmark::DoNotOptimize(transmittance.data());
  }
}
BENCHMARK(ByRays)->Unit(benchmark::kMillisecond)->UseRealTime();

void CopyOfTheVolume(benchmark::State& state) {
  const ExtinctionGrid grid = Crown();
  const std::vector<float> values(grid.Count(), 1.0f);
  std::vector<float> copy(grid.Count());
  for (auto _ : state) {
    std::memcpy(copy.data(), values.data(), copy.size() * sizeof(float));
    benchmark::DoNotOptimize(copy.data());
  }
}
BENCHMARK(CopyOfTheVolume)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace relight
