// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/view_transport.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/sweep_kernels.h"
#include "relight/volume/ray_traversal.h"

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

constexpr int kRows = 4;          // A task
constexpr int kBlocks = 64;       // A task
constexpr double kOpaque = 1e-5;  // As SingleScattering
constexpr std::size_t kBlock = ViewTransport::kBlock;

// Puts colours into a new image, pixel after pixel of one task, and black between them:
// an image that is first made black would be gone through twice.
class PixelWriter {
 public:
  // The task's pixels are [first, ...) of view.pixel.
  PixelWriter(const ViewTransport& view, cv::Mat3f& image, std::size_t first)
      : out_(reinterpret_cast<cv::Vec3f*>(image.data)),
        at_(first == 0 ? 0 : static_cast<std::size_t>(view.pixel[first - 1]) + 1) {}

  void Write(std::size_t pixel, const cv::Vec3f& color) {
    std::fill(out_ + at_, out_ + pixel, cv::Vec3f());
    out_[pixel] = color;
    at_ = pixel + 1;
  }
  // After the last task's last pixel.
  void Finish(std::size_t pixels) { std::fill(out_ + at_, out_ + pixels, cv::Vec3f()); }

 private:
  cv::Vec3f* out_;
  std::size_t at_;
};

// What one task finds.
struct Rays {
  std::vector<std::int32_t> pixel, length, voxel;
  std::vector<float> weight, share, sky;  // sky: [pixel][bands^2]
};

}  // namespace

ViewTransport MakeViewTransport(const ExtinctionGrid& grid,
                                const OccupiedVoxels& occupied,
                                const SkyTransmittance& sky_transmittance,
                                const Camera& camera,
                                const cv::Mat1b& mask,
                                const Progress& progress) {
  ViewTransport view;
  view.size = {camera.width_px, camera.height_px};
  view.bands = sky_transmittance.bands;
  Require(mask.empty() || mask.size() == view.size, "the mask has the camera's size");
  Require(sky_transmittance.voxels == occupied.cell.size(),
          "the sky's transmittance belongs to this volume");

  // Coefficients of a voxel side by side, for a ray goes from voxel to voxel
  const std::size_t count = static_cast<std::size_t>(ShCount(view.bands));
  const std::size_t voxels = sky_transmittance.voxels;
  std::vector<float> one(voxels), of_voxel(voxels * count);
  for (std::size_t c = 0; c < count; ++c) {
    FromHalf(&sky_transmittance.half[c * voxels], one.data(), voxels);
    for (std::size_t v = 0; v < voxels; ++v) of_voxel[v * count + c] = one[v];
  }

  // Rays, by rows
  const Eigen::Vector3d origin = camera.PositionInWorld();
  const int tasks = (view.size.height + kRows - 1) / kRows;
  std::vector<Rays> found(static_cast<std::size_t>(tasks));
  ParallelRanges(
      tasks,
      1,
      [&](int begin, int end) {
        std::vector<float> g(count);
        for (int task = begin; task < end; ++task) {
          Rays& rays = found[static_cast<std::size_t>(task)];
          const int last = std::min(view.size.height, (task + 1) * kRows);
          for (int row = task * kRows; row < last; ++row) {
            for (int column = 0; column < view.size.width; ++column) {
              if (!mask.empty() && mask(row, column) == 0) continue;
              std::fill(g.begin(), g.end(), 0.0f);
              const std::size_t first = rays.voxel.size();
              double tau = 1.0;
              const Ray ray{origin, camera.RayInWorld({column + 0.5, row + 0.5})};
              TraverseRay(grid, ray, 0.0, [&](std::size_t cell, double, double length_m) {
                const int number = occupied.of_cell[cell];
                if (number < 0) return true;
                const double share =
                    -tau * std::expm1(-length_m * grid.sigma_per_m[cell]);
                const auto s = static_cast<float>(share);
                rays.voxel.push_back(number);
                rays.share.push_back(s);
                const float* c = &of_voxel[static_cast<std::size_t>(number) * count];
                for (std::size_t i = 0; i < count; ++i) g[i] += s * c[i];
                tau -= share;
                return tau > kOpaque;
              });
              if (rays.voxel.size() == first) continue;
              rays.pixel.push_back(row * view.size.width + column);
              rays.length.push_back(static_cast<std::int32_t>(rays.voxel.size() - first));
              rays.weight.push_back(static_cast<float>(1 - tau));
              rays.sky.insert(rays.sky.end(), g.begin(), g.end());
            }
          }
        }
      },
      progress);

  // One after another
  std::size_t pixels = 0, crossings = 0;
  for (const Rays& rays : found) {
    pixels += rays.pixel.size();
    crossings += rays.voxel.size();
  }
  view.pixel.reserve(pixels);
  view.weight.reserve(pixels);
  view.ray.reserve(pixels + 1);
  view.voxel.reserve(crossings);
  view.share.resize(crossings);
  view.ray.push_back(0);
  const std::size_t blocks = (pixels + kBlock - 1) / kBlock;
  std::vector<float> sky(blocks * count * kBlock, 0.0f);
  for (Rays& rays : found) {
    for (std::size_t p = 0; p < rays.pixel.size(); ++p) {
      const std::size_t at = view.pixel.size();
      for (std::size_t i = 0; i < count; ++i) {
        sky[(at / kBlock * count + i) * kBlock + at % kBlock] = rays.sky[p * count + i];
      }
      view.pixel.push_back(rays.pixel[p]);
      view.weight.push_back(rays.weight[p]);
      view.ray.push_back(view.ray.back() + static_cast<std::size_t>(rays.length[p]));
    }
    ToHalf(rays.share.data(), view.share.data() + view.voxel.size(), rays.share.size());
    view.voxel.insert(view.voxel.end(), rays.voxel.begin(), rays.voxel.end());
    rays = {};
  }
  view.sky.resize(sky.size());
  ToHalf(sky.data(), view.sky.data(), sky.size());
  return view;
}

