// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/tree_volume.h"

#include "relight/base/error.h"
#include "relight/base/version.h"
#include "relight/capture/capture_cameras.h"
#include "relight/capture/capture_folder.h"
#include "relight/capture/view_matte.h"
#include "relight/volume/point_bounds.h"
#include "relight/volume/vdb_file.h"
#include "relight/volume/visual_hull.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr const char* kVolumeStage = "volume";
constexpr const char* kLightStage = "light";
const fs::path kVolumeFile = "volume.vdb";
const fs::path kLightFile = fs::path("cache") / "light.vdb";

// Whether it has more lines than those of its head.
bool HoldsPoints(const fs::path& points_txt) {
  std::ifstream in(points_txt);
  std::string line;
  while (std::getline(in, line)) {
    if (!line.empty() && line.front() != '#') return true;
  }
  return false;
}

std::vector<Eigen::Vector3d> PointsOf(const Capture& capture) {
  std::vector<Eigen::Vector3d> points;
  for (const ScenePoint& point : SceneOf(capture).points)
    points.push_back(point.position);
  return points;
}

std::string VolumeKey(const Capture& capture, const CaptureOptions& options) {
  StageKey key("volume 2");
  key.Add(FieldsText(options.volume));
  if (!options.box.box.empty()) key.Add(options.box.box);
  key.AddFile(capture.folder / "cameras" / "cameras.txt");
  key.AddFile(capture.folder / "cameras" / "images.txt");
  const fs::path points = capture.folder / "cameras" / "points3D.txt";
  if (HoldsPoints(points)) key.AddFile(points);
  for (const auto& [name, camera] : VolumeCamerasOf(capture, options)) {
    const auto matte = FileOfView(capture, "mattes", name);
    key.Add(name).AddFile(matte ? *matte : capture.PhotoOf(FindView(capture, name)));
  }
  return key.Hash();
}

std::string LightKey(const Capture& capture, const CaptureOptions& options) {
  StageKey key("light 2");
  key.Add(FieldsText(options.sky_transmittance)).AddFile(capture.folder / kVolumeFile);
  if (options.transport.clumping > 0) key.Add(FieldText(options.transport.clumping));
  if (!options.neighbours.occluder.empty()) key.AddFile(options.neighbours.occluder);
  return key.Hash();
}

struct Estimate {
  OpacityEstimate volume;
  std::string box_from;
  MatteAgreement agreement;
  bool box_needed_points = false;
};

// "the mattes; south, east within 812 sparse points of the tree".
std::string BoxFrom(const CutBox& cut, std::size_t points, bool are_central) {
  std::string from = "the mattes";
  const std::string of_tree = std::to_string(points) + " sparse points of the tree";
  if (are_central) from += ", around the middle of " + of_tree;
  if (cut.sides.empty()) return from;
  std::string sides;
  for (const std::string& side : cut.sides) sides += (sides.empty() ? "" : ", ") + side;
  return from + "; " + sides + " cut to " + of_tree;
}

// The volume within the mattes' hull, cut where sparse points end before it; or within
// what the user's box has of the hull.
Estimate EstimateWithin(const Capture& capture,
                        std::span<const MatteView> views,
                        const CaptureOptions& options,
                        const Progress& progress) {
  const std::string& given = options.box.box;
  VoxelBox within{{}, options.volume.cells};
  if (!given.empty()) within.bounds = BoxFromText(given);
  const std::vector<Eigen::Vector3d> points = PointsOfTree(views, PointsOf(capture));
  OpacityOptions volume = options.volume;
  Estimate estimate;
  if (!volume.kth_smallest) {
    estimate.agreement = AgreementOf(views, progress.Part(0, 0.01));
    volume.kth_smallest = estimate.agreement.kth_smallest;
  }
  HullOptions hull_options{.kth_smallest = *volume.kth_smallest};
  const bool are_central = !points.empty() && IsDepthOpen(views);
  if (are_central) hull_options.middle = MiddleOf(points);
  const Eigen::AlignedBox3d hull =
      HullBounds(views, hull_options, progress.Part(0.01, 0.04));
  estimate.box_from = "--box";
  if (given.empty()) {
    const CutBox cut = CutToPoints(hull, points, views, progress.Part(0.04, 0.05));
    within.bounds = cut.bounds;
    estimate.box_from = BoxFrom(cut, points.size(), are_central);
    estimate.box_needed_points = are_central || !cut.sides.empty();
  } else {
    within = PartWithin(within.bounds, within.cells, hull);
  }
  constexpr int kFewest = 8;
  if (within.cells < kFewest) {
    throw InputError("the tree has only " + std::to_string(within.cells) + " of the " +
                     std::to_string(options.volume.cells) +
                     " voxels along the box that is given; give a smaller --box or more "
                     "--cells");
  }
  volume.cells = within.cells;
  estimate.volume = EstimateOpacity(views, within.bounds, volume, progress.Part(0.05, 1));
  return estimate;
}

