// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/prepared_view.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/cameras/level_camera.h"
#include "relight/cameras/photo_orientation.h"
#include "relight/capture/one_photo_camera.h"
#include "relight/capture/sky_in_photo.h"
#include "relight/composite/ground_shadow.h"
#include "relight/photo/color.h"
#include "relight/photo/read_photo.h"
#include "relight/volume/silhouette_volume.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <tuple>

namespace relight {
namespace fs = std::filesystem;
namespace {

// Says what is wrong with the ground: nothing, when the camera and the tree stand on it.
std::string GroundFault(const ExtinctionGrid& grid,
                        const OccupiedVoxels& occupied,
                        const Camera& camera,
                        double ground_z_m) {
  std::ostringstream text;
  text.precision(3);
  text << "the ground at z = " << ground_z_m << " m ";
  const double eye_m = camera.PositionInWorld().z();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3i& cell : occupied.cell) {
    const double z = grid.origin_m.z() + cell.z() * grid.cell_m;
    low = std::min(low, z);
    high = std::max(high, z + grid.cell_m);
  }
  if (eye_m <= ground_z_m) {
    text << "is not below the camera, which is at " << eye_m << " m";
  } else if (GroundShare(camera, ground_z_m) == 0) {
    text << "is not in the picture";
  } else if (low < high && (high <= ground_z_m || low > ground_z_m + (high - low))) {
    text << "is not where the tree stands, which goes from " << low << " to " << high
         << " m";
  } else {
    return {};
  }
  return text.str() + "; give its height with --ground Z_m";
}

// Where a matte's tree stands in its photo.
struct TreeInPhoto {
  Eigen::Vector2d foot_px;
  double top_px = 0;  // Row.
};

TreeInPhoto FindTree(const ViewPlan& plan, const cv::Mat1f& alpha) {
  int top = -1, bottom = -1;
  double foot_sum = 0, foot_count = 0;
  for (int row = 0; row < alpha.rows; ++row) {
    double sum = 0, count = 0;
    for (int column = 0; column < alpha.cols; ++column) {
      if (alpha(row, column) < 0.5f) continue;
      sum += column + 0.5;
      ++count;
    }
    if (count == 0) continue;
    if (top < 0) top = row;
    bottom = row;
    foot_sum = sum;
    foot_count = count;
  }
  if (top < 0) {
    throw InputError(plan.photo.string() +
                     ": its matte holds no tree (no pixel above 0.5); give "
                     "another with --matte");
  }
  return {{foot_sum / foot_count, bottom + 1.0}, static_cast<double>(top)};
}

constexpr double kFarthestTree_m = 300;

// The camera that relight cameras found, with the tree's foot moved to the origin;
// nothing when the foot's ray does not meet the ground near by.
std::optional<LevelCamera> CameraOnGround(const ViewPlan& plan,
                                          const TreeInPhoto& tree,
                                          const cv::Mat1f& alpha,
                                          std::vector<std::string>& notes) {
  const Camera camera = plan.camera_beside->Resized(alpha.cols, alpha.rows);
  const fs::path folder = CameraFolderOf(plan.photo);
  const Eigen::Vector3d eye = camera.PositionInWorld();
  const Eigen::Vector3d ahead =
      DirectionFromAzimuthElevation(AzimuthOf(camera.ForwardInWorld()), 0);
  const Eigen::Vector3d ray = camera.RayInWorld(tree.foot_px);
  const std::optional<Eigen::Vector3d> on_ground = GroundAt(camera, tree.foot_px, 0);
  const double along_ground_m = on_ground ? (*on_ground - eye).dot(ahead) : 0;
  const bool given = plan.request.distance_m.has_value();
  const double distance_m = plan.request.distance_m.value_or(along_ground_m);
  if (!(ray.dot(ahead) > 0.05) || !(distance_m > 0) ||
      (!given && distance_m > kFarthestTree_m)) {
    notes.push_back("the camera of " + folder.string() +
                    " is not used: it does not see ground where the matte ends, at row " +
                    std::to_string(std::lround(tree.foot_px.y())) +
                    "; give --distance M, or make the camera again with its --horizon");
    return std::nullopt;
  }

  LevelCamera found{camera, distance_m, 0};
  const Eigen::Vector3d foot = eye + distance_m / ray.dot(ahead) * ray;
  found.camera.camera_from_world = camera.camera_from_world * Eigen::Translation3d(foot);
  const Eigen::Vector3d to_top = camera.RayInWorld({tree.foot_px.x(), tree.top_px});
  found.tree_height_m =
      eye.z() - foot.z() + distance_m * to_top.z() / std::max(0.05, to_top.dot(ahead));
  std::ostringstream note;
  note.precision(3);
  note << "camera of " << folder.string() << ": " << eye.z() - foot.z()
       << " m above the tree's foot";
  if (given && on_ground) {
    note << " by --distance (its own ground is " << along_ground_m << " m away there)";
  }
  notes.push_back(note.str());
  const double roll_deg =
      DegFromRad(RollOf(Eigen::Vector3d(camera.camera_from_world.linear().col(2))));
  if (std::abs(roll_deg) > 5) {
    note.str("");
    note << "the camera is rolled by " << roll_deg
         << " deg: the silhouette volume takes the photo's rows as level";
    notes.push_back(note.str());
  }
  return found;
}

LevelCamera CameraHeldLevel(const ViewPlan& plan,
                            const TreeInPhoto& tree,
                            const cv::Mat1f& alpha,
                            std::vector<std::string>& notes) {
  double focal_35mm_mm = kPhoneFocal35mm_mm;
  if (plan.focal_35mm_mm) {
    focal_35mm_mm = *plan.focal_35mm_mm;
  } else {
    notes.push_back(
        "no focal length in EXIF: 26 mm (35 mm equivalent), a phone's, is taken");
  }
  LevelCameraOptions options;
  if (plan.request.distance_m) options.distance_m = *plan.request.distance_m;
  return MakeLevelCamera(alpha.cols,
                         alpha.rows,
                         FocalPixelsFrom35mm(focal_35mm_mm, alpha.cols, alpha.rows),
                         RadFromDeg(plan.heading_deg),
                         tree.foot_px,
                         tree.top_px,
                         options);
}

// Camera and volume of one photo alone.
std::pair<Camera, ExtinctionGrid> StandIn(const ViewPlan& plan,
                                          const cv::Mat1f& alpha,
                                          std::vector<std::string>& notes) {
  const TreeInPhoto tree = FindTree(plan, alpha);
  std::optional<LevelCamera> posed;
  if (plan.camera_beside) posed = CameraOnGround(plan, tree, alpha, notes);
  const LevelCamera alone = posed ? *posed : CameraHeldLevel(plan, tree, alpha, notes);
  std::ostringstream note;
  note.precision(3);
  const CrownOptions& crown = plan.options.crown;
  note << "one photo alone: the tree's depth is not known, and is assumed ("
       << (crown.crown == Crown::kAuto ? "each height as deep as it is wide"
                                       : "--crown " + FieldText(crown.crown));
  if (crown.depth_ratio != 1) note << ", --depth-ratio " << crown.depth_ratio;
  note << "); " << alone.tree_height_m << " m high at " << alone.distance_m << " m"
       << (posed || plan.request.distance_m
               ? ""
               : " (8 m high is assumed; --distance M tells better)")
       << (posed ? "" : "; the camera is held level at 1.6 m")
       << ". Photos from several sides give a better result";
  notes.push_back(note.str());
  const ExtinctionGrid grid =
      SilhouetteVolume({plan.name, alone.camera, alpha},
                       alone.distance_m,
                       {.cells = plan.options.volume.cells,
                        .alpha_max = plan.options.volume.alpha_max,
                        .scale = plan.options.volume.scale,
                        .shape = plan.options.crown});
  return {alone.camera, grid};
}

CutOut CutOutAlone(const ViewPlan& plan,
                   const Photo& photo,
                   std::vector<std::string>& notes,
                   const Progress& progress) {
  CutOut cut;
  if (plan.guide && photo.alpha.empty()) {
    PhotoMatte matte = EstimatePhotoMatte(photo,
                                          plan.photo,
                                          *plan.guide,
                                          plan.options.matte,
                                          nullptr,
                                          progress.Part(0, 0.8));
    std::ostringstream note;
    note.precision(2);
    note << "the matte was made from " << matte.made_from << ", sure to "
         << matte.confidence << "; to look at it, and keep it: relight matte "
         << plan.photo.string();
    notes.push_back(note.str());
    notes.insert(notes.end(), matte.doubts.begin(), matte.doubts.end());
    cut.alpha = matte.alpha;
    cut.matte_source = matte.made_from;
    cut.foreground = ForegroundOf(photo, cut.alpha, matte.screen, progress.Part(0.8, 1));
    return cut;
  }
  if (plan.request.matte) {
    cut.alpha = ReadMatteFor(*plan.request.matte, photo.pixels.size(), plan.photo);
    cut.matte_source = plan.request.matte->string();
  } else {
    cut.alpha = photo.alpha;
    cut.matte_source = "the photo's alpha";
  }
  cut.foreground = ForegroundOf(photo, cut.alpha, {}, progress);
  return cut;
}

// The model of the light has a turbidity, and the user leaves it to the photos.
bool AirIsAsked(const ViewPlan& plan) {
  return plan.options.light.method == Method::kDefault && !plan.options.light.turbidity;
}

using Begin = std::function<Progress(const std::string& stage)>;

// The stage that follows those of every view.
Progress BeginVerb(const ViewPlan& plan, const Begin& begin) {
  for (const PlannedStage& stage : plan.stages) {
    if (stage.name != "mattes" && stage.name != "volume" && stage.name != "light")
      return begin(stage.name);
  }
  return {};
}

// One picture, but for what two decoders of a JPEG make of it and for 8 bits: luma within
// two steps in each pixel; colour, which a JPEG may hold at half the size, in the mean
// over the 8 x 8 pixels of a block.
bool LooksLike(const Photo& picture, const Photo& photo) {
  constexpr double kTwoSteps = 2.5 / 255;
  const cv::Size size = photo.pixels.size();
  if (picture.pixels.size() != size || picture.alpha.empty() != photo.alpha.empty())
    return false;
  const cv::Mat3f apart =
      DisplayFromLinear(picture.pixels) - DisplayFromLinear(photo.pixels);
  cv::Mat1f luma;
  cv::transform(apart, luma, cv::Matx13f(0.299f, 0.587f, 0.114f));
  cv::Mat3f blocks;
  cv::resize(
      apart, blocks, {(size.width + 7) / 8, (size.height + 7) / 8}, 0, 0, cv::INTER_AREA);
  return cv::norm(luma, cv::NORM_INF) <= kTwoSteps &&
         cv::norm(blocks, cv::NORM_INF) <= kTwoSteps &&
         (photo.alpha.empty() ||
          cv::norm(picture.alpha, photo.alpha, cv::NORM_INF) <= kTwoSteps);
}

// Means over areas of colours that count as much as their alpha does.
cv::Mat3f SmallerColors(const cv::Mat3f& colors, const cv::Mat1f& alpha, cv::Size size) {
  // Where there is no tree its colours go on, for they are defined there too
  const cv::Mat1f weight = alpha + 1e-3f;
  cv::Mat1f small_weight;
  cv::resize(weight, small_weight, size, 0, 0, cv::INTER_AREA);
  cv::Mat3f weighted(colors.size()), small;
  weighted.forEach([&](cv::Vec3f& color, const int* at) {
    color = colors(at[0], at[1]) * weight(at[0], at[1]);
  });
  cv::resize(weighted, small, size, 0, 0, cv::INTER_AREA);
  small.forEach(
      [&](cv::Vec3f& color, const int* at) { color /= small_weight(at[0], at[1]); });
  return small;
}

// Throws InputError when photo and camera are not of one shape.
Camera CameraFor(const cv::Mat3f& pixels, const Camera& camera, const fs::path& file) {
  const double stretch = static_cast<double>(pixels.cols) * camera.height_px /
                         (static_cast<double>(pixels.rows) * camera.width_px);
  if (std::abs(stretch - 1) <= 0.01) return camera.Resized(pixels.cols, pixels.rows);
  throw InputError(file.string() + ": is " + std::to_string(pixels.cols) + " x " +
                   std::to_string(pixels.rows) + " pixels, its camera " +
                   std::to_string(camera.width_px) + " x " +
                   std::to_string(camera.height_px) +
                   ": not the same picture; give one of the camera's proportions");
}

void PrepareOfCapture(const ViewPlan& plan, const Begin& begin, PreparedView& view) {
  const Capture& capture = *plan.capture;
  const CaptureOptions& options = plan.options;
  const bool force = plan.request.force;
  StageRecords records(capture.folder);
  const std::map<std::string, Camera> cameras =
      CamerasToMatte(capture, options, {plan.name});

  // Mattes of the views, the volume from them, its transmittance
  CaptureMattes maker(capture, records, options);
  const Progress mattes = begin("mattes");
  const auto count = static_cast<double>(cameras.size());
  double done = 0;
  for (const auto& [name, camera] : cameras) {
    const ViewEntry& entry = FindView(capture, name);
    if (maker.Make(entry, force, mattes.Part(done / count, (done + 1) / count))) {
      const MatteReport report = maker.ReportOf(entry);
      for (const std::string& doubt : report.doubts) {
        view.notes.push_back(name + ": " + doubt);
      }
    }
    ++done;
  }
  if (VolumeIsStale(capture, records, options, force)) {
    const MadeVolume made = MakeVolume(capture, records, options, begin("volume"));
    const OpacitySummary& summary = made.summary;
    if (const std::string words = AgreementInWords(made.agreement); !words.empty())
      view.notes.push_back(words);
    if (made.box_needed_points) {
      view.notes.push_back("the volume's box is from " + made.box_from +
                           "; --box takes another");
    }
    if (summary.residual_rms > 0.35) {
      view.notes.push_back(
          "the volume fits its mattes badly (rms " +
          std::to_string(summary.residual_rms).substr(0, 4) +
          "): cameras and mattes may not belong together; look at volume.vdb");
    }
  }
  view.tree = TreeOf(capture, records, options, force, begin("light"));
  view.volume_views = VolumeCamerasOf(capture, options).size();

  // The view's own pixels
  view.progress = BeginVerb(plan, begin);
  const Progress reading = view.progress.Part(0, 0.3);
  const ViewEntry& entry = FindView(capture, plan.name);
  view.photo = PixelsOf(plan);
  bool other = plan.request.photo.has_value();
  if (plan.request.picture) {
    Photo own = ReadPhoto(plan.photo, options.photo);
    other = !LooksLike(view.photo, own);
    if (!other) view.photo = std::move(own);
  }
  const bool own_alpha = !view.photo.alpha.empty();
  if (plan.request.matte || (other && own_alpha)) {
    view.cut = CutOutAlone(plan, view.photo, view.notes, reading);
  } else if (other) {
    const auto matte = FileOfView(capture, "mattes", entry.name);
    view.cut.alpha =
        matte ? ReadMatteFor(*matte, view.photo.pixels.size(), plan.PhotoFile())
              : MatteOf(capture, entry);
    view.cut.foreground = ForegroundOf(view.photo, view.cut.alpha, {}, reading);
  } else {
    view.cut = CutOutOf(capture, entry, view.photo, records, options.photo, reading);
  }
  view.camera = CameraFor(view.photo.pixels, cameras.at(plan.name), plan.PhotoFile());
  if (AirIsAsked(plan)) view.air = TurbidityOfCapture(plan, cameras, records);
}

void PrepareAlone(const ViewPlan& plan, const Begin& begin, PreparedView& view) {
  view.photo = PixelsOf(plan);
  if (plan.guide) {
    view.cut = CutOutAlone(plan, view.photo, view.notes, begin("mattes"));
    begin("volume");
  } else {
    view.cut = CutOutAlone(plan, view.photo, view.notes, begin("volume"));
  }
  std::tie(view.camera, view.tree.grid) = StandIn(plan, view.cut.alpha, view.notes);
  view.tree.occupied = FindOccupied(view.tree.grid);
  view.tree.occluder = OccluderOf(plan.options);
  view.tree.sky_transmittance = ProjectTransmittance(view.tree.grid,
                                                     view.tree.occupied,
                                                     plan.options.sky_transmittance,
                                                     begin("light"),
                                                     view.tree.occluder.get(),
                                                     plan.options.transport.clumping);
  view.progress = BeginVerb(plan, begin);
  if (AirIsAsked(plan)) {
    std::vector<SkySample> samples;
    if (view.photo.alpha.empty()) {
      samples = SkySamples(view.photo.pixels,
                           view.cut.alpha,
                           view.camera,
                           plan.input.sun.direction,
                           /*photo=*/0);
    }
    view.air = TurbidityFromSky(samples);
  }
}

std::string AirInWords(const TurbidityEstimate& air) {
  std::ostringstream text;
  text.precision(2);
  if (air.sure) {
    text << "turbidity " << air.turbidity << " by the sky of "
         << (air.photos == 1 ? "the photo" : std::to_string(air.photos) + " photos");
    if (air.deepened > 1) {
      text << ", whose colours the camera deepens by " << air.deepened;
    }
    text << ", sure to " << std::ceil(100 * air.spread) << " %";
  } else {
    text << "the photos do not tell the haze of the air (" << air.doubt << "): turbidity "
         << kUsualTurbidity << " is taken";
  }
  return text.str() + "; --turbidity T says better";
}

}  // namespace

