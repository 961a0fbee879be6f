// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/projected_opacity.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/volume/ray_traversal.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace relight {
namespace {

constexpr float kMinTransparency =
    1e-4f;  // An opaque cell: a logarithm needs more than 0.

// The part of one pass that falls on one strip of one matte. Strips are summed in their
// order, so that threads change nothing.
struct Strip {
  std::size_t view = 0;
  int row_begin = 0, row_end = 0;
  std::vector<double> movement, weight;  // Per occupied cell: sums of delta_i and w_i.
};

std::vector<Strip> MakeStrips(std::span<const MatteView> views) {
  constexpr int kStripsPerView = 3;
  std::vector<Strip> strips;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const int rows = views[v].camera.height_px;
    for (int s = 0; s < kStripsPerView; ++s) {
      strips.push_back(
          {v, rows * s / kStripsPerView, rows * (s + 1) / kStripsPerView, {}, {}});
    }
  }
  return strips;
}

// Where along each pixel's ray non-empty voxels can be: nearest and farthest distance [m]
// of the spheres around them; near > far where there is none.
struct RaySpans {
  cv::Mat1f near_m, far_m;
};

RaySpans SpansOf(const ExtinctionGrid& grid,
                 const OccupiedVoxels& occupied,
                 const Camera& camera) {
  const cv::Size size(camera.width_px, camera.height_px);
  RaySpans spans{cv::Mat1f(size, 1e30f), cv::Mat1f(size, -1.0f)};
  const Eigen::Vector3d eye = camera.PositionInWorld();
  const double radius_m = 0.87 * grid.cell_m;  // sqrt(3) / 2 and a little
  for (const Eigen::Vector3i& cell : occupied.cell) {
    const Eigen::Vector3d center = grid.Center(cell.x(), cell.y(), cell.z());
    const auto at = camera.Project(center);
    const double distance_m = (center - eye).norm();
    if (!at || distance_m <= 2 * radius_m) continue;
    const double depth_m = (camera.camera_from_world * center).z() - radius_m;
    const Eigen::Vector2d reach =
        (camera.focal_px * radius_m / std::max(depth_m, radius_m)).array() + 1.0;
    const int left = std::max(0, static_cast<int>(std::floor(at->x() - reach.x())));
    const int right =
        std::min(size.width - 1, static_cast<int>(std::ceil(at->x() + reach.x())));
    const int top = std::max(0, static_cast<int>(std::floor(at->y() - reach.y())));
    const int bottom =
        std::min(size.height - 1, static_cast<int>(std::ceil(at->y() + reach.y())));
    const auto near_m = static_cast<float>(distance_m - radius_m);
    const auto far_m = static_cast<float>(distance_m + radius_m);
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) {
        spans.near_m(row, column) = std::min(spans.near_m(row, column), near_m);
        spans.far_m(row, column) = std::max(spans.far_m(row, column), far_m);
      }
    }
  }
  return spans;
}

struct Crossing {
  int occupied;
  float weight;
};

// Project each pixel's cells onto its plane. [Reche04, Eq. 9, Eq. 13]
void MoveStrip(const ExtinctionGrid& grid,
               const MatteView& view,
               const RaySpans& spans,
               const OccupiedVoxels& occupied,
               const std::vector<float>& transparency,
               const std::vector<float>& log_transparency,
               const ProjectedOpacityOptions& options,
               Strip& strip) {
  strip.movement.assign(occupied.cell.size(), 0.0);
  strip.weight.assign(occupied.cell.size(), 0.0);
  const Eigen::Vector3d origin = view.camera.PositionInWorld();
  const double pixel_area = 1.0 / view.camera.focal_px.prod();
  const double cell_volume_m3 = std::pow(grid.cell_m, 3);
  std::vector<Crossing> crossed;
  for (int row = strip.row_begin; row < strip.row_end; ++row) {
    for (int column = 0; column < view.camera.width_px; ++column) {
      const double near_m = spans.near_m(row, column), far_m = spans.far_m(row, column);
      if (near_m > far_m) continue;
      const Ray ray{origin, view.camera.RayInWorld({column + 0.5, row + 0.5})};

      // Collect the non-empty cells and their weights [Reche04 App. A]
      crossed.clear();
      double q_sum = 0.0;
      TraverseRay(
          grid, ray, near_m, [&](std::size_t voxel, double entry_m, double length_m) {
            const int cell = occupied.of_cell[voxel];
            if (cell < 0) return entry_m < far_m;
            const double distance_m = entry_m + length_m / 2;
            crossed.push_back({cell,
                               static_cast<float>(length_m * distance_m * distance_m *
                                                  pixel_area / cell_volume_m3)});
            q_sum += log_transparency[static_cast<std::size_t>(cell)];
            return true;
          });
      if (crossed.empty()) continue;

      // Step to the plane, back to transparencies, and accumulate the movement
      const double alpha = std::min<double>(view.alpha(row, column), options.alpha_max);
      const double shift =
          (std::log(1 - alpha) - q_sum) / static_cast<double>(crossed.size());
      const double factor = std::exp(shift);
      for (const Crossing& c : crossed) {
        const auto cell = static_cast<std::size_t>(c.occupied);
        const double moved =
            std::min(transparency[cell] * factor, 1.0);  // Nothing shines
        strip.movement[cell] += c.weight * (moved - transparency[cell]);
        strip.weight[cell] += c.weight;
      }
    }
  }
}

}  // namespace

