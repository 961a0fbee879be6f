// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/sky_transmittance.h"

#include "relight/base/error.h"
#include "relight/scattering/sweep_kernels.h"
#include "relight/scattering/swept_transmittance.h"
#include "relight/sh/basis.h"
#include "relight/sh/quadrature.h"

#include <numbers>

namespace relight {

float SkyTransmittance::Coefficient(int function, std::size_t voxel) const {
  float value = 0.0f;
  FromHalf(&half[static_cast<std::size_t>(function) * voxels + voxel], &value, 1);
  return value;
}

SkyTransmittance PackedSky(int bands, const std::vector<std::vector<float>>& values) {
  Require(values.size() == static_cast<std::size_t>(ShCount(bands)),
          "bands^2 coefficients a voxel");
  SkyTransmittance sky{bands, values.front().size(), {}};
  sky.half.resize(values.size() * sky.voxels);
  for (std::size_t i = 0; i < values.size(); ++i) {
    ToHalf(values[i].data(), &sky.half[i * sky.voxels], sky.voxels);
  }
  return sky;
}

std::vector<std::vector<float>> UnpackedSky(const SkyTransmittance& sky) {
  std::vector<std::vector<float>> values(static_cast<std::size_t>(ShCount(sky.bands)));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i].resize(sky.voxels);
    FromHalf(&sky.half[i * sky.voxels], values[i].data(), sky.voxels);
  }
  return values;
}

SkyTransmittance FirstBands(const SkyTransmittance& sky, int bands) {
  Require(bands >= 1 && bands <= sky.bands, "no more bands than there are");
  SkyTransmittance fewer = sky;
  fewer.bands = bands;
  fewer.half.resize(static_cast<std::size_t>(ShCount(bands)) * sky.voxels);
  return fewer;
}

SkyTransmittance ProjectTransmittance(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const SkyTransmittanceOptions& options,
                                      const Progress& progress,
                                      const Occluder* occluder,
                                      double clumping) {
  CheckFields(options);
  const std::vector<Eigen::Vector3d> directions = SphereDirections(options.directions);
  const double weight_sr = 4 * std::numbers::pi / options.directions;
  std::vector<float> basis;
  for (const Eigen::Vector3d& direction : directions) {
    for (const double y : SphericalHarmonics(direction, options.bands)) {
      basis.push_back(static_cast<float>(weight_sr * y));
    }
  }
  FurtherDepth further;
  if (occluder != nullptr && !occluder->empty()) {
    further = OccluderDepth(*occluder, grid, occupied);
  }
  return PackedSky(
      options.bands,
      ProjectSwept(grid, occupied, directions, basis, progress, further, clumping));
}

}  // namespace relight