PreparedView PrepareView(const ViewPlan& plan, const StageStart& start) {
  PreparedView view;
  const Begin begin = [&](const std::string& name) {
    for (const PlannedStage& stage : plan.stages) {
      if (start && stage.name == name) return start(stage);
    }
    return Progress();
  };
  if (plan.capture) {
    PrepareOfCapture(plan, begin, view);
  } else {
    PrepareAlone(plan, begin, view);
  }
  view.notes.insert(view.notes.end(), view.photo.notes.begin(), view.photo.notes.end());
  if (view.air) view.notes.push_back(AirInWords(*view.air));
  view.ground_fault = GroundFault(
      view.tree.grid, view.tree.occupied, view.camera, plan.options.shadow.ground_z_m);
  view.progress = view.progress.Part(0.3, 1);
  return view;
}

PreparedView Smaller(const PreparedView& view, int longest_px) {
  const cv::Size size = view.photo.pixels.size();
  const double shrink =
      std::max(size.width, size.height) / static_cast<double>(longest_px);
  if (shrink <= 1) return view;
  const cv::Size small(std::max(1, static_cast<int>(std::lround(size.width / shrink))),
                       std::max(1, static_cast<int>(std::lround(size.height / shrink))));
  const auto by_area = [&](const auto& image) {
    std::decay_t<decltype(image)> result;
    if (!image.empty()) cv::resize(image, result, small, 0, 0, cv::INTER_AREA);
    return result;
  };
  PreparedView result = view;
  result.photo.pixels = view.photo.alpha.empty()
                            ? by_area(view.photo.pixels)
                            : SmallerColors(view.photo.pixels, view.photo.alpha, small);
  result.photo.alpha = by_area(view.photo.alpha);
  result.cut.foreground = SmallerColors(view.cut.foreground, view.cut.alpha, small);
  result.cut.alpha = by_area(view.cut.alpha);
  result.camera = view.camera.Resized(small.width, small.height);
  return result;
}

}  // namespace relight
