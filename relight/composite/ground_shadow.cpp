// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/ground_shadow.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/sky_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace relight {
namespace {

using std::numbers::pi;

constexpr double kLeastShadow = 1.0 / 255;  // Below, nobody sees it.
constexpr int kTexelsPerVoxel = 2;
constexpr int kLargestMap_px = 2048;
constexpr int kRowsAtOnce = 8;

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// --- The volume ----------------------------------------------------------------------

// The grid with voxels `factor` times as large: means, so that optical depth is kept.
ExtinctionGrid Coarser(const ExtinctionGrid& grid, int factor) {
  if (factor == 1) return grid;
  ExtinctionGrid coarse{NoBricks((grid.cells.array() + factor - 1) / factor,
                                 grid.origin_m,
                                 grid.cell_m * factor),
                        {}};
  const float share = 1.0f / static_cast<float>(factor * factor * factor);
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    coarse.Add(x / factor, y / factor, z / factor, share * grid.sigma_per_m[index]);
  });
  return coarse;
}

// The box around what is not empty and above the ground; a voxel around its centres, as
// far as interpolation carries. Empty when there is nothing.
Eigen::AlignedBox3d BoxAbove(const ExtinctionGrid& grid, double ground_z_m) {
  Eigen::AlignedBox3d box;
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    const bool above = grid.origin_m.z() + (z + 1) * grid.cell_m > ground_z_m;
    if (!above || grid.sigma_per_m[index] <= 0) return;
    box.extend(grid.Center(x, y, z) + Eigen::Vector3d::Constant(grid.cell_m));
    box.extend(grid.Center(x, y, z) - Eigen::Vector3d::Constant(grid.cell_m));
  });
  if (!box.isEmpty()) box.min().z() = std::max(box.min().z(), ground_z_m);
  return box;
}

// --- Light from one direction --------------------------------------------------------

// One cut through the volume as light of one direction crosses it: all rays are in the
// layer of voxels `z`, `shift_m` away from where they meet the ground.
struct Cut {
  int z = 0;
  Eigen::Vector2d shift_m = {0, 0};
  float length_m = 0.0f;  // Of the ray, that the cut stands for.
};

// A cut a layer, more where the ray crosses more than one voxel of a layer.
std::vector<Cut> CutsAlong(const ExtinctionGrid& grid,
                           const Eigen::Vector3d& direction,
                           double ground_z_m) {
  constexpr double kFlattest = 1e-3;
  const double rise = std::max(direction.z(), kFlattest);
  const Eigen::Vector2d slope = direction.head<2>() / rise;
  const int per_layer = std::max(1, static_cast<int>(std::ceil(slope.norm() - 1e-9)));
  std::vector<Cut> cuts;
  for (int z = 0; z < grid.cells.z(); ++z) {
    const double top = grid.origin_m.z() + (z + 1) * grid.cell_m - ground_z_m;
    const double bottom = std::max(0.0, top - grid.cell_m);
    if (top <= 0) continue;
    const double step = (top - bottom) / per_layer;
    for (int i = 0; i < per_layer; ++i) {
      cuts.push_back(
          {z, (bottom + (i + 0.5) * step) * slope, static_cast<float>(step / rise)});
    }
  }
  return cuts;
}

// One row of a map, texels apart by their phase: texel kTexelsPerVoxel k + phase is
// [phase][k], so that neighbours in memory are neighbours in the grid.
struct PhasedRow {
  explicit PhasedRow(int texels)
      : per_phase((texels + kTexelsPerVoxel - 1) / kTexelsPerVoxel),
        values(static_cast<std::size_t>(per_phase) * kTexelsPerVoxel) {}
  float* Phase(int phase) {
    return values.data() + static_cast<std::ptrdiff_t>(phase) * per_phase;
  }
  // visit(texel, value) of those that were touched.
  template <class Visit>
  void ForEach(Visit&& visit) const {
    for (int phase = 0; phase < kTexelsPerVoxel; ++phase) {
      const float* of_phase =
          values.data() + static_cast<std::ptrdiff_t>(phase) * per_phase;
      for (int k = touched_begin; k < touched_end; ++k) {
        visit(kTexelsPerVoxel * k + phase, of_phase[k]);
      }
    }
  }
  void Clear() {
    std::fill(values.begin(), values.end(), 0.0f);
    touched_begin = per_phase;
    touched_end = 0;
  }
  int per_phase;
  std::vector<float> values;
  int touched_begin = 0, touched_end = 0;  // Of k: others are 0.
};

