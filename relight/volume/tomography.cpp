// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/tomography.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/volume/brick_voxels.h"
#include "relight/volume/ray_traversal.h"

#include <opencv2/imgproc.hpp>

#include <array>
#include <numeric>

namespace relight {
namespace {

constexpr int kCoarsestCells = 20;
constexpr double kRayPitch = 0.66;       // Of a voxel.
constexpr double kPriorWeight = 2.0;     // kappa of (V3), measured (docs/validation.md).
constexpr float kEdgeSoftness = 0.005f;  // epsilon of (V3).
constexpr double kEmptyFootprint = 0.02;
constexpr float kEmptyDepth = 0.002f;  // Optical depth of a voxel that is dropped.
constexpr float kShare = 0.02f;        // delta of the surrogate: lets empty voxels fill.

// --- Rays ---------------------------------------------------------------------------

struct MatteRay {
  float column, row;  // [px] of the view's reduced camera.
  float alpha;
  float weight;      // a_v q_p of (V3).
  float length = 0;  // In voxels that may hold tree, in their edges.
};

struct RayView {
  Camera camera;
  Eigen::Vector3d eye;  // In voxel edges from the box's lower corner, as the rays are.
  double weight = 1;
  std::vector<MatteRay> rays;  // Those that meet such a voxel.

  Ray At(const MatteRay& ray) const {
    return {eye, camera.RayInWorld({ray.column, ray.row})};
  }
};

struct Level {
  BrickVoxels frame;   // The box alone.
  BrickVoxels voxels;  // Those of it that may hold tree, with their edge as the unit.
  std::vector<std::uint8_t> may_hold_tree;  // Per value; the others stay 0.
  std::vector<float> depth;                 // s of (V3).
  std::vector<RayView> views;
};

// The matte averaged over squares of kRayPitch voxels, or as it is where it is coarser.
RayView RaysOf(const MatteView& view, const Level& level, double leaf_spread) {
  const BrickVoxels& frame = level.frame;
  const Eigen::Vector3d middle =
      frame.origin_m + frame.cell_m / 2 * frame.cells.cast<double>();
  const double distance_m = (middle - view.camera.PositionInWorld()).norm();
  const double pixel_m = distance_m / view.camera.focal_px.mean();
  const double shrink = std::max(1.0, kRayPitch * frame.cell_m / pixel_m);
  const cv::Size size(
      std::max(1, static_cast<int>(std::lround(view.alpha.cols / shrink))),
      std::max(1, static_cast<int>(std::lround(view.alpha.rows / shrink))));
  cv::Mat1f alpha = view.alpha;
  if (size != alpha.size()) cv::resize(view.alpha, alpha, size, 0, 0, cv::INTER_AREA);
  RayView result;
  result.camera = view.camera.Resized(size.width, size.height);
  result.eye = (result.camera.PositionInWorld() - frame.origin_m) / frame.cell_m;
  const Eigen::Vector2d edge = distance_m / frame.cell_m / result.camera.focal_px.array();
  const auto area = static_cast<float>(edge.prod());
  const auto weight_of = [&, c = static_cast<float>(leaf_spread)](float a) {
    constexpr float kUsualSpread = 0.12f;  // Of a crown: the prior keeps its weight
    return c > 0 ? area * (kUsualSpread + c) / (a * (1 - a) + c) : area;
  };

  std::vector<std::vector<MatteRay>> of_row(static_cast<std::size_t>(size.height));
  ParallelRanges(size.height, 4, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < size.width; ++column) {
        MatteRay ray{static_cast<float>(column) + 0.5f,
                     static_cast<float>(row) + 0.5f,
                     alpha(row, column),
                     weight_of(alpha(row, column))};
        TraverseRay(
            level.voxels, result.At(ray), 0.0, [&](std::size_t at, double, double edges) {
              if (level.may_hold_tree[at] != 0) ray.length += static_cast<float>(edges);
              return true;
            });
        if (ray.length > 0) of_row[static_cast<std::size_t>(row)].push_back(ray);
      }
    }
  });
  for (const auto& rays : of_row) {
    result.rays.insert(result.rays.end(), rays.begin(), rays.end());
  }
  return result;
}

