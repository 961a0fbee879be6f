// SPDX-License-Identifier: Apache-2.0
#include "cli/cameras_of_photo.h"
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/import_cameras.h"
#include "relight/capture/cameras_report.h"
#include "relight/capture/capture_cameras.h"
#include "relight/capture/capture_times.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

struct CamerasVerb {
  fs::path source;
  std::vector<std::string> import;     // [FORMAT] PATH
  std::vector<std::string> export_to;  // FORMAT PATH
  CamerasRequest request;
  std::map<std::string, std::string> georeference, colmap;
  bool report = false;
  CamerasOfPhotoRequest
      alone;  // When `source` is a photo; its heading and --json, always.
};

// How the frame is known and how sure, a line each.
void SayFrame(const CamerasSummary& summary, const ConsoleOptions& console) {
  if (!summary.georeference) return;
  const Georeference& found = *summary.georeference;
  const auto sure_deg = [](double error_rad) { return DegFromRad(error_rad); };
  if (found.kept_frame) {
    Say(console, fmt::format("frame: kept, for it agrees with {}", found.north_from));
  } else {
    Say(console,
        fmt::format("north: from {}, sure to {:.1f} deg",
                    found.north_from,
                    sure_deg(found.north_error_rad)));
    Say(console,
        fmt::format("up: from {}, sure to {:.1f} deg",
                    found.up_from,
                    sure_deg(found.up_error_rad)));
    Say(console,
        fmt::format("scale: from {}, sure to {:.1f} %",
                    found.scale_from,
                    100 * found.scale_error));
  }
  for (const ViewResidual& view : found.residuals) {
    if (!view.gps_m && !view.compass_rad) continue;
    std::string text = "  " + view.view + ":";
    if (view.gps_m) text += fmt::format(" GPS {:.1f} m off", *view.gps_m);
    if (view.compass_rad) {
      text += fmt::format("{} compass {:+.1f} deg off",
                          view.gps_m ? "," : "",
                          DegFromRad(*view.compass_rad));
    }
    if (view.gps_is_outlier || view.compass_is_outlier) text += " (left out)";
    Say(console, text);
  }
}

json JsonOf(const CamerasSummary& summary, const fs::path& folder) {
  json j = {{"folder", folder.string()},
            {"made_by", summary.made_by},
            {"views", json::array()},
            {"missing", summary.missing},
            {"notes", summary.notes},
            {"ground",
             {{"from", summary.tree.ground_from},
              {"z_m", summary.tree.foot.z()},
              {"error_m", summary.tree.ground_error_m},
              {"slope_deg", DegFromRad(summary.tree.slope_rad)}}}};
  for (const auto& [view, camera] : summary.scene.cameras) {
    const Eigen::Vector3d eye = camera.PositionInWorld();
    j["views"].push_back(
        {{"view", view},
         {"position_m", {eye.x(), eye.y(), eye.z()}},
         {"heading_deg", DegFromRad(AzimuthOf(camera.ForwardInWorld()))},
         {"elevation_deg", DegFromRad(ElevationOf(camera.ForwardInWorld()))}});
  }
  if (const auto& origin = summary.scene.enu_origin) {
    j["origin"] = {origin->latitude_deg, origin->longitude_deg, origin->altitude_m};
  }
  if (const auto& found = summary.georeference) {
    j["kept_frame"] = found->kept_frame;
    j["north"] = {{"from", found->north_from},
                  {"error_deg", DegFromRad(found->north_error_rad)}};
    j["up"] = {{"from", found->up_from}, {"error_deg", DegFromRad(found->up_error_rad)}};
    j["scale"] = {{"from", found->scale_from}, {"error", found->scale_error}};
    for (const ViewResidual& view : found->residuals) {
      json r = {{"view", view.view}};
      if (view.gps_m) r["gps_m"] = *view.gps_m;
      if (view.compass_rad) r["compass_deg"] = DegFromRad(*view.compass_rad);
      r["left_out"] = view.gps_is_outlier || view.compass_is_outlier;
      j["residuals"].push_back(r);
    }
  }
  return j;
}

void Export(const std::vector<std::string>& to,
            const Capture& capture,
            const CalibratedScene& scene,
            const ConsoleOptions& console) {
  std::map<std::string, std::string> files;
  for (const ViewEntry& view : capture.file.views) files[view.name] = view.photo;
  ExportCameras(to[0], to[1], scene, files);
  Say(console, "exported to " + to[1]);
}

void Report(const Capture& capture,
            const CamerasSummary& summary,
            bool is_told,
            const ConsoleOptions& console) {
  const fs::path file = capture.folder / "cameras" / "report.html";
  WriteTextWhole(file, CamerasReport(capture, summary, ShowProgress(console, "report")));
  if (is_told && !console.quiet) fmt::print("{}\n", file.string());
}

