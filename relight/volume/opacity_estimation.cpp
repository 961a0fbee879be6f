// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/opacity_estimation.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/volume/densification.h"
#include "relight/volume/matte_agreement.h"
#include "relight/volume/projected_opacity.h"
#include "relight/volume/ray_traversal.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace relight {
namespace {

double ResidualRms(const ExtinctionGrid& grid, std::span<const MatteView> views) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const MatteView& view : views) {
    const cv::Mat1f opacity = RenderOpacity(grid, view.camera);
    for (int row = 0; row < opacity.rows; ++row) {
      for (int column = 0; column < opacity.cols; ++column) {
        if (view.alpha(row, column) <= 0.02f) continue;
        const double error = opacity(row, column) - view.alpha(row, column);
        sum += error * error;
        ++count;
      }
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

// Mean over a square of `side_px`, which need not be whole; beyond the frame there is 0.
cv::Mat1f BoxMean(const cv::Mat1f& image, double side_px) {
  const int reach = static_cast<int>(std::ceil((std::max(side_px, 1.0) - 1) / 2));
  cv::Mat1f kernel(1, 2 * reach + 1, 1.0f);
  if (reach > 0) {
    kernel(0, 0) = kernel(0, 2 * reach) =
        static_cast<float>((side_px - 1) / 2 - (reach - 1));
  }
  kernel /= cv::sum(kernel)[0];
  cv::Mat1f mean;
  cv::sepFilter2D(image, mean, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_CONSTANT);
  return mean;
}

}  // namespace

cv::Mat1f RenderOpacity(const ExtinctionGrid& grid, const Camera& camera) {
  cv::Mat1f opacity(camera.height_px, camera.width_px);
  const Eigen::Vector3d origin = camera.PositionInWorld();
  ParallelRanges(camera.height_px, 8, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < camera.width_px; ++column) {
        const Ray ray{origin, camera.RayInWorld({column + 0.5, row + 0.5})};
        opacity(row, column) = static_cast<float>(-std::expm1(-OpticalDepth(grid, ray)));
      }
    }
  });
  return opacity;
}

double MatteRmse(const ExtinctionGrid& grid, const MatteView& view, double footprint_m) {
  const double distance_m =
      (grid.Bounds().center() - view.camera.PositionInWorld()).norm();
  const double side_px = footprint_m * view.camera.focal_px.mean() / distance_m;
  cv::Mat1f apart;
  cv::subtract(RenderOpacity(grid, view.camera), view.alpha, apart);
  apart = BoxMean(apart, side_px);
  cv::Mat1b inside;
  cv::dilate(view.alpha > 0.02f, inside, cv::Mat1b(7, 7, std::uint8_t{1}));
  double sum = 0, count = 0;
  for (int row = 0; row < apart.rows; ++row) {
    for (int column = 0; column < apart.cols; ++column) {
      if (inside(row, column) == 0) continue;
      sum += apart(row, column) * apart(row, column);
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

OpacityEstimate EstimateOpacity(std::span<const MatteView> views,
                                const Eigen::AlignedBox3d& bounds_in_world,
                                const OpacityOptions& options,
                                const Progress& progress) {
  CheckFields(options);
  if (views.size() < 2) {
    throw InputError("opacity estimation needs two views or more, got " +
                     std::to_string(views.size()) +
                     "; one photo alone takes the silhouette volume");
  }
  const int kth_smallest =
      options.kth_smallest ? *options.kth_smallest : AgreementOf(views).kth_smallest;
  OpacityEstimate result;
  ExtinctionGrid& grid = result.grid;
  OpacitySummary& summary = result.summary;
  if (options.method == VolumeMethod::kReche2004) {
    summary.iterations = options.iterations.value_or(8);
    grid = ProjectedOpacity(views,
                            bounds_in_world,
                            {.cells = options.cells,
                             .iterations = summary.iterations,
                             .alpha_max = options.alpha_max,
                             .cutoff = options.cutoff,
                             .kth_smallest = kth_smallest},
                            progress);
  } else {
    summary.iterations = options.iterations.value_or(16);
    Tomography found = EstimateTomography(views,
                                          bounds_in_world,
                                          {.cells = options.cells,
                                           .passes = summary.iterations,
                                           .smoothness = options.smoothness,
                                           .leaf_spread = options.leaf_spread,
                                           .kth_smallest = kth_smallest},
                                          progress);
    grid = std::move(found.grid);
    summary.hidden_voxels = found.hidden_voxels;
    summary.views = std::move(found.views);
    summary.objective = std::move(found.objective);
  }
  for (float& sigma : grid.sigma_per_m) sigma *= static_cast<float>(options.scale);
  if (options.densify) summary.densified_voxels = Densify(grid);
  summary.occupied_voxels = static_cast<std::size_t>(
      std::count_if(grid.sigma_per_m.begin(), grid.sigma_per_m.end(), [](float sigma) {
        return sigma > 0;
      }));
  summary.residual_rms = ResidualRms(grid, views);
  return result;
}

}  // namespace relight
