// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/single_scattering.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/volume/ray_traversal.h"

#include <cmath>

namespace relight {
namespace {

cv::Vec3f Pixel(const Eigen::Array3d& color) {
  return {static_cast<float>(color[0]),
          static_cast<float>(color[1]),
          static_cast<float>(color[2])};
}

}  // namespace

ScatteringImages SingleScattering(const ExtinctionGrid& grid,
                                  const OccupiedVoxels& occupied,
                                  std::span<const ArrivingLight> lights,
                                  const Camera& camera,
                                  const cv::Mat1b& mask,
                                  const Progress& progress) {
  const cv::Size size(camera.width_px, camera.height_px);
  Require(mask.empty() || mask.size() == size, "the mask has the camera's size");
  ScatteringImages images;
  images.weight = cv::Mat1f::zeros(size);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    images.lights.push_back(
        {cv::Mat3f::zeros(size), cv::Mat3f::zeros(size), cv::Mat3f::zeros(size)});
  }
  const Eigen::Vector3d origin = camera.PositionInWorld();
  constexpr double kOpaque = 1e-5;  // What is behind adds less than half-float precision
  ParallelRanges(
      size.height,
      4,
      [&](int row_begin, int row_end) {
        std::vector<Eigen::Array3d> sun(lights.size()), sky(lights.size()),
            indirect(lights.size());
        for (int row = row_begin; row < row_end; ++row) {
          for (int column = 0; column < size.width; ++column) {
            if (!mask.empty() && mask(row, column) == 0) continue;
            std::fill(sun.begin(), sun.end(), Eigen::Array3d::Zero());
            std::fill(sky.begin(), sky.end(), Eigen::Array3d::Zero());
            std::fill(indirect.begin(), indirect.end(), Eigen::Array3d::Zero());
            double tau = 1.0;

            // Front to back; tau (1 - exp(-d)) is the share of each voxel
            const Ray ray{origin, camera.RayInWorld({column + 0.5, row + 0.5})};
            TraverseRay(grid, ray, 0.0, [&](std::size_t cell, double, double length_m) {
              const int found = occupied.of_cell[cell];
              if (found < 0) return true;
              const auto voxel = static_cast<std::size_t>(found);
              const double share = -tau * std::expm1(-length_m * grid.sigma_per_m[cell]);
              for (std::size_t i = 0; i < lights.size(); ++i) {
                sun[i] += share * lights[i].sun[voxel].cast<double>();
                sky[i] += share * lights[i].sky[voxel].cast<double>();
                indirect[i] += share * lights[i].indirect[voxel].cast<double>();
              }
              tau -= share;
              return tau > kOpaque;
            });
            images.weight(row, column) = static_cast<float>(1 - tau);
            for (std::size_t i = 0; i < lights.size(); ++i) {
              images.lights[i].sun(row, column) = Pixel(sun[i]);
              images.lights[i].sky(row, column) = Pixel(sky[i]);
              images.lights[i].indirect(row, column) = Pixel(indirect[i]);
            }
          }
        }
      },
      progress);
  return images;
}

}  // namespace relight
