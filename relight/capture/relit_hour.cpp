// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/relit_hour.h"

#include "relight/base/angles.h"
#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/field_text.h"
#include "relight/base/version.h"
#include "relight/cameras/level_camera.h"
#include "relight/capture/capture_folder.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/composite/montage.h"
#include "relight/composite/open_raster.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/photo_facts.h"
#include "relight/ratio/relight_view.h"
#include "relight/volume/silhouette_volume.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

// --- Ground --------------------------------------------------------------------------

// The tree's shadow is wanted, in a file of its own or below the tree.
bool ShadowIsAsked(const HourRequest& r, const fs::path& output) {
  return r.shadow || r.over || output.extension() == kLayers;
}
bool OldShadowGoes(const HourRequest& r) { return r.whole && !r.keep_shadow; }

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

// The view as it is relit.
struct Subject {
  Photo photo;
  CutOut cut;
  Camera camera;
};

// Camera and volume of one photo alone.
std::pair<Camera, ExtinctionGrid> StandIn(const HourPlan& plan,
                                          const cv::Mat1f& alpha,
                                          std::vector<std::string>& notes) {
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
  const PhotoFacts facts = ReadPhotoFacts(plan.photo);
  double focal_35mm_mm = kPhoneFocal35mm_mm;
  if (facts.focal_35mm_mm) {
    focal_35mm_mm = *facts.focal_35mm_mm;
  } else {
    notes.push_back(
        "no focal length in EXIF: 26 mm (35 mm equivalent), a phone's, is taken");
  }
  LevelCameraOptions options;
  if (plan.request.distance_m) options.distance_m = *plan.request.distance_m;
  const LevelCamera level =
      MakeLevelCamera(alpha.cols,
                      alpha.rows,
                      FocalPixelsFrom35mm(focal_35mm_mm, alpha.cols, alpha.rows),
                      RadFromDeg(plan.heading_deg),
                      {foot_sum / foot_count, bottom + 1.0},
                      top,
                      options);
  std::ostringstream note;
  note.precision(3);
  note << "one photo alone: the tree's depth is not known, and its volume is a round "
          "silhouette ("
       << "each row as deep as it is wide), " << level.tree_height_m << " m high at "
       << level.distance_m << " m"
       << (plan.request.distance_m ? ""
                                   : " (8 m high is assumed; --distance M tells better)")
       << "; the camera is held level at 1.6 m. Photos from several sides give a better "
          "result";
  notes.push_back(note.str());
  const ExtinctionGrid grid =
      SilhouetteVolume({plan.view, level.camera, alpha},
                       level.distance_m,
                       {.cells = plan.options.volume.cells,
                        .alpha_max = plan.options.volume.alpha_max,
                        .scale = plan.options.volume.scale});
  return {level.camera, grid};
}

CutOut CutOutAlone(const HourPlan& plan, const Photo& photo, const Progress& progress) {
  CutOut cut;
  if (plan.request.matte) {
    cut.alpha = ReadMatteFor(*plan.request.matte, photo.pixels.size(), plan.photo);
    cut.matte_source = plan.request.matte->string();
  } else {
    cut.alpha = photo.alpha;
    cut.matte_source = "the photo's alpha";
  }
  cut.foreground = ForegroundOf(photo, cut.alpha, progress);
  return cut;
}

