// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/relit_hour.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/field_text.h"
#include "relight/base/version.h"
#include "relight/capture/accuracy_notes.h"
#include "relight/capture/capture_folder.h"
#include "relight/capture/relit_provenance.h"
#include "relight/capture/relit_view.h"
#include "relight/composite/montage.h"
#include "relight/composite/open_raster.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"
#include "relight/ratio/confidence.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

// The tree's shadow is wanted, in a file of its own or below the tree.
bool ShadowIsAsked(const HourPlan& plan) {
  return plan.request.shadow || plan.request.over || plan.output.extension() == kLayers;
}

std::string Percent(double share) {
  std::ostringstream text;
  text.precision(2);
  text << 100 * share << " %";
  return text.str();
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

void WriteLight(const HourPlan& plan,
                const ViewLight& light,
                cv::Size size,
                HourResult& result) {
  const std::map<std::string, std::string> metadata = {
      {"relight:software", std::string("relight ") + Version()},
      {"relight:unit", "lx"},
      {"relight:options", FieldsText(plan.view.options)}};
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

// Patches as layers, their place in the photo as text.
void WriteFeatures(const fs::path& file, const CorrectionFeatures& features) {
  if (features.planes.empty()) {
    throw InputError(file.string() +
                     ": the tree has no patch that meets its volume, so there are no "
                     "features to write");
  }
  std::vector<LinearLayer> layers = {{"cover", features.cover}};
  for (std::size_t i = 0; i < features.planes.size(); ++i) {
    layers.push_back({CorrectionFeatureNames()[i], features.planes[i]});
  }
  const PatchGrid& grid = features.grid;
  std::ostringstream place;
  place.precision(17);
  place << grid.left_px << " " << grid.top_px << " " << grid.patch_px;
  std::string names;
  for (const std::string& name : CorrectionFeatureNames()) names += name + " ";
  WriteLinear(
      file, layers, {{"relight:patches", place.str()}, {"relight:features", names}});
}

}  // namespace

HourResult RunHour(const HourPlan& plan, const StageStart& start) {
  HourResult result;
  const HourRequest& r = plan.request;
  const PreparedView view = PrepareView(plan.view, start);
  result.notes = view.notes;
  const fs::path& photo_file = plan.view.PhotoFile();
  RelitView relit(
      view, plan.view.options, plan.view.input.sun, plan.target.sun.elevation_rad);
  result.light = relit.light();
  const std::vector<std::string> of_panoramas = relit.NotesOfPanoramas(plan.target.sun);
  result.notes.insert(
      result.notes.end(), result.light.notes.begin(), result.light.notes.end());
  result.notes.insert(result.notes.end(), of_panoramas.begin(), of_panoramas.end());
  const RelitTree tree = relit.TreeUnder(
      plan.target.sun, view.progress.Part(0, 0.4), r.correction_features.has_value());

  result.fit = relit.fit();
  if (result.fit) result.notes.push_back(FitInWords(*result.fit));
  const std::vector<std::string> costs =
      AccuracyNotes({.input = plan.view.input.sun,
                     .heading_rad = RadFromDeg(plan.view.heading_deg),
                     .views = view.volume_views,
                     .air = view.air,
                     .contrast = ContrastOfPhoto(tree.features)},
                    tree.light.correction);
  result.notes.insert(result.notes.end(), costs.begin(), costs.end());

  // Exposure: one factor for all
  result.mean_ratio = tree.mean_ratio;
  result.exposure_ev = ExposureStops(r.exposure, tree.mean_ratio);

  // Figures, and what they mean
  result.weak_share = tree.light.weak_share;
  result.clipped_in = ClippedIn(view.photo, view.cut.alpha, photo_file);
  const int solid = cv::countNonZero(view.cut.alpha > 0.5f);
  if (result.weak_share > 0.05) {
    result.notes.push_back(Percent(result.weak_share) +
                           " of the tree's pixels meet no volume; their light is that of "
                           "their neighbours");
  }
  if (solid > 0 && result.clipped_in > solid / 100) {
    result.notes.push_back(Percent(static_cast<double>(result.clipped_in) / solid) +
                           " of the tree's pixels are at the photo's upper limit; what "
                           "was brighter there is not known");
  }

  // The picture: the tree alone, or on its own ground
  Montage montage;
  if (ShadowIsAsked(plan)) {
    if (!view.ground_fault.empty())
      throw InputError(photo_file.string() + ": " + view.ground_fault);
    montage.shadow = relit.ShadowUnder(plan.target.sun, view.progress.Part(0.4, 0.6));
  }
  Photo output{.pixels = tree.colors, .alpha = view.cut.alpha};
  if (r.whole) {
    if (!view.photo.alpha.empty()) {
      throw InputError(photo_file.string() +
                       ": has no background to keep (it has an alpha channel); leave "
                       "--whole out and write .png, .tif or .exr");
    }
    cv::Mat3f ground = view.photo.pixels;
    if (!r.keep_shadow && !relit.GroundMoves()) {
      result.notes.push_back(view.ground_fault +
                             "; the photo's own ground is left as it is");
    } else if (!r.keep_shadow) {
      ground = relit.GroundUnder(plan.target.sun, view.progress.Part(0.4, 0.8));
      result.notes.push_back(
          "the tree's shadow is moved on the ground around it, approximately: all below "
          "the horizon is taken as level ground; --keep-shadow leaves the ground as "
          "taken");
    }
    output = {.pixels = relit.Whole(ground, tree)};
  }
  if (result.exposure_ev != 0) {
    output.pixels = output.pixels * std::exp2(result.exposure_ev);
  }
  const bool layers = plan.output.extension() == kLayers;
  if (r.over) {
    montage.backdrop =
        ReadBackdrop(*r.over, output.pixels.size(), plan.view.options.photo);
  }
  if (layers || r.over) {
    montage.tree = output.pixels;
    montage.alpha = output.alpha;
    if (!layers) output = {.pixels = FlatPicture(montage)};
  }
  view.progress.Report(0.8);

  // Write, all or nothing of each file
  if (!r.output && fs::is_directory(r.source)) MakeFolderOf(r.source, "out");
  WriteLight(plan, tree.light, view.photo.pixels.size(), result);
  cv::Mat1f confidence;
  if (r.confidence || plan.output.extension() == ".exr") {
    confidence = Confidence(
        tree.light,
        view.cut.alpha,
        AngleBetween(plan.view.input.sun.direction, plan.target.sun.direction));
  }
  if (r.confidence) {
    WriteMatte(*r.confidence, confidence);
    result.files.push_back(*r.confidence);
  }
  if (r.correction_features) {
    WriteFeatures(*r.correction_features, tree.features);
    result.files.push_back(*r.correction_features);
  }
  const Provenance provenance =
      ProvenanceOf(plan.view,
                   HashInputs(plan.view),
                   plan.target,
                   {.whole = r.whole,
                    .keep_shadow = r.keep_shadow,
                    .over = r.over ? r.over->filename().string() : "",
                    .exposure_ev = result.exposure_ev,
                    .light = result.light});
  if (r.shadow) {
    WritePhoto(*r.shadow, {.pixels = montage.shadow}, provenance, {.quality = r.quality});
    result.files.push_back(*r.shadow);
  }
  const WriteSummary written =
      layers ? WriteOpenRaster(plan.output, montage, provenance)
             : WritePhoto(
                   plan.output, output, provenance, {.quality = r.quality}, confidence);
  result.files.insert(result.files.begin(), plan.output);
  result.clipped_out = written.clipped_pixels;
  if (solid > 0 && written.clipped_pixels > solid / 100) {
    result.notes.push_back(Percent(static_cast<double>(written.clipped_pixels) / solid) +
                           " of the tree's pixels are brighter than " +
                           plan.output.extension().string() +
                           " can hold and are cut; --exposure -1 or an .exr keeps them");
  }
  view.progress.Report(1.0);
  return result;
}

}  // namespace relight