// Optical depths of the texels of row `j` of `map`: sigma is interpolated in the layer,
//
//   D(p) = sum over cuts of length * sigma(p + shift)                           (G11)
void RowDepth(const ExtinctionGrid& grid,
              const VoxelRows& rows,
              const std::vector<Cut>& cuts,
              const GroundMap& map,
              int j,
              std::vector<float>& blended,
              PhasedRow& depth) {
  depth.Clear();
  const int columns = grid.cells.x();
  const Eigen::Vector2d corner =
      (map.corner_m - grid.origin_m.head<2>()) / grid.cell_m;  // In voxels
  const double half_texel = 0.5 / kTexelsPerVoxel;
  for (const Cut& cut : cuts) {
    // The two rows of voxels around, and what is not empty of them
    const double y = corner.y() + cut.shift_m.y() / grid.cell_m +
                     static_cast<double>(j) / kTexelsPerVoxel + half_texel - 0.5;
    const int y0 = static_cast<int>(std::floor(y));
    if (y0 < -1 || y0 >= grid.cells.y()) continue;
    const auto weight = static_cast<float>(y - y0);
    int first = columns, last = -1;
    for (const int row : {y0, y0 + 1}) {
      if (row < 0 || row >= grid.cells.y()) continue;
      const auto r =
          static_cast<std::size_t>(row) +
          static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(cut.z);
      first = std::min(first, rows.first[r]);
      last = std::max(last, rows.last[r]);
    }
    if (first > last) continue;

    // Blend them: [1 + x] is voxel x, with an empty one on either side
    float* blend = blended.data();
    std::fill(blend + first, blend + last + 3, 0.0f);
    for (const int row : {y0, y0 + 1}) {
      if (row < 0 || row >= grid.cells.y()) continue;
      const float share = cut.length_m * (row == y0 ? 1 - weight : weight);
      const auto r =
          static_cast<std::size_t>(row) +
          static_cast<std::size_t>(grid.cells.y()) * static_cast<std::size_t>(cut.z);
      const float* sigma = rows.At(r, 0);
      for (int x = rows.first[r]; x <= rows.last[r]; ++x)
        blend[x + 1] += share * sigma[x];
    }

    // Add them to the texels that lie under them, phase by phase
    for (int phase = 0; phase < kTexelsPerVoxel; ++phase) {
      const double x = corner.x() + cut.shift_m.x() / grid.cell_m +
                       static_cast<double>(phase) / kTexelsPerVoxel + half_texel - 0.5;
      const int x0 = static_cast<int>(std::floor(x));
      const auto right = static_cast<float>(x - x0);
      const float left = 1 - right;
      const int begin = std::max(0, first - 1 - x0);
      const int end = std::min(depth.per_phase, last + 1 - x0);
      if (begin >= end) continue;
      depth.touched_begin = std::min(depth.touched_begin, begin);
      depth.touched_end = std::max(depth.touched_end, end);
      const float* __restrict source = blend + 1 + x0 + begin;
      float* __restrict sum = depth.Phase(phase) + begin;
      const int count = end - begin;
      for (int k = 0; k < count; ++k) sum[k] += left * source[k] + right * source[k + 1];
    }
  }
}

// take(j, i, depths) for each row j of `map` and direction i, rows in parallel.
template <class Take>
void GatherDepths(const ExtinctionGrid& grid,
                  const std::vector<Eigen::Vector3d>& directions,
                  double ground_z_m,
                  const GroundMap& map,
                  const Take& take,
                  const Progress& progress) {
  const VoxelRows rows = RowsOf(grid);
  std::vector<std::vector<Cut>> cuts;
  cuts.reserve(directions.size());
  for (const Eigen::Vector3d& direction : directions) {
    cuts.push_back(CutsAlong(grid, direction, ground_z_m));
  }
  ParallelRanges(
      map.values.rows,
      kRowsAtOnce,
      [&](int begin, int end) {
        PhasedRow depth(map.values.cols);
        std::vector<float> blended(static_cast<std::size_t>(grid.cells.x()) + 3);
        for (int j = begin; j < end; ++j) {
          for (std::size_t i = 0; i < cuts.size(); ++i) {
            RowDepth(grid, rows, cuts[i], map, j, blended, depth);
            take(j, i, depth);
          }
        }
      },
      progress);
}

