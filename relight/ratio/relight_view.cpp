// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/relight_view.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace relight {
namespace {

// Edge of a voxel at the volume's centre, in pixels of `camera`.
double VoxelPixels(const ExtinctionGrid& grid, const Camera& camera) {
  const double distance_m = (grid.Bounds().center() - camera.PositionInWorld()).norm();
  return camera.focal_px.mean() * grid.cell_m / distance_m;
}

// M' of (R2), 0 outside the matte.
cv::Mat3f MeanInside(const ViewLight& light, const IrradianceImage& image) {
  return MeanLight(image.Total(),
                   light.images.weight,
                   light.inside,
                   {.smoothing_px = light.smoothing_px});
}

// Enlarging reads a pixel or two beyond the matte's edge: the light goes on there.
cv::Mat3f Continued(const ViewLight& light, const cv::Mat3f& mean) {
  if (!light.is_smaller) return mean;
  cv::Mat1f known(mean.size(), 0.0f);
  known.setTo(1.0f, light.inside);
  return MeanLight(mean, known, cv::Mat1b(mean.size(), 255));
}

}  // namespace

ViewLight LightOfView(const ExtinctionGrid& grid,
                      const OccupiedVoxels& occupied,
                      const ArrivingLight& input,
                      const ArrivingLight& target,
                      const Camera& camera,
                      const cv::Mat1f& alpha,
                      const RelightViewOptions& options,
                      const Progress& progress) {
  Require(alpha.cols == camera.width_px && alpha.rows == camera.height_px,
          "the matte has the camera's size");

  // No finer than the voxels can show; 25 % are not worth a second resampling
  const double voxel_px = VoxelPixels(grid, camera);
  const double shrink = std::max(1.0, voxel_px / options.pixels_per_voxel);
  ViewLight light;
  light.camera = camera;
  cv::Mat1f small_alpha = alpha;
  light.is_smaller = shrink > 1.25;
  if (light.is_smaller) {
    light.camera =
        camera.Resized(std::max(1, static_cast<int>(std::lround(alpha.cols / shrink))),
                       std::max(1, static_cast<int>(std::lround(alpha.rows / shrink))));
    cv::resize(alpha,
               small_alpha,
               {light.camera.width_px, light.camera.height_px},
               0,
               0,
               cv::INTER_AREA);
  }

  light.inside = small_alpha > 0.004f;
  // Light that is enlarged must not show its voxels' edges
  if (light.is_smaller || options.smooth)
    light.smoothing_px = 0.5 * VoxelPixels(grid, light.camera);
  const std::array<ArrivingLight, 2> lights = {input, target};
  light.images =
      SingleScattering(grid, occupied, lights, light.camera, light.inside, progress);
  const cv::Mat3f input_mean = MeanInside(light, light.images.lights[0]);
  light.floor = RatioFloor(input_mean, options.ratio);
  light.input_light = Continued(light, input_mean);
  light.target_light = Continued(light, MeanInside(light, light.images.lights[1]));

  const cv::Mat1b solid = small_alpha > 0.5f;
  const int solid_count = cv::countNonZero(solid);
  if (solid_count > 0) {
    const cv::Mat weak = solid & (light.images.weight < 0.001f);
    light.weak_share = static_cast<double>(cv::countNonZero(weak)) / solid_count;
  }
  return light;
}

ViewLight UnderTarget(const ViewLight& light,
                      const ExtinctionGrid& grid,
                      const OccupiedVoxels& occupied,
                      const ArrivingLight& target,
                      const Progress& progress) {
  ViewLight other = light;
  ScatteringImages images = SingleScattering(
      grid, occupied, {&target, 1}, light.camera, light.inside, progress);
  other.images.lights[1] = std::move(images.lights[0]);
  other.target_light = Continued(other, MeanInside(other, other.images.lights[1]));
  return other;
}

namespace {

cv::Mat3f SimulatedRatioRows(const ViewLight& light,
                             cv::Size full_size,
                             int row_begin,
                             int row_end) {
  const cv::Size small = light.input_light.size();
  if (small == full_size) {
    return RatioImage(light.input_light.rowRange(row_begin, row_end),
                      light.target_light.rowRange(row_begin, row_end),
                      light.floor);
  }
  // Bilinear, pixel centres at +0.5, as one map for both hours
  const double scale_x = static_cast<double>(small.width) / full_size.width;
  const double scale_y = static_cast<double>(small.height) / full_size.height;
  cv::Mat2f map(row_end - row_begin, full_size.width);
  for (int row = row_begin; row < row_end; ++row) {
    for (int column = 0; column < full_size.width; ++column) {
      map(row - row_begin, column) = {static_cast<float>((column + 0.5) * scale_x - 0.5),
                                      static_cast<float>((row + 0.5) * scale_y - 0.5)};
    }
  }
  cv::Mat3f input, target;
  cv::remap(light.input_light,
            input,
            map,
            cv::noArray(),
            cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  cv::remap(light.target_light,
            target,
            map,
            cv::noArray(),
            cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  return RatioImage(input, target, light.floor);
}

}  // namespace

cv::Mat3f RatioRows(const ViewLight& light,
                    cv::Size full_size,
                    int row_begin,
                    int row_end) {
  cv::Mat3f ratio = SimulatedRatioRows(light, full_size, row_begin, row_end);
  const Correction& correction = light.correction;
  if (correction.log_factor.empty()) return ratio;
  const cv::Mat1f log_factor = PatchRows(
      correction.grid, correction.log_factor, full_size.width, row_begin, row_end);
  for (int row = 0; row < ratio.rows; ++row) {
    for (int column = 0; column < ratio.cols; ++column) {
      ratio(row, column) *= std::exp(log_factor(row, column));
    }
  }
  return ratio;
}

cv::Mat3f ApplyRatio(const ViewLight& light,
                     const cv::Mat3f& colors,
                     double gain,
                     const Progress& progress) {
  cv::Mat3f relit(colors.size());
  ParallelRanges(
      colors.rows,
      64,
      [&](int begin, int end) {
        const cv::Mat3f ratio = RatioRows(light, colors.size(), begin, end);
        const auto scale = static_cast<float>(gain);
        for (int row = begin; row < end; ++row) {
          for (int column = 0; column < colors.cols; ++column) {
            const cv::Vec3f& color = colors(row, column);
            const cv::Vec3f& r = ratio(row - begin, column);
            for (int c = 0; c < 3; ++c) {
              const float value = color[c] * r[c] * scale;
              relit(row, column)[c] = value > 0 ? value : 0.0f;  // NaN too
            }
          }
        }
      },
      progress);
  return relit;
}

}  // namespace relight