double Luminance(const cv::Vec3f& c) {
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

// Alpha-weighted mean luminance of the tree.
double MeanLuminance(const cv::Mat3f& colors, const cv::Mat1f& alpha) {
  double sum = 0, weight = 0;
  for (int row = 0; row < colors.rows; ++row) {
    for (int column = 0; column < colors.cols; ++column) {
      const double a = alpha(row, column);
      if (a <= 0) continue;
      sum += a * Luminance(colors(row, column));
      weight += a;
    }
  }
  return weight > 0 ? sum / weight : 0.0;
}

std::int64_t ClippedIn(const Photo& photo, const cv::Mat1f& alpha, const fs::path& file) {
  if (file.extension() == ".exr") return 0;
  const float limit = LinearFromSrgb(254.5f / 255);
  std::int64_t count = 0;
  for (int row = 0; row < alpha.rows; ++row) {
    for (int column = 0; column < alpha.cols; ++column) {
      const cv::Vec3f& c = photo.pixels(row, column);
      count += alpha(row, column) > 0.5f && std::max({c[0], c[1], c[2]}) >= limit;
    }
  }
  return count;
}

// The photo with the tree relit in place: I + alpha F (r - 1), so that r = 1 leaves every
// pixel as it was.
cv::Mat3f WholePicture(const Subject& subject, const cv::Mat3f& relit) {
  cv::Mat3f whole(relit.size());
  for (int row = 0; row < whole.rows; ++row) {
    for (int column = 0; column < whole.cols; ++column) {
      const float a = subject.cut.alpha(row, column);
      whole(row, column) = subject.photo.pixels(row, column);
      if (a > 0) {
        whole(row, column) +=
            a * (relit(row, column) - subject.cut.foreground(row, column));
        for (int c = 0; c < 3; ++c)
          whole(row, column)[c] = std::max(0.0f, whole(row, column)[c]);
      }
    }
  }
  return whole;
}

nlohmann::json LightJson(const HourLight& light) {
  nlohmann::json json = {{"sun_azimuth_deg", DegFromRad(light.sun.azimuth_rad)},
                         {"sun_elevation_deg", DegFromRad(light.sun.elevation_rad)},
                         {"words", light.words}};
  if (light.time) json["time"] = FormatLocal(*light.time);
  return json;
}

Provenance ProvenanceOf(const HourPlan& plan, double exposure_ev) {
  nlohmann::json json = {
      {"program", std::string("relight ") + Version()},
      {"photo", plan.request.photo.value_or(plan.photo).filename().string()},
      {"photo_hash", HashOfFile(plan.request.photo.value_or(plan.photo))},
      {"view", plan.view},
      {"options", FieldsText(plan.options)},
      {"input", LightJson(plan.input)},
      {"target", LightJson(plan.target)},
      {"heading_deg", plan.heading_deg},
      {"whole", plan.request.whole},
      {"keep_shadow", plan.request.keep_shadow},
      {"over", plan.request.over ? plan.request.over->filename().string() : ""},
      {"exposure_ev", exposure_ev}};
  if (plan.capture) json["volume_hash"] = HashOfFile(plan.capture->folder / "volume.vdb");
  if (plan.place) {
    json["place"] = {
        plan.place->latitude_deg, plan.place->longitude_deg, plan.place->altitude_m};
  }
  return {std::string("relight ") + Version(), json.dump()};
}

void WriteLight(const HourPlan& plan,
                const ViewLight& light,
                cv::Size size,
                HourResult& result) {
  const std::map<std::string, std::string> metadata = {
      {"relight:software", std::string("relight ") + Version()},
      {"relight:unit", "lx"},
      {"relight:options", FieldsText(plan.options)}};
  if (plan.request.irradiance) {
    std::vector<LinearLayer> layers;
    const char* names[] = {"input", "target"};
    for (std::size_t i = 0; i < 2; ++i) {
      const IrradianceImage& image = light.images.lights[i];
      layers.push_back({names[i], image.Total()});
      if (!plan.request.components) continue;
      layers.push_back({std::string(names[i]) + ".sun", image.sun});
      layers.push_back({std::string(names[i]) + ".sky", image.sky});
      layers.push_back({std::string(names[i]) + ".indirect", image.indirect});
    }
    layers.push_back({"weight", light.images.weight});
    WriteLinear(*plan.request.irradiance, layers, metadata);
    result.files.push_back(*plan.request.irradiance);
  }
  if (plan.request.ratio) {
    WriteLinear(
        *plan.request.ratio, {{"", RatioRows(light, size, 0, size.height)}}, metadata);
    result.files.push_back(*plan.request.ratio);
  }
}

}  // namespace