// --- Maps ----------------------------------------------------------------------------

// A map that covers `box`, on the grid's own lines.
GroundMap MapOver(const Eigen::AlignedBox2d& box, const ExtinctionGrid& grid, int type) {
  GroundMap map;
  map.texel_m = grid.cell_m / kTexelsPerVoxel;
  const Eigen::Array2d origin = grid.origin_m.head<2>();
  const Eigen::Array2d low = ((box.min().array() - origin) / grid.cell_m).floor();
  const Eigen::Array2d high = ((box.max().array() - origin) / grid.cell_m).ceil();
  map.corner_m = (origin + low * grid.cell_m).matrix();
  const Eigen::Array2i texels = ((high - low).cast<int>() * kTexelsPerVoxel).max(1);
  map.values.create(texels.y(), texels.x(), type);
  map.values.setTo(cv::Scalar::all(1));
  return map;
}

// Where the shadow of `box` falls under light from `direction`.
Eigen::AlignedBox2d ShadowOfBox(const Eigen::AlignedBox3d& box,
                                const Eigen::Vector3d& direction,
                                double ground_z_m) {
  Eigen::AlignedBox2d shadow;
  const Eigen::Vector2d slope = direction.head<2>() / direction.z();
  for (const double z : {box.min().z(), box.max().z()}) {
    const Eigen::Vector2d shift = (z - ground_z_m) * slope;
    shadow.extend(Eigen::Vector2d(box.min().head<2>() - shift));
    shadow.extend(Eigen::Vector2d(box.max().head<2>() - shift));
  }
  return shadow;
}

// Directions to points spread evenly over the sun's disc: its centre and rings of 6, 12,
// … around, each point for an equal area.
std::vector<Eigen::Vector3d> SunDisc(const Eigen::Vector3d& sun, int rings) {
  const Eigen::Vector3d right = std::abs(sun.z()) < 0.999
                                    ? Eigen::Vector3d::UnitZ().cross(sun).normalized()
                                    : Eigen::Vector3d::UnitX().cross(sun).normalized();
  const Eigen::Vector3d up = sun.cross(right);
  const int count = 1 + 3 * rings * (rings + 1);
  const double radius = std::tan(RadFromDeg(kSunDiameter_deg) / 2);
  std::vector<Eigen::Vector3d> directions = {sun};
  for (int ring = 1, before = 1; ring <= rings; before += 6 * ring, ++ring) {
    // The circle that halves the ring's area
    const double r = radius * std::sqrt((before + 3.0 * ring) / count);
    for (int i = 0; i < 6 * ring; ++i) {
      const double phi = 2 * pi * (i + 0.5 * (ring % 2)) / (6 * ring);
      directions.push_back(
          (sun + r * (std::cos(phi) * right + std::sin(phi) * up)).normalized());
    }
  }
  return directions;
}