cv::Mat3f SkyImage(const ViewTransport& view, const ShCoefficients& sky) {
  const std::size_t count = static_cast<std::size_t>(ShCount(view.bands));
  Require(static_cast<std::size_t>(sky.rows()) >= count, "a sky of the view's bands");
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> radiance =
      sky.cast<float>();
  if (view.pixel.empty()) return cv::Mat3f::zeros(view.size);
  cv::Mat3f image(view.size);
  const std::size_t blocks = (view.pixel.size() + kBlock - 1) / kBlock;
  ParallelRanges(static_cast<int>(blocks), kBlocks, [&](int begin, int end) {
    float colors[3 * kBlock];
    PixelWriter writer(view, image, static_cast<std::size_t>(begin) * kBlock);
    for (auto block = static_cast<std::size_t>(begin);
         block < static_cast<std::size_t>(end);
         ++block) {
      const std::size_t first = block * kBlock;
      const std::size_t size = std::min(kBlock, view.pixel.size() - first);
      ColorProduct(
          &view.sky[first * count], kBlock, radiance.data(), count, colors, size);
      for (std::size_t p = 0; p < size; ++p) {
        writer.Write(static_cast<std::size_t>(view.pixel[first + p]),
                     {colors[3 * p], colors[3 * p + 1], colors[3 * p + 2]});
      }
    }
    if (static_cast<std::size_t>(end) == blocks) writer.Finish(image.total());
  });
  return image;
}

cv::Mat3f SunImage(const ViewTransport& view,
                   std::span<const float> sun_transmittance,
                   const Eigen::Array3d& sun_irradiance) {
  if (view.pixel.empty()) return cv::Mat3f::zeros(view.size);
  cv::Mat3f image(view.size);
  const Eigen::Array3f sun = sun_irradiance.cast<float>();
  ParallelRanges(
      static_cast<int>(view.pixel.size()), kBlocks * kBlock, [&](int begin, int end) {
        PixelWriter writer(view, image, static_cast<std::size_t>(begin));
        for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end);
             ++p) {
          const float lit = SharedSum(&view.share[view.ray[p]],
                                      &view.voxel[view.ray[p]],
                                      view.ray[p + 1] - view.ray[p],
                                      sun_transmittance.data());
          writer.Write(static_cast<std::size_t>(view.pixel[p]),
                       {sun[0] * lit, sun[1] * lit, sun[2] * lit});
        }
        if (static_cast<std::size_t>(end) == view.pixel.size())
          writer.Finish(image.total());
      });
  return image;
}

}  // namespace relight