bool IsStale(StageRecords::State state) {
  return state == StageRecords::State::kMissing || state == StageRecords::State::kStale;
}

}  // namespace

std::shared_ptr<const Occluder> OccluderOf(const CaptureOptions& options) {
  const std::string& file = options.neighbours.occluder;
  if (file.empty()) return nullptr;
  return std::make_shared<const Occluder>(ReadOccluder(file));
}

std::map<std::string, Camera> VolumeCamerasOf(const Capture& capture,
                                              const CaptureOptions& options) {
  return EvenlySpreadViews(CamerasOf(capture), options.selection);
}

std::map<std::string, Camera> CamerasToMatte(const Capture& capture,
                                             const CaptureOptions& options,
                                             const std::vector<std::string>& others) {
  const std::map<std::string, Camera> all = CamerasOf(capture);
  std::map<std::string, Camera> chosen = EvenlySpreadViews(all, options.selection);
  for (const std::string& view : others) {
    if (const auto found = all.find(view); found != all.end()) chosen.insert(*found);
  }
  return chosen;
}

std::string SelectionNote(const Capture& capture, const CaptureOptions& options) {
  const std::size_t all = CamerasOf(capture).size();
  const std::size_t chosen = VolumeCamerasOf(capture, options).size();
  constexpr std::size_t kFew = 4;
  if (chosen == all) {
    if (chosen < 2 || chosen >= kFew) return "";
    return "the volume is reconstructed from " + std::to_string(chosen) +
           " views only: how deep the tree is between them is a guess (four views or "
           "more, evenly around the tree, mend that)";
  }
  return "mattes and volume are made from " + std::to_string(chosen) + " of " +
         std::to_string(all) +
         " views, evenly around the tree (--most-views N takes more or fewer)";
}

std::vector<MatteView> MatteViewsOf(const Capture& capture,
                                    const CaptureOptions& options) {
  // A crown that fills the frame has some 6 pixels a voxel then; finer rays only cost
  // time
  const int longest_px = std::max(600, 6 * options.volume.cells);
  std::vector<MatteView> views;
  for (const auto& [name, camera] : VolumeCamerasOf(capture, options)) {
    MatteView view{name, camera, MatteOf(capture, FindView(capture, name))};
    const double stretch = static_cast<double>(view.alpha.cols) * camera.height_px /
                           (static_cast<double>(view.alpha.rows) * camera.width_px);
    if (std::abs(stretch - 1) > 0.01) {
      throw InputError(name + ": the matte is " + std::to_string(view.alpha.cols) +
                       " x " + std::to_string(view.alpha.rows) + " pixels, the camera " +
                       std::to_string(camera.width_px) + " x " +
                       std::to_string(camera.height_px) +
                       ": not the same picture; make the matte at the photo's size");
    }
    cv::Size size = view.alpha.size();
    const double shrink =
        std::max(size.width, size.height) / static_cast<double>(longest_px);
    if (shrink > 1.0) {
      size = {std::max(1, static_cast<int>(std::lround(size.width / shrink))),
              std::max(1, static_cast<int>(std::lround(size.height / shrink)))};
      cv::resize(view.alpha, view.alpha, size, 0, 0, cv::INTER_AREA);
    }
    view.camera = camera.Resized(size.width, size.height);
    views.push_back(std::move(view));
  }
  return views;
}

bool VolumeIsStale(const Capture& capture,
                   const StageRecords& records,
                   const CaptureOptions& options,
                   bool force) {
  if (force) return true;
  if (VolumeIsEdited(capture, records)) return false;
  return IsStale(records.StateOf(kVolumeStage, VolumeKey(capture, options)));
}

bool VolumeIsEdited(const Capture& capture, const StageRecords& records) {
  const fs::path file = capture.folder / kVolumeFile;
  if (!fs::exists(file)) return false;
  const auto state = records.StateOf(kVolumeStage, "");
  if (state == StageRecords::State::kEdited) return true;
  // Without a record: one that was made from mattes says from which
  return state == StageRecords::State::kMissing && !ReadMetadata(file).contains("inputs");
}

bool LightIsStale(const Capture& capture,
                  const StageRecords& records,
                  const CaptureOptions& options,
                  bool force) {
  if (force || !fs::exists(capture.folder / kVolumeFile)) return true;
  return records.StateOf(kLightStage, LightKey(capture, options)) !=
         StageRecords::State::kUpToDate;
}

