// SPDX-License-Identifier: Apache-2.0

// How right and how fast the light volume is.
//
//   benchmark_light [TREE …]   folders of the layout of shared data/maple
//
// Held against explicit sampling: from the centre of each voxel that a view ray crosses
// (where light is taken, as in shared reference/cabral2011), a ray to each of 1024
// directions over the sky, marched by the library's own traversal and stopped at a
// transmittance of 0.001. For the first view also from the middle of the view ray's part
// of each voxel: what voxels of constant light cost, whatever the transport. The last
// line is one run's result, on the first tree and on generated crowns of 64, 128 and 256
// voxels; read ratios and CPU times, the rest depends on what else the machine does.

#include "relight/base/angles.h"
#include "relight/base/parallel.h"
#include "relight/cameras/colmap_model.h"
#include "relight/photo/image_file.h"
#include "relight/scattering/arriving_light.h"
#include "relight/scattering/sweep_kernels.h"
#include "relight/scattering/view_transport.h"
#include "relight/sh/quadrature.h"
#include "relight/sh/sky_coefficients.h"
#include "relight/sky/solar_position.h"
#include "relight/volume/opacity_estimation.h"
#include "relight/volume/ray_traversal.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>

namespace relight {
namespace {

namespace fs = std::filesystem;

constexpr int kDirections = 1024;  // Over the sky
constexpr int kEvery = 16;         // Pixels, both ways
constexpr int kMostBands = 8, kBands = 6;
constexpr double kPixels = 1e6;

double Seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cost {
  double cpu_s = std::numeric_limits<double>::infinity();
  double wall_s = std::numeric_limits<double>::infinity();
};

// Fills the caches with something else.
void ForgetCaches() {
  static std::vector<char> other(std::size_t{1} << 30, 1);
  for (std::size_t i = 0; i < other.size(); i += 64) ++other[i];
}

// The least of some runs: what the work costs when nobody disturbs it.
template <class Work>
Cost Measure(int runs, Work&& work, bool from_memory = false) {
  Cost least;
  for (int i = 0; i < runs; ++i) {
    if (from_memory) ForgetCaches();
    const double cpu = Seconds(CLOCK_PROCESS_CPUTIME_ID), wall = Seconds(CLOCK_MONOTONIC);
    work();
    least.cpu_s = std::min(least.cpu_s, Seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    least.wall_s = std::min(least.wall_s, Seconds(CLOCK_MONOTONIC) - wall);
  }
  return least;
}

struct Sky {
  std::string name;
  Daylight daylight;
  bool of_truth_hour = false;  // Of the tree's own; the last line's error is of these.
};

struct View {
  std::string name;
  Camera camera;
  cv::Mat1b inside;
  std::vector<Sky> skies;
};

struct TestTree {
  std::string name;
  ExtinctionGrid grid;
  std::vector<View> views;
};

Daylight DaylightAt(double azimuth_deg,
                    double elevation_deg,
                    SkyModel model,
                    int cie_type = kCieOvercast) {
  SolarPosition sun;
  sun.azimuth_rad = RadFromDeg(azimuth_deg);
  sun.elevation_rad = RadFromDeg(elevation_deg);
  sun.direction = DirectionFromAzimuthElevation(sun.azimuth_rad, sun.elevation_rad);
  return MakeDaylight(sun, {.model = model, .cie_type = cie_type});
}

// What no hour of the trees has: low suns, a twilight, the standard skies.
std::vector<Sky> OtherSkies() {
  std::vector<Sky> skies = {{"uniform", UniformDaylight({1000, 1000, 1000})}};
  for (const double elevation_deg : {1.0, 8.0}) {
    for (const double azimuth_deg : {100.0, 260.0}) {
      for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
        skies.push_back(
            {fmt::format("sun {} deg high at {}, {}",
                         elevation_deg,
                         azimuth_deg,
                         model == SkyModel::kPreetham ? "preetham" : "atmosphere"),
             DaylightAt(azimuth_deg, elevation_deg, model)});
      }
    }
  }
  skies.push_back({"twilight", DaylightAt(290, -4, SkyModel::kAtmosphere)});
  for (int type = 1; type <= 15; ++type) {
    skies.push_back(
        {fmt::format("cie:{}", type), DaylightAt(230, 30, SkyModel::kCie, type)});
  }
  return skies;
}

TestTree ReadTree(const fs::path& folder) {
  TestTree tree;
  tree.name = folder.filename().string();
  std::vector<MatteView> mattes;
  for (const NamedCamera& named : ReadColmap(folder / "sparse").cameras) {
    mattes.push_back(
        {named.view, named.camera, ReadMatte(folder / "alpha" / (named.view + ".png"))});
  }
  std::ifstream file(folder / "capture_truth.json");
  const auto truth = nlohmann::json::parse(file);
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min()[axis] = truth["bbox_min_m"][axis].get<double>() - 0.15;
    box.max()[axis] = truth["bbox_max_m"][axis].get<double>() + 0.15;
  }
  tree.grid = EstimateOpacity(mattes, box).grid;
  std::map<std::string, std::vector<Sky>> skies;
  for (const auto& hour : truth["truth"]) {
    for (const auto& [model, word] : {std::pair(SkyModel::kPreetham, "preetham"),
                                      std::pair(SkyModel::kCabral2011, "cabral2011"),
                                      std::pair(SkyModel::kAtmosphere, "atmosphere")}) {
      skies[hour["view"]].push_back(
          {fmt::format("{} {}", hour["time"].get<std::string>().substr(11, 5), word),
           DaylightAt(hour["sun_azimuth_deg"], hour["sun_elevation_deg"], model),
           true});
    }
  }
  for (auto& [name, of_view] : skies) {
    for (const Sky& sky : OtherSkies()) of_view.push_back(sky);
    for (const MatteView& matte : mattes) {
      if (matte.name != name) continue;
      const double zoom = std::sqrt(kPixels / static_cast<double>(matte.alpha.total()));
      const cv::Size size(static_cast<int>(std::lround(matte.alpha.cols * zoom)),
                          static_cast<int>(std::lround(matte.alpha.rows * zoom)));
      cv::Mat1f alpha;
      cv::resize(matte.alpha, alpha, size, 0, 0, cv::INTER_LINEAR);
      tree.views.push_back({name,
                            matte.camera.Resized(size.width, size.height),
                            cv::Mat1b(alpha > 0.02f),
                            of_view});
    }
  }
  return tree;
}

// Every 16th pixel of the view both ways.
std::vector<cv::Point> Chosen(const View& view) {
  std::vector<cv::Point> pixels;
  for (int row = kEvery / 2; row < view.inside.rows; row += kEvery) {
    for (int column = kEvery / 2; column < view.inside.cols; column += kEvery) {
      if (view.inside(row, column) != 0) pixels.push_back({column, row});
    }
  }
  return pixels;
}

double MarchedTransmittance(const ExtinctionGrid& grid, const Ray& ray) {
  constexpr double kStop = 6.907755;  // -ln 0.001
  double depth = 0.0;
  TraverseRay(grid, ray, 0.0, [&](std::size_t cell, double, double length_m) {
    depth += length_m * grid.sigma_per_m[cell];
    return depth < kStop;
  });
  return std::exp(-depth);
}

// Light of the part of the sky that is nearer to a direction than to the others,
// [direction][sky]: at its middle alone, the narrow glow round a sun would be met or
// missed.
std::vector<std::vector<Eigen::Array3d>> LightOfCells(
    const std::vector<Eigen::Vector3d>& directions, std::span<const Sky> skies) {
  constexpr int kFiner = 16;
  std::vector<std::vector<Eigen::Array3d>> light(
      directions.size(),
      std::vector<Eigen::Array3d>(skies.size(), Eigen::Array3d::Zero()));
  const int count = 2 * kFiner * static_cast<int>(directions.size());
  const double weight_sr = 4 * std::numbers::pi / count;
  for (const Eigen::Vector3d& direction : SphereDirections(count)) {
    if (direction.z() <= 0) continue;
    std::size_t nearest = 0;
    double most = -1;
    for (std::size_t d = 0; d < directions.size(); ++d) {
      const double cosine = directions[d].dot(direction);
      if (cosine > most) {
        most = cosine;
        nearest = d;
      }
    }
    for (std::size_t s = 0; s < skies.size(); ++s) {
      light[nearest][s] += weight_sr * skies[s].daylight.SkyRadiance(direction);
    }
  }
  return light;
}

// Sky's light of the chosen pixels, [sky][pixel].
std::vector<std::vector<Eigen::Array3d>> Explicit(const ExtinctionGrid& grid,
                                                  const View& view,
                                                  const std::vector<cv::Point>& pixels,
                                                  std::span<const Sky> skies,
                                                  bool from_centers,
                                                  std::atomic<long>& points) {
  std::vector<Eigen::Vector3d> directions;
  for (const Eigen::Vector3d& direction : SphereDirections(2 * kDirections)) {
    if (direction.z() > 0) directions.push_back(direction);
  }
  const std::vector<std::vector<Eigen::Array3d>> radiance =
      LightOfCells(directions, skies);
  std::vector<std::vector<Eigen::Array3d>> light(
      skies.size(), std::vector<Eigen::Array3d>(pixels.size(), Eigen::Array3d::Zero()));
  ParallelRanges(static_cast<int>(pixels.size()), 4, [&](int begin, int end) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end);
         ++p) {
      const Ray ray{view.camera.PositionInWorld(),
                    view.camera.RayInWorld({pixels[p].x + 0.5, pixels[p].y + 0.5})};
      double tau = 1.0;
      long count = 0;
      TraverseRay(grid, ray, 0.0, [&](std::size_t cell, double at, double length_m) {
        if (grid.sigma_per_m[cell] <= 0) return true;
        const double share = -tau * std::expm1(-length_m * grid.sigma_per_m[cell]);
        const Eigen::Vector3i voxel = grid.VoxelAt(cell);
        const Eigen::Vector3d point =
            from_centers ? grid.Center(voxel.x(), voxel.y(), voxel.z())
                         : ray.origin + (at + length_m / 2) * ray.direction;
        for (std::size_t d = 0; d < directions.size(); ++d) {
          const double part = share * MarchedTransmittance(grid, {point, directions[d]});
          for (std::size_t s = 0; s < skies.size(); ++s) {
            light[s][p] += part * radiance[d][s];
          }
        }
        ++count;
        tau -= share;
        return tau > 1e-5;
      });
      points += count;
    }
  });
  return light;
}