int RunVerb(CamerasVerb& verb, const ConsoleOptions& console) {
  CamerasRequest& request = verb.request;
  for (const auto& [name, text] : verb.georeference) {
    SetField(request.georeference, name, text);
  }
  for (const auto& [name, text] : verb.colmap) SetField(request.colmap, name, text);
  CheckFields(request.georeference);
  CheckFields(request.colmap);
  if (!verb.import.empty()) {
    request.import = verb.import.back();
    if (verb.import.size() == 2) request.import_format = verb.import.front();
  }
  if (!fs::is_directory(verb.source)) {
    if (request.import || !verb.export_to.empty() || verb.report) {
      throw OptionError(
          "--import, --export and --report belong to a capture folder, and " +
          verb.source.string() + " is none");
    }
    verb.alone.photo.photo = verb.source;
    return RunCamerasOfPhoto(verb.alone, console);
  }
  RefuseForCapture(verb.alone);
  request.heading = verb.alone.photo.heading;
  const Capture capture = OpenCapture(verb.source);
  const fs::path folder = verb.source / "cameras";

  // Only looked at or written elsewhere, when there are cameras and nothing asks for
  // others
  request.force = request.force || !verb.colmap.empty();  // Said of COLMAP: it is to run
  const bool looks_only = (verb.report || !verb.export_to.empty()) && !request.import &&
                          !request.force && !TurnsKept(capture, request) &&
                          fs::exists(folder / "images.txt");
  if (looks_only) {
    const CamerasSummary kept = KeptCameras(capture);
    if (!verb.export_to.empty()) {
      Export(verb.export_to, capture, kept.scene, console);
      if (!console.quiet) fmt::print("{}\n", verb.export_to[1]);
    }
    if (verb.report) Report(capture, kept, true, console);
    return 0;
  }

  const CamerasPlan plan = PlanCameras(capture, request);
  if (plan.expected_s > 0) {
    const double minutes = plan.expected_s / 60;
    Say(console,
        minutes < 1.5 ? fmt::format("{}, about {:.0f} s", plan.what, plan.expected_s)
                      : fmt::format("{}, about {:.0f} min", plan.what, minutes));
  } else if (TurnsKept(capture, request)) {
    Say(console, plan.what);
  }
  const CamerasSummary summary =
      MakeCameras(capture, request, ShowProgress(console, "cameras", plan.expected_s));
  if (!verb.export_to.empty()) Export(verb.export_to, capture, summary.scene, console);

  Say(console,
      fmt::format("{} cameras of {} photos",
                  summary.scene.cameras.size(),
                  capture.file.views.size()));
  SayFrame(summary, console);
  Say(console,
      fmt::format(
          "ground: z = {:.2f} m from {}{}",
          summary.tree.foot.z(),
          summary.tree.ground_from,
          summary.tree.slope_rad > RadFromDeg(3)
              ? fmt::format(", {:.0f} deg steep; shadows are cast on level ground",
                            DegFromRad(summary.tree.slope_rad))
              : ""));
  SayAll(console, summary.notes);
  SayAll(console, DoubtsOfCapture(capture));
  if (verb.alone.json) {
    json result = JsonOf(summary, folder);
    if (verb.report) result["report"] = (folder / "report.html").string();
    fmt::print("{}\n", result.dump(1));
  } else if (!console.quiet) {
    fmt::print("{}\n", folder.string());
  }
  if (verb.report) Report(capture, summary, !verb.alone.json, console);
  return 0;
}

}  // namespace

Verb AddCameras(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand(
      "cameras", "Find the cameras of a capture's photos, or import them");
  auto verb = std::make_shared<CamerasVerb>();
  app->add_option("source", verb->source, "capture folder, or one photo")
      ->required()
      ->type_name("DIR|PHOTO");
  app->add_option(
         "--import",
         verb->import,
         "cameras that another program found, in place of running COLMAP: "
         "colmap, bundler, transforms, metashape or realitycapture; guessed when "
         "left out")
      ->expected(1, 2)
      ->type_name("[FORMAT] PATH");
  app->add_option("--export",
                  verb->export_to,
                  "write the cameras for another program: colmap or transforms")
      ->expected(2)
      ->type_name("FORMAT PATH");
  app->add_flag("--matching-only",
                verb->request.matching_only,
                "leave out cameras without photo and photos without camera");
  app->add_flag("--force",
                verb->request.force,
                "run COLMAP in place of cameras that were imported, or of turning those "
                "that are there");
  app->add_flag("--report",
                verb->report,
                "a page to look at, cameras/report.html; of cameras that are there "
                "already, unless others are asked for with --import or --force");
  const char* frame = "Where on Earth";
  app->add_flag("--keep-frame",
                verb->request.keep_frame,
                "the model's world is east, north, up in metres already")
      ->group(frame);
  app->add_option("--up", verb->request.up, "which way is up, in the model's own frame")
      ->type_name("X,Y,Z")
      ->group(frame);
  app->add_option("--scale-from",
                  verb->request.scale_from,
                  "two views, and how far apart they were taken")
      ->expected(3)
      ->type_name("VIEW VIEW M")
      ->group(frame);
  app->add_option("--north-from-shadow",
                  verb->request.north_from_shadow,
                  "a view, and foot and tip of an upright thing's shadow in it [px]: "
                  "north by time and place")
      ->expected(3)
      ->type_name("VIEW x1,y1 x2,y2")
      ->group(frame);
  app->add_option("--origin",
                  verb->request.origin,
                  "a point of the world that comes out, the tree's foot, to be its "
                  "origin [m]")
      ->type_name("X,Y,Z")
      ->group(frame);
  AddCamerasOfPhoto(*app, verb->alone);
  AddFlags(*app, GeoreferenceOptions(), frame, verb->georeference);
  AddFlags(*app, ColmapOptions(), "COLMAP", verb->colmap);
  return {app, [verb, &console] { return RunVerb(*verb, console); }};
}

}  // namespace relight::cli
