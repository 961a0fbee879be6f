// SPDX-License-Identifier: Apache-2.0

// How right and how fast the volume is, on rendered trees whose foliage is known.
//
//   benchmark_volume [TREE …]           folders of the layout of shared data/maple
//   benchmark_volume scale [TREE …]     time a crossing, and memory, up to 512 cells
//
// Each method is given true mattes and cameras. Held out: each of the views 0, 3, 6 and 9
// is left out in turn, and its matte compared with the volume's over 0.10 m at the tree.

#include "relight/base/error.h"
#include "relight/cameras/colmap_model.h"
#include "relight/photo/image_file.h"
#include "relight/volume/opacity_estimation.h"
#include "relight/volume/ray_traversal.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace relight {
namespace {

namespace fs = std::filesystem;

struct TrueTree {
  std::string name;
  std::vector<MatteView> views;
  Eigen::AlignedBox3d box;
  struct Face {
    Eigen::Vector3d center;
    double area_m2;
    bool is_leaf;
  };
  std::vector<Face> faces;
};

TrueTree ReadTree(const fs::path& folder) {
  TrueTree tree;
  tree.name = folder.filename().string();
  for (const NamedCamera& named : ReadColmap(folder / "sparse").cameras) {
    tree.views.push_back(
        {named.view, named.camera, ReadMatte(folder / "alpha" / (named.view + ".png"))});
  }
  std::ifstream truth_file(folder / "capture_truth.json");
  const auto truth = nlohmann::json::parse(truth_file);
  for (int axis = 0; axis < 3; ++axis) {
    tree.box.min()[axis] = truth["bbox_min_m"][axis].get<double>() - 0.15;
    tree.box.max()[axis] = truth["bbox_max_m"][axis].get<double>() + 0.15;
  }
  std::ifstream file(folder / "foliage.ply", std::ios::binary);
  const std::string ply((std::istreambuf_iterator<char>(file)), {});
  const std::size_t begin = ply.find("end_header\n");
  if (begin == std::string::npos) throw InputError(folder.string() + ": no foliage.ply");
  constexpr std::size_t kBytes = 7 * sizeof(float) + 1;
  for (std::size_t at = begin + 11; at + kBytes <= ply.size(); at += kBytes) {
    float values[7];
    std::memcpy(values, ply.data() + at, sizeof(values));
    tree.faces.push_back(
        {{values[0], values[1], values[2]}, values[6], ply[at + sizeof(values)] != 0});
  }
  return tree;
}

// Half the leaf area and a quarter of the bark area per volume [1/m].
ExtinctionGrid FoliageOf(const TrueTree& tree, const ExtinctionGrid& like) {
  ExtinctionGrid foliage{NoBricks(like.cells, like.origin_m, like.cell_m), {}};
  for (const TrueTree::Face& face : tree.faces) {
    const Eigen::Vector3i at =
        ((face.center - like.origin_m) / like.cell_m).array().floor().cast<int>();
    if ((at.array() < 0).any() || (at.array() >= like.cells.array()).any()) continue;
    foliage.Add(at.x(),
                at.y(),
                at.z(),
                static_cast<float>((face.is_leaf ? 0.5 : 0.25) * face.area_m2 /
                                   std::pow(like.cell_m, 3)));
  }
  return foliage;
}

// Calls visit(value of a, value of b) for each voxel of the box where one of them is
// above 0, in the order of the box.
template <class Visit>
void ForEachPair(const ExtinctionGrid& a, const ExtinctionGrid& b, Visit&& visit) {
  BrickVoxels either = a;
  for (const Eigen::Vector3i& low : b.brick_at) either.Make(low.x(), low.y(), low.z());
  ForEachVoxel(either, [&](int x, int y, int z, std::size_t) {
    visit(double(a.At(x, y, z)), double(b.At(x, y, z)));
  });
}

// Over all voxels of the box.
double Correlation(const ExtinctionGrid& a, const ExtinctionGrid& b) {
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  const auto n = static_cast<double>(a.Count());
  ForEachPair(a, b, [&](double va, double vb) {
    sa += va;
    sb += vb;
    saa += va * va;
    sbb += vb * vb;
    sab += va * vb;
  });
  return (sab - sa * sb / n) / std::sqrt((saa - sa * sa / n) * (sbb - sb * sb / n));
}

double RelativeL1(const ExtinctionGrid& a, const ExtinctionGrid& truth) {
  double apart = 0, all = 0;
  ForEachPair(a, truth, [&](double va, double vt) {
    apart += std::abs(va - vt);
    all += vt;
  });
  return apart / all;
}

double Seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void Judge(const TrueTree& tree, const OpacityOptions& options, const std::string& name) {
  std::vector<double> held;
  for (const std::size_t out : {0, 3, 6, 9}) {
    std::vector<MatteView> others = tree.views;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(out));
    const auto estimate = EstimateOpacity(others, tree.box, options);
    held.push_back(MatteRmse(estimate.grid, tree.views[out]));
  }
  const double begin = Seconds(CLOCK_MONOTONIC);
  const auto [grid, summary] = EstimateOpacity(tree.views, tree.box, options);
  const double seconds = Seconds(CLOCK_MONOTONIC) - begin;
  double used = 0;
  for (const MatteView& view : tree.views) used += MatteRmse(grid, view);
  const ExtinctionGrid foliage = FoliageOf(tree, grid);
  fmt::print(
      "| {} | {} | {} | {:.4f} | {:.4f} {:.4f} {:.4f} {:.4f} | {:.4f} | {:.3f} | {:.2f} "
      "| {} | "
      "{:.1f} |\n",
      tree.name,
      options.cells,
      name,
      (held[0] + held[1] + held[2] + held[3]) / 4,
      held[0],
      held[1],
      held[2],
      held[3],
      used / static_cast<double>(tree.views.size()),
      Correlation(grid, foliage),
      RelativeL1(grid, foliage),
      summary.occupied_voxels,
      seconds);
  std::fflush(stdout);
}

double PeakMegabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

// CPU time of all threads a crossing of a ray and a voxel, beside that of a traversal of
// the same voxels that only adds up lengths.
void Scale(const TrueTree& tree, int cells) {
  const auto run = [&](int passes) {
    const double begin = Seconds(CLOCK_PROCESS_CPUTIME_ID);
    Tomography found =
        EstimateTomography(tree.views, tree.box, {.cells = cells, .passes = passes});
    return std::pair(Seconds(CLOCK_PROCESS_CPUTIME_ID) - begin, std::move(found));
  };
  const auto [few_s, few] = run(1);
  const auto [more_s, found] = run(3);
  const double pass_ns =
      1e9 * (more_s - few_s) / static_cast<double>(found.crossings - few.crossings);

  std::uint64_t crossings = 0;
  double length = 0;
  const double begin = Seconds(CLOCK_PROCESS_CPUTIME_ID);
  for (const MatteView& view : tree.views) {
    for (int row = 0; row < view.camera.height_px; ++row) {
      for (int column = 0; column < view.camera.width_px; ++column) {
        const Ray ray{view.camera.PositionInWorld(),
                      view.camera.RayInWorld({column + 0.5, row + 0.5})};
        TraverseRay(found.grid, ray, 0.0, [&](std::size_t, double, double length_m) {
          length += length_m;
          ++crossings;
          return true;
        });
      }
    }
  }
  const double length_ns =
      1e9 * (Seconds(CLOCK_PROCESS_CPUTIME_ID) - begin) / static_cast<double>(crossings);
  const OccupiedVoxels occupied = FindOccupied(found.grid);
  const auto bytes = static_cast<double>(found.grid.Bytes() + occupied.Bytes());
  fmt::print(
      "| {} | {} | {} | {:.1f} | {:.1f} | {:.2f} | {:.0f} | {:.1f} | {:.2f} | {:.3g} |\n",
      tree.name,
      cells,
      found.grid.brick_at.size(),
      pass_ns,
      length_ns,
      pass_ns / length_ns,
      PeakMegabytes(),
      bytes / static_cast<double>(occupied.cell.size()),
      bytes / static_cast<double>(found.grid.Count()),
      length);
  std::fflush(stdout);
}

int Run(int count, char** words) {
  const char* shared = std::getenv("RELIGHT_SHARED");
  const fs::path data =
      fs::path(shared ? shared : RELIGHT_SOURCE_DIR "/../shared") / "data";
  const bool scale = count > 1 && std::string(words[1]) == "scale";
  std::vector<fs::path> trees(words + (scale ? 2 : 1), words + count);
  if (trees.empty() && scale) trees = {data / "maple"};
  if (trees.empty()) trees = {data / "maple", data / "birch"};
  if (scale) {
    fmt::print(
        "| tree | cells | bricks | ns a crossing | ns, lengths only | ratio | peak MB | "
        "bytes a voxel that is occupied | bytes a voxel of the box | metres |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const fs::path& folder : trees) {
      const TrueTree tree = ReadTree(folder);
      for (const int cells : {64, 128, 256, 512}) Scale(tree, cells);
    }
    return 0;
  }
  fmt::print(
      "| tree | cells | method | held-out RMSE | views 0, 3, 6, 9 | on views used | "
      "correlation with the foliage | relative L1 | voxels | s |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const fs::path& folder : trees) {
    const TrueTree tree = ReadTree(folder);
    for (const int cells : {64, 100, 128}) {
      Judge(tree, {.method = VolumeMethod::kReche2004, .cells = cells}, "reche2004");
      Judge(tree, {.cells = cells}, "tomography");
    }
  }
  return 0;
}

}  // namespace
}  // namespace relight

int main(int count, char** words) {
  try {
    return relight::Run(count, words);
  } catch (const std::exception& error) {
    fmt::print(stderr, "benchmark_volume: {}\n", error.what());
    return 1;
  }
}