double RelativeL2(const cv::Mat3f& image,
                  const std::vector<cv::Point>& pixels,
                  const std::vector<Eigen::Array3d>& truth) {
  double apart = 0, all = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const cv::Vec3f& color = image(pixels[p]);
    for (int c = 0; c < 3; ++c) {
      const double exact = std::max(0.0, truth[p][c]);
      apart += std::pow(color[c] - exact, 2);
      all += exact * exact;
    }
  }
  return std::sqrt(apart / all);
}

// A crown of leaves in clumps, some third of the box's voxels, as many metres whatever
// the voxels.
ExtinctionGrid Crown(int cells) {
  ExtinctionGrid grid =
      EmptyGrid({Eigen::Vector3d::Constant(-4), Eigen::Vector3d::Constant(4)}, cells);
  const auto wave = [](double x, double y, double z) {
    return std::sin(2.1 * x + 1.3 * y) + std::sin(2.7 * y - 1.1 * z) +
           std::sin(2.3 * z + 1.7 * x);
  };
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const Eigen::Vector3d at = grid.Center(x, y, z);
        if (at.norm() > 4 || wave(at.x(), at.y(), at.z()) < -0.4) continue;
        grid.Set(
            x, y, z, static_cast<float>(0.6 + 0.4 * std::sin(40 * at.x() + 31 * at.y())));
      }
    }
  }
  return grid;
}