// --- One resolution -------------------------------------------------------------------

struct Fit {
  double sum = 0;      // w_v a_v q_p e^2 over all rays.
  double squares = 0;  // e^2 over the rays where there is tree,
  double rays = 0;     // and how many these are.
  std::uint64_t crossings = 0;
};

// For each voxel i the sums over all rays of l_pi times the ray's two coefficients, and
// how the mattes are met. Rays are dealt to a fixed number of sums, which are added in
// their order: threads change nothing.
using PerVoxel = std::array<float, 2>;
template <class Coefficients>
std::vector<PerVoxel> BackProject(const Level& level,
                                  const std::vector<float>& depth,
                                  Coefficients coefficients,
                                  std::vector<Fit>& fits,
                                  const Progress& progress) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 29;
  const std::size_t size = level.voxels.Size();
  const std::size_t sums = std::clamp<std::size_t>(
      kMostBytes / (sizeof(PerVoxel) * std::max<std::size_t>(size, 1)), 2, 8);
  constexpr std::size_t kBlock = 64;  // Rays that lie together
  std::vector<std::vector<PerVoxel>> parts(sums);
  std::vector<std::vector<Fit>> part_fits(sums, std::vector<Fit>(level.views.size()));
  const auto project = [&](std::size_t s) {
    struct Crossing {
      std::size_t at;
      float length;
    };
    std::vector<Crossing> crossed;
    std::vector<PerVoxel>& part = parts[s];
    part.assign(size, {});
    for (std::size_t v = 0; v < level.views.size(); ++v) {
      const RayView& view = level.views[v];
      Fit& fit = part_fits[s][v];
      for (std::size_t i = s * kBlock; i < view.rays.size(); ++i) {
        if (i % kBlock == 0 && i / kBlock % sums != s) i += (sums - 1) * kBlock;
        if (i >= view.rays.size()) break;
        const MatteRay& ray = view.rays[i];
        crossed.clear();
        float sum = 0;
        TraverseRay(
            level.voxels, view.At(ray), 0.0, [&](std::size_t at, double, double edges) {
              const auto length = static_cast<float>(edges);
              sum += length * depth[at];
              crossed.push_back({at, length});
              return true;
            });
        fit.crossings += crossed.size();
        const float transmittance = std::exp(-sum);
        const float error = 1 - transmittance - ray.alpha;
        fit.sum += view.weight * ray.weight * error * error;
        if (ray.alpha > 0.02f || transmittance < 0.98f) {
          fit.squares += error * error;
          fit.rays += 1;
        }
        const PerVoxel c = coefficients(view, ray, transmittance);
        for (const Crossing& crossing : crossed) {
          part[crossing.at][0] += c[0] * crossing.length;
          part[crossing.at][1] += c[1] * crossing.length;
        }
      }
    }
  };
  ParallelRanges(
      static_cast<int>(sums),
      1,
      [&](int begin, int end) {
        for (int s = begin; s < end; ++s) project(static_cast<std::size_t>(s));
      },
      progress);
  fits.assign(level.views.size(), {});
  for (const auto& part : part_fits) {
    for (std::size_t v = 0; v < fits.size(); ++v) {
      fits[v].sum += part[v].sum;
      fits[v].squares += part[v].squares;
      fits[v].rays += part[v].rays;
      fits[v].crossings += part[v].crossings;
    }
  }
  std::vector<PerVoxel> total = std::move(parts[0]);
  const int bricks = static_cast<int>(level.voxels.brick_at.size());
  ParallelRanges(bricks, 64, [&](int begin, int end) {
    const std::size_t from = static_cast<std::size_t>(begin) * BrickVoxels::kPerBrick;
    const std::size_t to = static_cast<std::size_t>(end) * BrickVoxels::kPerBrick;
    for (std::size_t s = 1; s < sums; ++s) {
      for (std::size_t i = from; i < to; ++i) {
        total[i][0] += parts[s][i][0];
        total[i][1] += parts[s][i][1];
      }
    }
  });
  return total;
}