// T(p) = mean of tau(p, w) over the sun's disc                                  (G9)
GroundMap SunMap(const ExtinctionGrid& grid,
                 const Eigen::AlignedBox3d& box,
                 const Eigen::Vector3d& sun,
                 double ground_z_m,
                 const Progress& progress) {
  // Texels as small as the map's size allows: under a low sun the shadow is long
  const auto covers = [&](const ExtinctionGrid& g,
                          const std::vector<Eigen::Vector3d>& d) {
    Eigen::AlignedBox2d shadow;
    for (const Eigen::Vector3d& direction : d) {
      shadow.extend(ShadowOfBox(box, direction, ground_z_m));
    }
    return MapOver(shadow, g, CV_32FC1);
  };
  // The blur of the highest twig, in voxels, decides how many points the disc needs
  const double blur_m =
      (box.max().z() - ground_z_m) / sun.z() * RadFromDeg(kSunDiameter_deg) / 2;
  int factor = 1;
  const double length_m =
      ShadowOfBox(box, sun, ground_z_m).sizes().maxCoeff() + 2 * blur_m / sun.z();
  while (length_m * kTexelsPerVoxel > kLargestMap_px * grid.cell_m * factor) ++factor;
  const ExtinctionGrid voxels = Coarser(grid, factor);
  const int rings = std::clamp(static_cast<int>(std::ceil(blur_m / voxels.cell_m)), 1, 3);
  std::vector<Eigen::Vector3d> disc = SunDisc(sun, rings);
  std::erase_if(disc, [](const Eigen::Vector3d& d) { return d.z() < 1e-3; });
  if (disc.empty()) return {};
  GroundMap map = covers(voxels, disc);

  const float share = 1.0f / static_cast<float>(disc.size());
  GatherDepths(
      voxels,
      disc,
      ground_z_m,
      map,
      [&](int j, std::size_t, const PhasedRow& depth) {
        auto* row = map.values.ptr<float>(j);
        depth.ForEach([&](int texel, float d) { row[texel] += share * std::expm1(-d); });
      },
      progress);
  return map;
}

// How far from a box w wide (the larger side) and h high it hides at most `share` of a
// uniform sky from level ground: the view factor of an upright rectangle,
//
//   F(d) = (a - d/r b) / pi,   a = atan(w / 2d), r^2 = d^2 + h^2, b = atan(w / 2r)
//                                                                               (G1)
double ReachOfSkyShadow(double width_m, double height_m, double share) {
  const auto hidden = [&](double d) {
    const double r = std::hypot(d, height_m);
    return (std::atan(width_m / 2 / d) - d / r * std::atan(width_m / 2 / r)) / pi;
  };
  double reach_m = 0.1 * height_m;
  while (hidden(reach_m) > share) reach_m *= 1.1;
  return reach_m;
}

// `count` directions over the upper hemisphere, as dense as the cosine to the zenith:
//   z_i^2 = 1 - (i + 1/2) / count,   phi_i = i pi (3 - sqrt 5)                   (G2)
std::vector<Eigen::Vector3d> CosineDirections(int count) {
  const double golden_angle = pi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double sin2 = (i + 0.5) / count, s = std::sqrt(sin2);
    directions.emplace_back(s * std::cos(i * golden_angle),
                            s * std::sin(i * golden_angle),
                            std::sqrt(1 - sin2));
  }
  return directions;
}

// V(p) = sum_i L(w_i) tau(p, w_i) / sum_i L(w_i)                                 (G10)
GroundMap SkyMap(const ExtinctionGrid& grid,
                 const Eigen::AlignedBox3d& box,
                 const Daylight& daylight,
                 double sky_share,
                 const GroundShadowOptions& options,
                 const Progress& progress) {
  // The sky's shadow is soft: some 40 voxels a side are enough
  constexpr int kVoxels = 40;
  const ExtinctionGrid voxels =
      Coarser(grid, std::max(1, (grid.cells.maxCoeff() + kVoxels / 2) / kVoxels));

  // Weights of the directions; a sky much brighter on one side reaches farther there
  const std::vector<Eigen::Vector3d> directions =
      CosineDirections(options.sky_directions);
  std::vector<Eigen::Array3f> weights;
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (const Eigen::Vector3d& direction : directions) {
    const Eigen::Array3d radiance = daylight.SkyRadiance(direction).max(0.0);
    weights.push_back(radiance.cast<float>());
    sum += radiance;
  }
  if (!(sum > 0).all()) return {};
  double brightest = 0;
  for (Eigen::Array3f& weight : weights) {
    brightest = std::max(brightest, Luminance(weight.cast<double>()) / Luminance(sum));
    weight /= sum.cast<float>();
  }
  const double unevenness = brightest * options.sky_directions;
  const double reach_m =
      ReachOfSkyShadow(box.sizes().head<2>().maxCoeff(),
                       box.max().z() - options.ground_z_m,
                       kLeastShadow / std::max(kLeastShadow, sky_share * unevenness));
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach_m);
  const Eigen::AlignedBox2d foot(Eigen::Vector2d(box.min().head<2>()),
                                 Eigen::Vector2d(box.max().head<2>()));
  GroundMap map = MapOver({foot.min() - margin, foot.max() + margin}, voxels, CV_32FC3);

  GatherDepths(
      voxels,
      directions,
      options.ground_z_m,
      map,
      [&](int j, std::size_t i, const PhasedRow& depth) {
        auto* row = map.values.ptr<cv::Vec3f>(j);
        const cv::Vec3f weight(weights[i][0], weights[i][1], weights[i][2]);
        depth.ForEach([&](int texel, float d) {
          if (d > 0) row[texel] += weight * std::expm1(-d);
        });
      },
      progress);

  // Fade out to the map's edge, over the last quarter of the reach
  for (int j = 0; j < map.values.rows; ++j) {
    auto* row = map.values.ptr<cv::Vec3f>(j);
    const double y = map.corner_m.y() + (j + 0.5) * map.texel_m;
    for (int i = 0; i < map.values.cols; ++i) {
      const double x = map.corner_m.x() + (i + 0.5) * map.texel_m;
      const double beyond = foot.exteriorDistance(Eigen::Vector2d(x, y)) / reach_m;
      const auto kept = static_cast<float>(std::clamp(4 * (1 - beyond), 0.0, 1.0));
      if (kept < 1) row[i] = cv::Vec3f::all(1) + kept * (row[i] - cv::Vec3f::all(1));
    }
  }
  return map;
}