HourResult RunHour(const HourPlan& plan, const StageStart& start) {
  HourResult result;
  const auto begin = [&](const char* name) {
    for (const PlannedStage& stage : plan.stages) {
      if (start && stage.name == name) return start(stage);
    }
    return Progress();
  };
  const CaptureOptions& options = plan.options;
  Subject subject;
  Tree tree;
  Progress relighting;
  const fs::path photo_file = plan.request.photo.value_or(plan.photo);

  // Stages that are not up to date
  if (plan.capture) {
    const Capture& capture = *plan.capture;
    StageRecords records(capture.folder);
    const std::map<std::string, Camera> cameras = CamerasOf(capture);
    const Progress mattes = begin("mattes");
    double done = 0;
    for (const auto& [name, camera] : cameras) {
      const auto share = static_cast<double>(cameras.size());
      MakeMatte(capture,
                FindView(capture, name),
                records,
                options.photo,
                plan.request.force,
                mattes.Part(done / share, (done + 1) / share));
      ++done;
    }
    if (VolumeIsStale(capture, records, options, plan.request.force)) {
      const OpacitySummary summary =
          MakeVolume(capture, records, options, begin("volume"));
      if (summary.residual_rms > 0.35) {
        result.notes.push_back(
            "the volume fits its mattes badly (rms " +
            std::to_string(summary.residual_rms).substr(0, 4) +
            "): cameras and mattes may not belong together; look at volume.vdb");
      }
    }
    tree = TreeOf(capture, records, options, plan.request.force, begin("light"));

    relighting = begin("relight");
    const Progress reading = relighting;
    const ViewEntry& view = FindView(capture, plan.view);
    subject.photo = ReadPhoto(photo_file, options.photo);
    const bool own_alpha = !subject.photo.alpha.empty();
    if (plan.request.matte || (plan.request.photo && own_alpha)) {
      subject.cut = CutOutAlone(plan, subject.photo, reading.Part(0, 0.3));
    } else if (plan.request.photo) {
      const auto matte = FileOfView(capture, "mattes", view.name);
      subject.cut.alpha =
          matte ? ReadMatteFor(*matte, subject.photo.pixels.size(), photo_file)
                : MatteOf(capture, view);
      subject.cut.foreground =
          ForegroundOf(subject.photo, subject.cut.alpha, reading.Part(0, 0.3));
    } else {
      subject.cut = CutOutOf(
          capture, view, subject.photo, records, options.photo, reading.Part(0, 0.3));
    }
    subject.camera = cameras.at(plan.view);
    const cv::Size size = subject.photo.pixels.size();
    const double stretch = static_cast<double>(size.width) * subject.camera.height_px /
                           (static_cast<double>(size.height) * subject.camera.width_px);
    if (std::abs(stretch - 1) > 0.01) {
      throw InputError(photo_file.string() + ": is " + std::to_string(size.width) +
                       " x " + std::to_string(size.height) + " pixels, its camera " +
                       std::to_string(subject.camera.width_px) + " x " +
                       std::to_string(subject.camera.height_px) +
                       ": not the same picture; give one of the camera's proportions");
    }
    subject.camera = subject.camera.Resized(size.width, size.height);
  } else {
    const Progress making = begin("volume");
    subject.photo = ReadPhoto(plan.photo, options.photo);
    subject.cut = CutOutAlone(plan, subject.photo, making);
    std::tie(subject.camera, tree.grid) = StandIn(plan, subject.cut.alpha, result.notes);
    tree.occupied = FindOccupied(tree.grid);
    tree.sky_transmittance = ProjectTransmittance(
        tree.grid, tree.occupied, options.sky_transmittance, begin("light"));
    relighting = begin("relight");
  }
  result.notes.insert(
      result.notes.end(), subject.photo.notes.begin(), subject.photo.notes.end());

  // Light of both hours, and the ratio
  const DaylightOptions daylight = DaylightOf(options.light);
  const auto arriving = [&](const HourLight& light) {
    return LightArriving(
        tree.grid,
        tree.occupied,
        tree.sky_transmittance,
        MakeDaylight(light.sun, daylight),
        {.sun_directions = options.light.method == Method::kDefault ? 16 : 1});
  };
  const ViewLight light =
      LightOfView(tree.grid,
                  tree.occupied,
                  arriving(plan.input),
                  arriving(plan.target),
                  subject.camera,
                  subject.cut.alpha,
                  {.smooth = options.light.method == Method::kDefault, .ratio = {}},
                  relighting.Part(0.3, 0.6));
  cv::Mat3f relit =
      ApplyRatio(light, subject.cut.foreground, 1.0, relighting.Part(0.6, 0.7));

  // Exposure: one factor for all
  const double before = MeanLuminance(subject.cut.foreground, subject.cut.alpha);
  const double after = MeanLuminance(relit, subject.cut.alpha);
  result.mean_ratio = before > 0 ? after / before : 1.0;
  if (plan.request.exposure == "auto") {
    result.exposure_ev = result.mean_ratio > 0 ? -std::log2(result.mean_ratio) : 0.0;
  } else if (plan.request.exposure != "same") {
    result.exposure_ev = std::stod(plan.request.exposure);
  }

  // Figures, and what they mean
  result.weak_share = light.weak_share;
  result.clipped_in = ClippedIn(subject.photo, subject.cut.alpha, photo_file);
  const auto percent = [](double share) {
    std::ostringstream text;
    text.precision(2);
    text << 100 * share << " %";
    return text.str();
  };
  const int solid = cv::countNonZero(subject.cut.alpha > 0.5f);
  if (light.weak_share > 0.05) {
    result.notes.push_back(
        percent(light.weak_share) +
        " of the tree's pixels meet no volume; their light is that of their "
        "neighbours");
  }
  if (solid > 0 && result.clipped_in > solid / 100) {
    result.notes.push_back(
        percent(static_cast<double>(result.clipped_in) / solid) +
        " of the tree's pixels are at the photo's upper limit; what was "
        "brighter there is not known");
  }

  // The tree's shadow on the ground: the new one, and the old one in the photo
  const auto shadow_of = [&](const HourLight& hour) {
    return MakeGroundShadow(tree.grid, MakeDaylight(hour.sun, daylight), options.shadow);
  };
  const std::string fault =
      GroundFault(tree.grid, tree.occupied, subject.camera, options.shadow.ground_z_m);
  Montage montage;
  if (ShadowIsAsked(plan.request, plan.output)) {
    if (!fault.empty()) throw InputError(photo_file.string() + ": " + fault);
    montage.shadow = ShadowImage(shadow_of(plan.target), subject.camera);
  }
  if (OldShadowGoes(plan.request) && subject.photo.alpha.empty()) {
    if (!fault.empty()) {
      result.notes.push_back(fault + "; the photo's own ground is left as it is");
    } else {
      const cv::Mat3f ground_ratio =
          GroundRatio(subject.photo.pixels,
                      subject.cut.alpha,
                      shadow_of(plan.input),
                      shadow_of(plan.target),
                      subject.camera,
                      AngleBetween(plan.input.sun.direction, plan.target.sun.direction),
                      options.old_shadow);
      subject.photo.pixels = ReshadowedPhoto(
          subject.photo.pixels, subject.cut.alpha, subject.cut.foreground, ground_ratio);
      result.notes.push_back(
          "the tree's shadow is moved on the ground around it, approximately: all below "
          "the horizon is taken as level ground; --keep-shadow leaves the ground as "
          "taken");
    }
  }

  // Write, all or nothing of each file
  Photo output;
  if (plan.request.whole) {
    if (!subject.photo.alpha.empty()) {
      throw InputError(photo_file.string() +
                       ": has no background to keep (it has an alpha "
                       "channel); leave --whole out and write .png, .tif or .exr");
    }
    output.pixels = WholePicture(subject, relit);
  } else {
    output.pixels = relit;
    output.alpha = subject.cut.alpha;
  }
  if (result.exposure_ev != 0) output.pixels *= std::exp2(result.exposure_ev);
  const bool layers = plan.output.extension() == kLayers;
  if (plan.request.over) {
    montage.backdrop = ReadPhoto(*plan.request.over, options.photo).pixels;
    if (montage.backdrop.size() != output.pixels.size()) {
      throw InputError(
          plan.request.over->string() + ": is " + std::to_string(montage.backdrop.cols) +
          " x " + std::to_string(montage.backdrop.rows) + " pixels, the photo " +
          std::to_string(output.pixels.cols) + " x " +
          std::to_string(output.pixels.rows) + "; give a backdrop of the photo's size");
    }
  }
  if (layers || plan.request.over) {
    montage.tree = output.pixels;
    montage.alpha = output.alpha;
    if (!layers) output = {.pixels = FlatPicture(montage)};
  }
  relighting.Report(0.8);
  if (!plan.request.output && fs::is_directory(plan.request.source)) {
    MakeFolderOf(plan.request.source, "out");
  }
  WriteLight(plan, light, subject.photo.pixels.size(), result);
  const Provenance provenance = ProvenanceOf(plan, result.exposure_ev);
  if (plan.request.shadow) {
    WritePhoto(*plan.request.shadow,
               {.pixels = montage.shadow},
               provenance,
               {.quality = plan.request.quality});
    result.files.push_back(*plan.request.shadow);
  }
  const WriteSummary written =
      layers ? WriteOpenRaster(plan.output, montage, provenance)
             : WritePhoto(
                   plan.output, output, provenance, {.quality = plan.request.quality});
  result.files.insert(result.files.begin(), plan.output);
  result.clipped_out = written.clipped_pixels;
  if (solid > 0 && written.clipped_pixels > solid / 100) {
    result.notes.push_back(percent(static_cast<double>(written.clipped_pixels) / solid) +
                           " of the tree's pixels are brighter than " +
                           plan.output.extension().string() +
                           " can hold and are cut; --exposure -1 or an .exr keeps them");
  }
  relighting.Report(1.0);
  return result;
}

}  // namespace relight