// Gradient of the mattes' part of (V3), and curvature of its separable surrogate times
// the voxel's share s + kShare: a step falls on voxels by what they hold, a choice of the
// weights of separable surrogates [Erdogan99].
PerVoxel DataSurrogate(const RayView& view, const MatteRay& ray, float transmittance) {
  const float scale = 2 * static_cast<float>(view.weight) * ray.weight;
  const float shares = -std::log(std::max(transmittance, 1e-6f)) + kShare * ray.length;
  return {scale * (1 - transmittance - ray.alpha) * transmittance,
          scale * shares * std::max(transmittance * transmittance, 0.01f)};
}

// Adds gradient and surrogate curvature of weight x TV, and answers weight x TV.
double AddPrior(const BrickVoxels& voxels,
                const std::vector<float>& depth,
                float weight,
                std::vector<PerVoxel>& surrogate) {
  const int count = static_cast<int>(voxels.brick_at.size());
  std::vector<double> values(static_cast<std::size_t>(count));
  ParallelRanges(count, 16, [&](int begin, int end) {
    constexpr int kTile = 10;  // A brick and one voxel around it
    constexpr int kX = 1, kY = kTile, kZ = kTile * kTile;
    std::array<float, kTile * kTile * kTile> s{}, inverse{};
    for (int b = begin; b < end; ++b) {
      const Eigen::Vector3i& low = voxels.brick_at[static_cast<std::size_t>(b)];
      std::size_t i = 0;
      for (int z = -1; z <= 8; ++z) {
        for (int y = -1; y <= 8; ++y) {
          for (int x = -1; x <= 8; ++x, ++i) {
            const auto at = voxels.Find(low.x() + x, low.y() + y, low.z() + z);
            s[i] = at < 0 ? 0.0f : depth[static_cast<std::size_t>(at)];
          }
        }
      }
      // 1 / sqrt(|grad|^2 + epsilon^2) of the brick's voxels and those below them
      double value = 0;
      for (int z = 0; z < 9; ++z) {
        for (int y = 0; y < 9; ++y) {
          for (int x = 0; x < 9; ++x) {
            const auto at = static_cast<std::size_t>(z * kZ + y * kY + x);
            const float dx = s[at + kX] - s[at], dy = s[at + kY] - s[at],
                        dz = s[at + kZ] - s[at];
            const float norm =
                std::sqrt(dx * dx + dy * dy + dz * dz + kEdgeSoftness * kEdgeSoftness);
            inverse[at] = weight / norm;
            if (x > 0 && y > 0 && z > 0) value += norm - kEdgeSoftness;
          }
        }
      }
      values[static_cast<std::size_t>(b)] = weight * value;
      std::size_t to = static_cast<std::size_t>(b) * BrickVoxels::kPerBrick;
      for (int z = 1; z < 9; ++z) {
        for (int y = 1; y < 9; ++y) {
          for (int x = 1; x < 9; ++x, ++to) {
            const auto at = static_cast<std::size_t>(z * kZ + y * kY + x);
            const float here = 3 * inverse[at];
            const float below_x = inverse[at - kX], below_y = inverse[at - kY],
                        below_z = inverse[at - kZ];
            surrogate[to][0] +=
                inverse[at] * (3 * s[at] - s[at + kX] - s[at + kY] - s[at + kZ]) +
                below_x * (s[at] - s[at - kX]) + below_y * (s[at] - s[at - kY]) +
                below_z * (s[at] - s[at - kZ]);
            surrogate[to][1] += 2 * (here + below_x + below_y + below_z);
          }
        }
      }
    }
  });
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// The bricks of all voxels whose k-th smallest footprint is not empty, and that are not
// far from what the coarser resolution holds; its values, interpolated, are the start.
Level MakeLevel(const BrickVoxels& frame,
                std::span<const MatteView> views,
                const TomographyOptions& options,
                const Level* coarser,
                const Progress& progress) {
  Level level;
  level.frame = frame;
  level.voxels = NoBricks(frame.cells, Eigen::Vector3d::Zero(), 1.0);
  const auto coarse_at = [&](const Eigen::Vector3d& at) -> std::array<float, 2> {
    // Value between the eight centres around, and the largest of them
    const BrickVoxels& from = coarser->frame;
    const Eigen::Vector3d cell =
        (at - from.origin_m) / from.cell_m - Eigen::Vector3d::Constant(0.5);
    const Eigen::Vector3i low = cell.array().floor().cast<int>();
    float value = 0, most = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3i c =
          low + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
      const auto found = coarser->voxels.Find(c.x(), c.y(), c.z());
      if (found < 0) continue;
      const float s = coarser->depth[static_cast<std::size_t>(found)];
      const Eigen::Array3d share = 1 - (cell - c.cast<double>()).array().abs();
      value += s * static_cast<float>(share.prod());
      most = std::max(most, s);
    }
    const auto ratio = static_cast<float>(frame.cell_m / from.cell_m);
    return {value * ratio, most * ratio};
  };
  const Footprints footprints = FootprintOpacity(
      frame,
      views,
      {.kth_smallest = options.kth_smallest, .least_alpha = kEmptyFootprint},
      progress);
  ForEachVoxel(footprints.voxels, [&](int x, int y, int z, std::size_t index) {
    if (footprints.opacity[index] == 0) return;
    float start = static_cast<float>(0.5 * frame.cell_m);  // A usual crown's
    if (coarser != nullptr) {
      const auto [value, most] = coarse_at(frame.Center(x, y, z));
      if (most < kEmptyDepth) return;
      start = value;
    }
    const std::size_t at = level.voxels.Make(x, y, z);
    level.depth.resize(level.voxels.Size(), 0.0f);
    level.may_hold_tree.resize(level.voxels.Size(), 0);
    level.depth[at] = start;
    level.may_hold_tree[at] = 1;
  });
  for (const MatteView& view : views) {
    level.views.push_back(RaysOf(view, level, options.leaf_spread));
  }
  return level;
}

