// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/footprint_opacity.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

constexpr double kEmptyBorder = 0.02;  // Of the frame: the tree is not cut off there

// Mean of the pixels in [x0, x1] x [y0, y1] (pixel edges, fractions counted by area) from
// the table of sums.
double MeanOf(const cv::Mat1d& sums, double x0, double y0, double x1, double y1) {
  const double width = sums.cols - 1, height = sums.rows - 1;
  x0 = std::clamp(x0, 0.0, width);
  x1 = std::clamp(x1, 0.0, width);
  y0 = std::clamp(y0, 0.0, height);
  y1 = std::clamp(y1, 0.0, height);
  const double area = (x1 - x0) * (y1 - y0);
  if (area <= 0) return 0;
  // Sum over [0, x] x [0, y]: bilinear between the table's corners
  const auto sum_to = [&](double x, double y) {
    const int ix = std::min(static_cast<int>(x), sums.cols - 2);
    const int iy = std::min(static_cast<int>(y), sums.rows - 2);
    const double fx = x - ix, fy = y - iy;
    return (1 - fy) * ((1 - fx) * sums(iy, ix) + fx * sums(iy, ix + 1)) +
           fy * ((1 - fx) * sums(iy + 1, ix) + fx * sums(iy + 1, ix + 1));
  };
  return (sum_to(x1, y1) - sum_to(x0, y1) - sum_to(x1, y0) + sum_to(x0, y0)) / area;
}

}  // namespace

void RequireUsable(std::span<const MatteView> views) {
  for (const MatteView& view : views) {
    if (view.alpha.cols != view.camera.width_px ||
        view.alpha.rows != view.camera.height_px) {
      throw InputError(view.name + ": the matte is " + std::to_string(view.alpha.cols) +
                       " x " + std::to_string(view.alpha.rows) + " pixels, the camera " +
                       std::to_string(view.camera.width_px) + " x " +
                       std::to_string(view.camera.height_px) +
                       "; make the matte at the photo's size");
    }
    double low = 0, high = 0;
    cv::minMaxLoc(view.alpha, &low, &high);
    if (!(low >= 0 && high <= 1) || !cv::checkRange(view.alpha)) {
      throw InputError(view.name + ": the matte has values outside 0 to 1");
    }
  }
}

namespace {

// Of the voxel (x, y, z); `means` is room to work in.
float OpacityOf(const Eigen::Vector3d& center,
                double cell_m,
                std::span<const MatteView> views,
                const std::vector<cv::Mat1d>& sums,
                std::size_t kth_smallest,
                std::vector<double>& means) {
  const Eigen::Vector2d edge(0.5, 0.5);
  means.clear();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = views[v].camera;
    const auto seen = camera.Project(center);
    if (!seen) continue;
    // Beyond the frame a matte goes on as at its border: empty stays empty, of a tree
    // that is cut off nothing is known
    const Eigen::Vector2d frame(camera.width_px, camera.height_px);
    const Eigen::Vector2d at = seen->cwiseMax(0.5).cwiseMin(frame - edge);
    // A cube seen from afar covers about the square of its edge
    const double depth_m = (camera.camera_from_world * center).z();
    const Eigen::Vector2d half = 0.5 * cell_m / depth_m * camera.focal_px;
    const double mean = MeanOf(sums[v],
                               at.x() - half.x(),
                               at.y() - half.y(),
                               at.x() + half.x(),
                               at.y() + half.y());
    if (at == *seen || mean < kEmptyBorder) means.push_back(mean);
  }
  if (means.empty()) return 0.0f;
  std::sort(means.begin(), means.end());
  const std::size_t k = kth_smallest <= means.size() ? kth_smallest - 1 : 0;
  return static_cast<float>(std::clamp(means[k], 0.0, 1.0));
}

}  // namespace

Footprints FootprintOpacity(const BrickVoxels& box,
                            std::span<const MatteView> views,
                            const FootprintOptions& options,
                            const Progress& progress) {
  RequireUsable(views);
  if (options.kth_smallest < 1) {
    throw OptionError("kth-smallest must be >= 1, got " +
                      std::to_string(options.kth_smallest));
  }
  std::vector<cv::Mat1d> sums(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    cv::integral(views[v].alpha, sums[v], CV_64F);
  }

  // Slabs of whole bricks are found one after another, and put into bricks
  constexpr int kSlab = 4 * BrickVoxels::kEdge;
  Footprints found{NoBricks(box.cells, box.origin_m, box.cell_m), {}};
  const auto columns = static_cast<std::size_t>(box.cells.x());
  const std::size_t layer = columns * static_cast<std::size_t>(box.cells.y());
  std::vector<float> slab(layer * static_cast<std::size_t>(kSlab));
  for (int low = 0; low < box.cells.z(); low += kSlab) {
    const int layers = std::min(kSlab, box.cells.z() - low);
    ParallelRanges(
        layers,
        1,
        [&](int begin, int end) {
          std::vector<double> means;
          for (int z = begin; z < end; ++z) {
            float* opacity = &slab[static_cast<std::size_t>(z) * layer];
            for (int y = 0; y < box.cells.y(); ++y) {
              for (int x = 0; x < box.cells.x(); ++x, ++opacity) {
                *opacity = OpacityOf(box.Center(x, y, low + z),
                                     box.cell_m,
                                     views,
                                     sums,
                                     static_cast<std::size_t>(options.kth_smallest),
                                     means);
              }
            }
          }
        },
        progress.Part(1.0 * low / box.cells.z(), 1.0 * (low + layers) / box.cells.z()));
    const float* opacity = slab.data();
    for (int z = low; z < low + layers; ++z) {
      for (int y = 0; y < box.cells.y(); ++y) {
        for (int x = 0; x < box.cells.x(); ++x, ++opacity) {
          if (*opacity <= 0 || *opacity < options.least_alpha) continue;
          const std::size_t index = found.voxels.Make(x, y, z);
          found.opacity.resize(found.voxels.Size(), 0.0f);
          found.opacity[index] = *opacity;
        }
      }
    }
  }
  return found;
}

}  // namespace relight