// --- Looking at it -------------------------------------------------------------------

// Between the centres of the texels; 1 outside.
template <class Value>
Value Sample(const GroundMap& map, const Eigen::Vector2d& ground_m, Value one) {
  const Eigen::Vector2d at = (ground_m - map.corner_m) / map.texel_m;
  if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < map.values.cols + 0.5 &&
        at.y() < map.values.rows + 0.5)) {
    return one;
  }
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto right = static_cast<float>(x - x0), up = static_cast<float>(y - y0);
  const auto texel = [&](int row, int column) {
    const bool inside =
        row >= 0 && column >= 0 && row < map.values.rows && column < map.values.cols;
    return inside ? map.values.at<Value>(row, column) : one;
  };
  return (1 - up) * ((1 - right) * texel(y0, x0) + right * texel(y0, x0 + 1)) +
         up * ((1 - right) * texel(y0 + 1, x0) + right * texel(y0 + 1, x0 + 1));
}

}  // namespace

cv::Vec3f GroundShadow::At(const Eigen::Vector2d& ground_m) const {
  const float sun_left = Sample(sun, ground_m, 1.0f);
  const cv::Vec3f sky_left = Sample(sky, ground_m, cv::Vec3f::all(1));
  cv::Vec3f left;
  for (int c = 0; c < 3; ++c) {
    const float s = sun_share[c] * sun_left + (1 - sun_share[c]) * sky_left[c];
    left[c] = std::clamp(s, 0.0f, 1.0f);
  }
  return left;
}

namespace {

// T <- 1 - T_o (1 - T): what the occluder hides is not the tree's to hide.
void HideSun(const Occluder& occluder,
             const Eigen::Vector3d& sun,
             double ground_z_m,
             GroundMap& map) {
  constexpr double kAbove_m = 1e-3;  // The foot of a wall stands on the ground
  cv::Mat1f values = map.values;
  ParallelRanges(values.rows, kRowsAtOnce, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      for (int i = 0; i < values.cols; ++i) {
        float& value = values(j, i);
        if (value >= 1) continue;
        const Eigen::Vector2d at =
            map.corner_m + map.texel_m * Eigen::Vector2d(i + 0.5, j + 0.5);
        const double seen =
            occluder.Transmittance({at.x(), at.y(), ground_z_m + kAbove_m}, sun);
        value = static_cast<float>(1 - seen * (1 - value));
      }
    }
  });
}

}  // namespace