double MeanSquare(const std::vector<Fit>& fits, const std::vector<RayView>& views) {
  double squares = 0, rays = 0;
  for (std::size_t v = 0; v < fits.size(); ++v) {
    squares += views[v].weight * fits[v].squares;
    rays += views[v].weight * fits[v].rays;
  }
  return rays > 0 ? squares / rays : 0;
}

// A matte whose residual is more than twice the median's does not belong to the others.
std::vector<ViewWeight> Weigh(std::span<const MatteView> views,
                              const std::vector<Fit>& fits) {
  constexpr double kUsual = 2.0;
  std::vector<ViewWeight> weights;
  std::vector<double> residuals;
  for (std::size_t v = 0; v < views.size(); ++v) {
    weights.push_back(
        {views[v].name,
         fits[v].rays > 0 ? std::sqrt(fits[v].squares / fits[v].rays) : 0.0});
    residuals.push_back(weights.back().residual_rms);
  }
  std::nth_element(residuals.begin(),
                   residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2),
                   residuals.end());
  const double usual = kUsual * residuals[residuals.size() / 2];
  for (ViewWeight& w : weights) {
    if (views.size() >= 4 && w.residual_rms > usual) {
      w.weight = std::pow(usual / w.residual_rms, 4);
    }
  }
  return weights;
}