// Voxels of twice the edge, of the mean extinction.
ExtinctionGrid HalfResolution(const ExtinctionGrid& grid) {
  ExtinctionGrid half{
      NoBricks((grid.cells.array() + 1) / 2, grid.origin_m, 2 * grid.cell_m), {}};
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    half.Add(x / 2, y / 2, z / 2, grid.sigma_per_m[index] / 8);
  });
  return half;
}

// The sky's coefficients at half resolution, put back to all voxels: of voxels of twice
// the edge, or (`swept` false) the mean of each eight voxels' own.
SkyTransmittance HalfSky(const ExtinctionGrid& grid,
                         const OccupiedVoxels& occupied,
                         const SkyTransmittance& full,
                         bool swept,
                         Cost& cost) {
  const ExtinctionGrid half = HalfResolution(grid);
  const OccupiedVoxels of_half = FindOccupied(half);
  std::vector<std::vector<float>> coarse(static_cast<std::size_t>(ShCount(full.bands)),
                                         std::vector<float>(of_half.cell.size(), 0.0f));
  std::vector<std::vector<float>> values = UnpackedSky(full);
  const auto place = [&](std::size_t v) {
    const Eigen::Vector3i at = occupied.cell[v] / 2;
    return static_cast<std::size_t>(of_half.of_cell[half.Index(at.x(), at.y(), at.z())]);
  };
  if (swept) {
    cost = Measure(3, [&] {
      coarse = UnpackedSky(ProjectTransmittance(half, of_half, {.bands = full.bands}));
    });
  } else {
    std::vector<float> count(of_half.cell.size(), 0.0f);
    for (std::size_t v = 0; v < full.voxels; ++v) ++count[place(v)];
    for (std::size_t c = 0; c < values.size(); ++c) {
      for (std::size_t v = 0; v < full.voxels; ++v) {
        coarse[c][place(v)] += values[c][v] / count[place(v)];
      }
    }
  }
  for (std::size_t c = 0; c < values.size(); ++c) {
    for (std::size_t v = 0; v < full.voxels; ++v) values[c][v] = coarse[c][place(v)];
  }
  return PackedSky(full.bands, values);
}