MadeVolume MakeVolume(const Capture& capture,
                      StageRecords& records,
                      const CaptureOptions& options,
                      const Progress& progress) {
  const std::vector<MatteView> views = MatteViewsOf(capture, options);
  const auto [estimate, box_from, agreement, needed_points] =
      EstimateWithin(capture, views, options, progress);
  std::string names, objective;
  for (const MatteView& view : views) names += (names.empty() ? "" : ", ") + view.name;
  for (const double value : estimate.summary.objective) {
    objective += (objective.empty() ? "" : " ") + FieldText(value);
  }
  const std::string key = VolumeKey(capture, options);
  WriteVolume(capture.folder / kVolumeFile,
              estimate.grid,
              {{"software", std::string("relight ") + Version()},
               {"options", FieldsText(options.volume)},
               {"frame", "east, north, up; metres"},
               {"inputs", key},
               {"views", names},
               {"box_from", box_from},
               {"residual_rms", FieldText(estimate.summary.residual_rms)},
               {"hidden_voxels", std::to_string(estimate.summary.hidden_voxels)},
               {"objective", objective}});
  records.Remember(kVolumeStage, key, {kVolumeFile});
  return {estimate.summary, box_from, agreement, needed_points};
}

std::string AgreementInWords(const MatteAgreement& agreement) {
  if (agreement.kth_smallest == 1) return "";
  const auto percent = [](double share) {
    return std::to_string(std::lround(100 * share)) + " %";
  };
  return "bad mattes take away " + percent(agreement.lost) +
         " of the tree that the others show: what all but two show is kept, and " +
         percent(agreement.left) +
         " are still lost; look at the mattes (--kth-smallest 1 believes them all)";
}

HeldOut JudgeVolume(const Capture& capture,
                    const CaptureOptions& options,
                    const std::string& left_out,
                    const Progress& progress) {
  std::vector<MatteView> views = MatteViewsOf(capture, options);
  const auto out = std::find_if(views.begin(), views.end(), [&](const MatteView& view) {
    return view.name == left_out;
  });
  if (out == views.end()) {
    std::string names;
    for (const MatteView& view : views) names += (names.empty() ? "" : ", ") + view.name;
    throw InputError("leave-out: \"" + left_out +
                     "\" is none of the views that the volume is made from; they are " +
                     names);
  }
  const MatteView held = *out;
  views.erase(out);
  OpacityEstimate estimate = EstimateWithin(capture, views, options, progress).volume;
  HeldOut judged{MatteRmse(estimate.grid, held), 0.0, std::move(estimate.summary)};
  for (const MatteView& view : views) {
    judged.rmse_used +=
        MatteRmse(estimate.grid, view) / static_cast<double>(views.size());
  }
  return judged;
}

Tree TreeOf(const Capture& capture,
            StageRecords& records,
            const CaptureOptions& options,
            bool force,
            const Progress& progress) {
  Tree tree;
  tree.grid = ReadVolume(capture.folder / kVolumeFile);
  tree.occupied = FindOccupied(tree.grid);
  tree.occluder = OccluderOf(options);
  const int bands = options.sky_transmittance.bands;
  if (!LightIsStale(capture, records, options, force)) {
    tree.sky_transmittance = PackedSky(
        bands, ReadChannels(capture.folder / kLightFile, tree.grid, "sh", bands * bands));
    return tree;
  }
  tree.sky_transmittance = ProjectTransmittance(tree.grid,
                                                tree.occupied,
                                                options.sky_transmittance,
                                                progress,
                                                tree.occluder.get(),
                                                options.transport.clumping);
  const fs::path folder = MakeFolderOf(capture.folder, kLightFile.parent_path());
  // Floats in the file; what is too large to keep is made again each time
  const std::uintmax_t bytes =
      2 * sizeof(std::uint16_t) * tree.sky_transmittance.half.size();
  if (bytes > kMostLightBytes || fs::is_symlink(folder / kLightFile.filename())) {
    return tree;
  }
  WriteChannels(
      capture.folder / kLightFile, tree.grid, "sh", UnpackedSky(tree.sky_transmittance));
  records.Remember(kLightStage, LightKey(capture, options), {kLightFile});
  return tree;
}

std::optional<LightCache> LightCacheOf(const Capture& capture) {
  const fs::path file = capture.folder / kLightFile;
  if (!fs::is_regular_file(fs::symlink_status(file))) return std::nullopt;
  return LightCache{
      file, fs::file_size(file), StageRecords(capture.folder).IsOurs(kLightFile)};
}

std::optional<LightCache> CleanLight(const Capture& capture) {
  const std::optional<LightCache> cache = LightCacheOf(capture);
  if (!cache || !cache->is_ours) return cache;
  MakeFolderOf(capture.folder, kLightFile.parent_path());  // Not out of the capture
  std::error_code error;
  fs::remove(cache->file, error);
  if (error) {
    throw InputError(cache->file.string() + ": cannot be removed (" + error.message() +
                     ")");
  }
  return cache;
}

}  // namespace relight