ExtinctionGrid ProjectedOpacity(std::span<const MatteView> views,
                                const Eigen::AlignedBox3d& bounds_in_world,
                                const ProjectedOpacityOptions& options,
                                const Progress& progress) {
  // Start from the footprints; what any matte calls empty stays so
  Footprints start = FootprintOpacity(EmptyGrid(bounds_in_world, options.cells),
                                      views,
                                      {.kth_smallest = options.kth_smallest},
                                      progress.Part(0.0, 0.1));
  ExtinctionGrid grid{std::move(start.voxels), std::move(start.opacity)};
  OccupiedVoxels occupied = FindOccupied(grid);
  std::vector<float> transparency;
  for (const Eigen::Vector3i& at : occupied.cell) {
    const float alpha = grid.At(at.x(), at.y(), at.z());
    transparency.push_back(std::max(
        1 - std::min(alpha, static_cast<float>(options.alpha_max)), kMinTransparency));
  }

  std::vector<Strip> strips = MakeStrips(views);
  for (int pass = 0; pass < options.iterations; ++pass) {
    std::vector<float> log_transparency(transparency.size());
    std::transform(
        transparency.begin(), transparency.end(), log_transparency.begin(), [](float t) {
          return std::log(t);
        });
    std::vector<RaySpans> spans(views.size());
    ParallelRanges(static_cast<int>(views.size()), 1, [&](int begin, int end) {
      for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
           ++v) {
        spans[v] = SpansOf(grid, occupied, views[v].camera);
      }
    });
    const double from = 0.1 + 0.9 * pass / options.iterations;
    ParallelRanges(
        static_cast<int>(strips.size()),
        1,
        [&](int begin, int end) {
          for (int s = begin; s < end; ++s) {
            Strip& strip = strips[static_cast<std::size_t>(s)];
            MoveStrip(grid,
                      views[strip.view],
                      spans[strip.view],
                      occupied,
                      transparency,
                      log_transparency,
                      options,
                      strip);
          }
        },
        progress.Part(from, from + 0.9 / options.iterations));

    // Move each cell by its mean, and empty what is clearer than the cutoff
    std::size_t kept = 0;
    OccupiedVoxels left;
    left.of_cell.assign(grid.Size(), -1);
    for (std::size_t cell = 0; cell < occupied.cell.size(); ++cell) {
      double movement = 0.0, weight = 0.0;
      for (const Strip& strip : strips) {
        movement += strip.movement[cell];
        weight += strip.weight[cell];
      }
      const double moved = transparency[cell] + (weight > 0 ? movement / weight : 0.0);
      if (moved > options.cutoff || weight == 0) continue;
      const Eigen::Vector3i& at = occupied.cell[cell];
      left.of_cell[grid.Index(at.x(), at.y(), at.z())] = static_cast<int>(kept);
      left.cell.push_back(at);
      transparency[kept++] = std::max(static_cast<float>(moved), kMinTransparency);
    }
    transparency.resize(kept);
    occupied = std::move(left);
  }
  if (occupied.cell.empty()) {
    throw InputError(
        "nothing is left of the tree in the volume: the mattes contradict each other; "
        "check that "
        "cameras and mattes belong to the same photos, or forgive bad mattes with "
        "--kth-smallest 3");
  }

  // Transparency to extinction (V1)
  std::fill(grid.sigma_per_m.begin(), grid.sigma_per_m.end(), 0.0f);
  for (std::size_t cell = 0; cell < occupied.cell.size(); ++cell) {
    const Eigen::Vector3i& at = occupied.cell[cell];
    grid.sigma_per_m[grid.Index(at.x(), at.y(), at.z())] =
        static_cast<float>(-std::log(transparency[cell]) / grid.cell_m);
  }
  grid.DropEmptyBricks();
  return grid;
}

}  // namespace relight