GroundShadow MakeGroundShadow(const ExtinctionGrid& grid,
                              const Daylight& daylight,
                              const GroundShadowOptions& options,
                              const Progress& progress,
                              const Occluder* occluder) {
  CheckFields(options);
  GroundShadow shadow;
  shadow.ground_z_m = options.ground_z_m;

  // q = S sin(e) / (S sin(e) + k E_h)                                            (G8)
  const Eigen::Array3d sun =
      (daylight.sun_irradiance * std::max(0.0, daylight.sun_direction.z())).max(0.0);
  const Eigen::Array3d sky =
      options.sky_level * HorizontalSkyIrradiance(daylight).max(0.0);
  for (int c = 0; c < 3; ++c) {
    if (sun[c] > 0) shadow.sun_share[c] = static_cast<float>(sun[c] / (sun[c] + sky[c]));
  }

  // A sun so low that nobody sees its shadow
  if (shadow.sun_share.maxCoeff() < static_cast<float>(kLeastShadow)) {
    shadow.sun_share.setZero();
  }

  const Eigen::AlignedBox3d box = BoxAbove(grid, options.ground_z_m);
  if (box.isEmpty()) return shadow;
  if ((shadow.sun_share > 0).any()) {
    shadow.sun = SunMap(
        grid, box, daylight.sun_direction, options.ground_z_m, progress.Part(0, 0.3));
    if (occluder != nullptr) {
      HideSun(*occluder, daylight.sun_direction, options.ground_z_m, shadow.sun);
    }
  }
  if ((sky > 0).any()) {
    shadow.sky = SkyMap(grid,
                        box,
                        daylight,
                        Luminance(sky) / Luminance(sun + sky),
                        options,
                        progress.Part(0.3, 1));
  }
  return shadow;
}

cv::Mat3f ShadowRows(const GroundShadow& shadow,
                     const Camera& camera,
                     int row_begin,
                     int row_end) {
  Require(row_begin >= 0 && row_begin <= row_end && row_end <= camera.height_px,
          "rows of the camera");
  cv::Mat3f rows(row_end - row_begin, camera.width_px, cv::Vec3f::all(1));
  const Eigen::Vector3d eye = camera.PositionInWorld();
  const double height_m = shadow.ground_z_m - eye.z();
  const double texel_m =
      shadow.sun.values.empty() ? shadow.sky.texel_m : shadow.sun.texel_m;
  for (int row = row_begin; row < row_end; ++row) {
    for (int column = 0; column < camera.width_px; ++column) {
      // A pixel far away sees several texels: look at as many points, one below another
      const Eigen::Vector3d center = camera.RayInWorld({column + 0.5, row + 0.5});
      constexpr double kMostPoints = 8;
      double points_wanted = 1;
      if (center.z() * height_m > 0) {
        const double range_m = height_m / center.z();
        const double seen_m = range_m / (camera.focal_px.y() * std::abs(center.z()));
        points_wanted = std::ceil(seen_m / texel_m);
      } else if (std::abs(center.z()) * camera.focal_px.y() < 1) {
        points_wanted = kMostPoints;  // The horizon may run through the pixel
      }
      const int points = static_cast<int>(std::clamp(points_wanted, 1.0, kMostPoints));
      cv::Vec3f sum(0, 0, 0);
      for (int i = 0; i < points; ++i) {
        const Eigen::Vector3d ray =
            points == 1 ? center
                        : camera.RayInWorld({column + 0.5, row + (i + 0.5) / points});
        sum += ray.z() * height_m > 0
                   ? shadow.At((eye + height_m / ray.z() * ray).head<2>())
                   : cv::Vec3f::all(1);
      }
      rows(row - row_begin, column) = sum * (1.0f / static_cast<float>(points));
    }
  }
  return rows;
}

cv::Mat3f ShadowImage(const GroundShadow& shadow,
                      const Camera& camera,
                      const Progress& progress) {
  cv::Mat3f image(camera.height_px, camera.width_px);
  ParallelRanges(
      image.rows,
      kRowsAtOnce,
      [&](int begin, int end) {
        ShadowRows(shadow, camera, begin, end).copyTo(image.rowRange(begin, end));
      },
      progress);
  return image;
}

double GroundShare(const Camera& camera, double ground_z_m) {
  const double height_m = ground_z_m - camera.PositionInWorld().z();
  constexpr int kAcross = 32;
  int seen = 0;
  for (int row = 0; row < kAcross; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) / kAcross * camera.width_px,
                                  (row + 0.5) / kAcross * camera.height_px);
      seen += camera.RayInWorld(pixel).z() * height_m > 0;
    }
  }
  return static_cast<double>(seen) / (kAcross * kAcross);
}

}  // namespace relight