void Solve(Level& level,
           int passes,
           double smoothness,
           double& mean_square,
           std::vector<Fit>& fits,
           Tomography& result,
           const Progress& progress) {
  const std::size_t size = level.voxels.Size();
  std::vector<float> ahead = level.depth;  // Where momentum leads.
  std::vector<float> next(size);
  double momentum = 1;
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<PerVoxel> surrogate =
        BackProject(level,
                    ahead,
                    DataSurrogate,
                    fits,
                    progress.Part(1.0 * pass / passes, (pass + 1.0) / passes));
    for (std::size_t i = 0; i < size; ++i) surrogate[i][1] /= ahead[i] + kShare;
    // The first pass of all knows no residual: that of a usual crown is taken
    mean_square = mean_square > 0 ? MeanSquare(fits, level.views) : 0.01;
    double value = 0;
    for (const Fit& fit : fits) {
      value += fit.sum;
      result.crossings += fit.crossings;
    }
    value += AddPrior(level.voxels,
                      ahead,
                      static_cast<float>(smoothness * kPriorWeight * mean_square),
                      surrogate);
    result.objective.push_back(value);

    // Step, never below 0; momentum ends where the last step points the other way
    std::vector<double> against(level.voxels.brick_at.size());
    ParallelRanges(static_cast<int>(against.size()), 64, [&](int begin, int end) {
      for (int b = begin; b < end; ++b) {
        const std::size_t from = static_cast<std::size_t>(b) * BrickVoxels::kPerBrick;
        double sum = 0;
        for (std::size_t i = from; i < from + BrickVoxels::kPerBrick; ++i) {
          const auto [gradient, curvature] = surrogate[i];
          next[i] = level.may_hold_tree[i] != 0
                        ? std::max(0.0f, ahead[i] - gradient / (curvature + 1e-6f))
                        : 0.0f;
          sum += (ahead[i] - next[i]) * (next[i] - level.depth[i]);
        }
        against[static_cast<std::size_t>(b)] = sum;
      }
    });
    if (std::accumulate(against.begin(), against.end(), 0.0) > 0) momentum = 1;
    const double next_momentum = (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
    const auto beta = static_cast<float>((momentum - 1) / next_momentum);
    momentum = next_momentum;
    for (std::size_t i = 0; i < size; ++i) {
      ahead[i] = std::max(0.0f, next[i] + beta * (next[i] - level.depth[i]));
    }
    std::swap(level.depth, next);
  }
}

}  // namespace

Tomography EstimateTomography(std::span<const MatteView> views,
                              const Eigen::AlignedBox3d& bounds_in_world,
                              const TomographyOptions& options,
                              const Progress& progress) {
  std::vector<int> cells = {options.cells};
  while (cells.back() / 2 >= kCoarsestCells) cells.push_back(cells.back() / 2);
  std::reverse(cells.begin(), cells.end());

  // A resolution costs about eight times the one before it
  std::vector<double> ends = {0};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double passes = i + 1 < cells.size() ? 2 : 1;
    ends.push_back(ends.back() + passes * std::pow(8.0, static_cast<double>(i)));
  }

  Tomography result;
  Level level;
  std::vector<Fit> fits;
  double mean_square = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Progress part = progress.Part(ends[i] / ends.back(), ends[i + 1] / ends.back());
    Level next = MakeLevel(EmptyGrid(bounds_in_world, cells[i]),
                           views,
                           options,
                           i == 0 ? nullptr : &level,
                           part.Part(0, 0.1));
    level = std::move(next);
    if (level.depth.empty()) {
      throw InputError(
          "nothing is left of the tree in the volume: the mattes contradict each other; "
          "check that cameras and mattes belong to the same photos, or forgive bad "
          "mattes with --kth-smallest 3");
    }
    if (i > 0) {
      result.views = Weigh(views, fits);
      for (std::size_t v = 0; v < views.size(); ++v) {
        level.views[v].weight = result.views[v].weight;
      }
    }
    Solve(level,
          i + 1 < cells.size() ? 2 * options.passes : options.passes,
          options.smoothness,
          mean_square,
          fits,
          result,
          part.Part(0.1, 1));
  }
  const std::vector<ViewWeight> last = Weigh(views, fits);
  if (result.views.empty()) result.views = last;
  for (std::size_t v = 0; v < last.size(); ++v) {
    result.views[v].residual_rms = last[v].residual_rms;
  }

  // A voxel is hidden when of all light on its rays none comes through
  const auto through = [](const RayView&, const MatteRay&, float t) {
    return PerVoxel{t, 1.0f};
  };
  const std::vector<PerVoxel> seen = BackProject(level, level.depth, through, fits, {});

  for (std::size_t i = 0; i < level.depth.size(); ++i) {
    float& depth = level.depth[i];
    if (depth < kEmptyDepth) {
      depth = 0;
      continue;
    }
    if (seen[i][0] <= 0.02f * seen[i][1]) ++result.hidden_voxels;
    depth = static_cast<float>(depth / level.frame.cell_m);  // From here on [1/m]
  }
  result.grid = {std::move(level.voxels), std::move(level.depth)};
  result.grid.origin_m = level.frame.origin_m;
  result.grid.cell_m = level.frame.cell_m;
  result.grid.DropEmptyBricks();
  return result;
}

}  // namespace relight