int Run(const std::vector<fs::path>& folders) {
  std::map<int, double> worst;
  double first_error = 0, speedup = 0;
  Cost sky_cost, sun_cost, read_cost;
  double bytes_per_voxel = 0;
  for (const fs::path& folder : folders) {
    const TestTree tree = ReadTree(folder);
    const OccupiedVoxels occupied = FindOccupied(tree.grid);
    const SkyTransmittance most =
        ProjectTransmittance(tree.grid, occupied, {.bands = kMostBands});
    fmt::print("{}: {} x {} x {} voxels, {} of them not empty\n",
               tree.name,
               tree.grid.cells.x(),
               tree.grid.cells.y(),
               tree.grid.cells.z(),
               occupied.cell.size());
    for (const View& view : tree.views) {
      const std::vector<cv::Point> pixels = Chosen(view);
      std::atomic<long> points = 0;
      const auto truth = Explicit(tree.grid, view, pixels, view.skies, true, points);
      std::map<int, double> of_view;
      for (int bands = 2; bands <= kMostBands; ++bands) {
        const ViewTransport transport = MakeViewTransport(
            tree.grid, occupied, FirstBands(most, bands), view.camera, view.inside);
        for (std::size_t s = 0; s < view.skies.size(); ++s) {
          const double error = RelativeL2(
              SkyImage(transport, SkyCoefficients(view.skies[s].daylight, bands)),
              pixels,
              truth[s]);
          of_view[bands] = std::max(of_view[bands], error);
          worst[bands] = std::max(worst[bands], error);
          if (bands == kBands) {
            if (&folder == &folders.front() && &view == &tree.views.front() &&
                view.skies[s].of_truth_hour)
              first_error = std::max(first_error, error);
            fmt::print("  {} {}: {:.4f}\n", view.name, view.skies[s].name, error);
          }
        }
      }
      fmt::print("  {}, worst of {} skies, by bands:", view.name, view.skies.size());
      for (const auto& [bands, error] : of_view) fmt::print(" {}: {:.4f}", bands, error);
      fmt::print("\n");

      if (&folder != &folders.front() || &view != &tree.views.front()) continue;
      // One view and one hour, explicitly and by the light volume
      const std::span<const Sky> one(view.skies.data(), 1);
      points = 0;
      std::vector<std::vector<Eigen::Array3d>> on_ray;
      const Cost by_rays = Measure(
          1, [&] { on_ray = Explicit(tree.grid, view, pixels, one, false, points); });
      const Daylight& day = one[0].daylight;
      ViewTransport transport;
      SkyTransmittance sky;
      const Cost by_volume = Measure(3, [&] {
        sky = ProjectTransmittance(tree.grid, occupied, {.bands = kBands});
        transport = MakeViewTransport(tree.grid, occupied, sky, view.camera, view.inside);
        SkyImage(transport, SkyCoefficients(day));
      });
      fmt::print(
          "  from the middle of each voxel's part of the ray, {}: {:.4f}\n",
          one[0].name,
          RelativeL2(SkyImage(transport, SkyCoefficients(day)), pixels, on_ray[0]));
      speedup = by_rays.cpu_s * kEvery * kEvery / by_volume.cpu_s;
      fmt::print(
          "  explicit: {} pixels, {} points, {:.2f} CPU s; light volume, all "
          "pixels: {:.2f} CPU s\n",
          pixels.size(),
          points.load(),
          by_rays.cpu_s,
          by_volume.cpu_s);

      // At half resolution
      const auto worst_with = [&](const SkyTransmittance& of) {
        const ViewTransport with =
            MakeViewTransport(tree.grid, occupied, of, view.camera, view.inside);
        double error = 0;
        for (std::size_t s = 0; s < view.skies.size(); ++s) {
          const ShCoefficients radiance = SkyCoefficients(view.skies[s].daylight);
          error = std::max(error, RelativeL2(SkyImage(with, radiance), pixels, truth[s]));
        }
        return error;
      };
      const Cost full = Measure(
          3, [&] { ProjectTransmittance(tree.grid, occupied, {.bands = kBands}); });
      Cost half;
      const double of_swept =
          worst_with(HalfSky(tree.grid, occupied, sky, /*swept=*/true, half));
      const double of_means =
          worst_with(HalfSky(tree.grid, occupied, sky, /*swept=*/false, half));
      fmt::print(
          "  sky at half resolution, worst of {} skies: {:.4f} swept in large voxels "
          "({:.2f} CPU s; {:.2f} in all voxels), {:.4f} by means of voxels (at full "
          "resolution {:.4f})\n",
          view.skies.size(),
          of_swept,
          half.cpu_s,
          full.cpu_s,
          of_means,
          of_view[kBands]);

      // A new hour
      sky_cost = Measure(
          15, [&] { SkyImage(transport, SkyCoefficients(day)); }, true);
      sun_cost = Measure(15, [&] {
        SunImage(transport,
                 SunTransmittance(tree.grid,
                                  occupied,
                                  day.sun_direction,
                                  {.sun_directions = 16, .own_shade = 0}),
                 day.sun_irradiance);
      });
      const Cost point_cost =
          Measure(15, [&] { SunTransmittance(tree.grid, occupied, day.sun_direction); });
      fmt::print("  transmittance to the sun as a point: {:.1f} CPU ms\n",
                 1e3 * point_cost.cpu_s);
      std::atomic<std::uint32_t> seen = 0;
      read_cost = Measure(
          15,
          [&] {
            constexpr int kPiece = 1 << 18;
            ParallelRanges(
                static_cast<int>(transport.sky.size()), kPiece, [&](int begin, int end) {
                  seen ^= ReadThrough(&transport.sky[static_cast<std::size_t>(begin)],
                                      static_cast<std::size_t>(end - begin));
                });
          },
          true);
      fmt::print(
          "  a new hour at {} x {}, {} pixels with volume: sky {:.1f} ms, sun "
          "{:.1f} ms ({:.1f} and {:.1f} CPU ms); reading {:.1f} MB of coefficients "
          "{:.2f} ms\n",
          view.camera.width_px,
          view.camera.height_px,
          transport.pixel.size(),
          1e3 * sky_cost.wall_s,
          1e3 * sun_cost.wall_s,
          1e3 * sky_cost.cpu_s,
          1e3 * sun_cost.cpu_s,
          2e-6 * static_cast<double>(transport.sky.size()),
          1e3 * read_cost.wall_s);
      // What is kept of a voxel: coefficients, the sun's transmittance, its place
      bytes_per_voxel = static_cast<double>(sky.half.size() * sizeof(sky.half[0])) /
                            static_cast<double>(sky.voxels) +
                        sizeof(float) + sizeof(occupied.cell[0]);
    }
  }

  fmt::print("worst over all trees, hours and skies, by bands:");
  int fewest = kMostBands + 1;
  for (const auto& [bands, error] : worst) {
    fmt::print(" {}: {:.4f}", bands, error);
    if (error <= 0.015) fewest = std::min(fewest, bands);
  }
  fmt::print("\n");

  // Growth
  std::vector<std::pair<double, Cost>> growth;
  for (const int cells : {64, 128, 256}) {
    const ExtinctionGrid grid = Crown(cells);
    const OccupiedVoxels occupied = FindOccupied(grid);
    const Cost cost = Measure(cells == 256 ? 1 : 3, [&] {
      ProjectTransmittance(grid, occupied, {.bands = kBands});
    });
    growth.emplace_back(static_cast<double>(occupied.cell.size()), cost);
    fmt::print("crown of {}^3, {} not empty: {:.2f} CPU s, {:.2f} s\n",
               cells,
               occupied.cell.size(),
               cost.cpu_s,
               cost.wall_s);
  }
  const double exponent = std::log(growth[2].second.cpu_s / growth[0].second.cpu_s) /
                          std::log(growth[2].first / growth[0].first);
  fmt::print(
      "sky_error_l2={:.5f} bands={} speedup={:.0f} sky_ms={:.2f} sky_over_read={:.2f} "
      "sun_ms={:.2f} precompute_128_s={:.2f} bytes_per_voxel={:.0f} "
      "growth_exponent={:.3f}\n",
      first_error,
      fewest,
      speedup,
      1e3 * sky_cost.wall_s,
      sky_cost.cpu_s / read_cost.cpu_s,
      1e3 * sun_cost.wall_s,
      growth[1].second.wall_s,
      bytes_per_voxel,
      exponent);
  return 0;
}

}  // namespace
}  // namespace relight

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> folders(argv + 1, argv + argc);
  if (folders.empty()) {
    const char* given = std::getenv("RELIGHT_SHARED");
    const std::filesystem::path shared =
        given != nullptr ? std::filesystem::path(given)
                         : std::filesystem::path(RELIGHT_SOURCE_DIR) / ".." / "shared";
    folders = {shared / "data" / "maple", shared / "data" / "birch"};
  }
  try {
    return relight::Run(folders);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
