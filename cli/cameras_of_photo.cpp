// SPDX-License-Identifier: Apache-2.0
#include "cli/cameras_of_photo.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/capture/capture.h"
#include "relight/photo/color.h"
#include "relight/photo/read_photo.h"
#include "relight/sky/light_in_words.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

json VectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json SunJson(const PhotoSun& sun) {
  return {
      {"time", FormatLocal(sun.time)},
      {"azimuth_deg", DegFromRad(sun.position.azimuth_rad)},
      {"elevation_deg", DegFromRad(sun.position.elevation_rad)},
      {"azimuth_from_ahead_deg", DegFromRad(sun.azimuth_from_ahead_rad)},
      {"in_camera", VectorJson(sun.in_camera)},
      {"words", LightInWords(sun.azimuth_from_ahead_rad, sun.position.elevation_rad)}};
}

json ResultJson(const fs::path& folder, const OnePhotoCamera& found) {
  const Camera& camera = found.camera;
  json j = {{"folder", folder.string()},
            {"overlay", (folder / "overlay.jpg").string()},
            {"width_px", camera.width_px},
            {"height_px", camera.height_px},
            {"focal_px", camera.focal_px.x()},
            {"focal_35mm_mm", found.focal_35mm_mm},
            {"focal_from", found.focal_from},
            {"pitch_deg", found.pitch_deg},
            {"roll_deg", found.roll_deg},
            {"tilt_from", found.tilt_from},
            {"heading_deg", found.heading_deg},
            {"heading_from", found.heading_from},
            {"camera_height_m", found.height_m},
            {"height_from", found.height_from},
            {"position_m", VectorJson(camera.PositionInWorld())},
            {"origin_is", found.origin_is},
            {"notes", found.notes}};
  if (found.origin)
    j["origin"] = {found.origin->latitude_deg, found.origin->longitude_deg};
  if (found.sun) j["sun"] = SunJson(*found.sun);
  if (!found.point_residual_px.empty()) {
    j["point_residual_px"] = found.point_residual_px;
    j["position_error_m"] = found.position_error_m;
  }
  return j;
}

void SayResult(const ConsoleOptions& console, const OnePhotoCamera& found) {
  Say(console,
      fmt::format("focal length {:.4g} mm (35 mm equivalent): {}",
                  found.focal_35mm_mm,
                  found.focal_from));
  Say(console,
      fmt::format("tilted {:.1f} deg {}, rolled {:.1f} deg {}: {}",
                  std::abs(found.pitch_deg),
                  found.pitch_deg < 0 ? "down" : "up",
                  std::abs(found.roll_deg),
                  found.roll_deg < 0 ? "counterclockwise" : "clockwise",
                  found.tilt_from));
  Say(console,
      fmt::format("heading {:.1f} deg from true north: {}",
                  found.heading_deg,
                  found.heading_from));
  Say(console,
      fmt::format(
          "camera {:.2f} m above the ground: {}", found.height_m, found.height_from));
  for (std::size_t i = 0; i < found.point_residual_px.size(); ++i) {
    Say(console,
        fmt::format("point {}: {:.1f} px off", i + 1, found.point_residual_px[i]));
  }
  if (!found.point_residual_px.empty()) {
    Say(console,
        fmt::format("the camera's place is sure to {:.2g} m", found.position_error_m));
  }
  if (found.foot_in_world) {
    Say(console,
        fmt::format("the tree's foot is {:.1f} m from the camera, along the ground",
                    found.camera.PositionInWorld().head<2>().norm()));
  }
  if (found.sun) {
    Say(console,
        fmt::format("{}: {}",
                    FormatLocal(found.sun->time),
                    LightInWords(found.sun->azimuth_from_ahead_rad,
                                 found.sun->position.elevation_rad)));
  }
  SayAll(console, found.notes);
}

cv::Mat3b DisplayOf(const fs::path& file) {
  cv::Mat3b display;
  DisplayFromLinear(ReadPhoto(file).pixels).convertTo(display, CV_8U, 255);
  return display;
}

}  // namespace

void AddCamerasOfPhoto(CLI::App& app, CamerasOfPhotoRequest& request) {
  OnePhotoRequest& r = request.photo;
  const char* group = "One photo: its camera, from what is known";
  app.add_option("--focal-35mm",
                 r.focal_35mm_mm,
                 "focal length as of a 35 mm film [EXIF's, else 26, a 4:3 phone's]")
      ->type_name("MM")
      ->group(group);
  app.add_option("--horizon",
                 r.horizon,
                 "the horizon's row, or two of its pixels, which may lie outside [from "
                 "upright lines, else level]")
      ->type_name("Y|X1,Y1,X2,Y2")
      ->group(group);
  app.add_option(
         "--heading",
         r.heading,
         "where the camera looked, from true north [EXIF's]; of a capture: VIEW=210")
      ->type_name("DEG|SW")
      ->group(group);
  app.add_option("--camera-height", r.camera_height_m, "above the tree's foot [1.6]")
      ->type_name("M")
      ->group(group);
  app.add_option("--point",
                 r.points,
                 "in place of all these but the focal length: a pixel and its place, H "
                 "metres above the ground; four or more")
      ->type_name("X,Y=LAT,LON[,H]")
      ->take_all()
      ->group(group);
  app.add_option("--foot", r.foot, "the pixel where the trunk meets the ground")
      ->type_name("X,Y")
      ->group(group);
  app.add_option("--place", r.place, "where, for the sun and magnetic north [EXIF's]")
      ->type_name("LAT,LON")
      ->group(group);
  app.add_option("--zone", r.zone, "time zone: Europe/Paris or +02:00 [EXIF's]")
      ->type_name("NAME")
      ->group(group);
  app.add_option("--taken", r.taken, "when the photo was taken [EXIF's]")
      ->type_name("WHEN")
      ->group(group);
  app.add_option("-o,--output", request.output, "[PHOTO_camera/ beside the photo]")
      ->type_name("FOLDER")
      ->group(group);
  app.add_flag("--json", request.json, "print what was found, and from what")
      ->group(group);
}

int RunCamerasOfPhoto(const CamerasOfPhotoRequest& request,
                      const ConsoleOptions& console) {
  const fs::path& file = request.photo.photo;
  if (!fs::exists(file)) {
    throw InputError(file.string() + ": not there; give a photo or a capture folder");
  }
  const PhotoFacts facts = ReadPhotoFacts(file);
  RequireOriginal(facts);
  const cv::Mat3b display = DisplayOf(file);
  OnePhotoCamera found = FindOnePhotoCamera(request.photo, facts, display);
  if (const auto of_capture = CaptureOfPhoto(file)) {
    found.notes.push_back(of_capture->folder.string() +
                          " is a capture: its photos' cameras are in its cameras/; this "
                          "one is of the photo alone");
  }
  const fs::path folder = request.output.value_or(CameraFolderOf(file));
  WriteOnePhotoCamera(folder, file, found, OverlayOf(found, display));
  if (request.json) {
    fmt::print("{}\n", ResultJson(folder, found).dump(1));
    return 0;
  }
  SayResult(console, found);
  Say(console,
      "look at " + (folder / "overlay.jpg").string() +
          ": horizon, sun and shadow must lie where the photo has them");
  if (!console.quiet) fmt::print("{}\n", folder.string());
  return 0;
}

void RefuseForCapture(const CamerasOfPhotoRequest& request) {
  const OnePhotoRequest& r = request.photo;
  if (!r.focal_35mm_mm && !r.horizon && !r.camera_height_m && r.points.empty() &&
      !r.foot && !r.place && !r.zone && !r.taken && !request.output) {
    return;
  }
  throw OptionError(
      "--focal-35mm, --horizon, --camera-height, --point, --foot, --place, --zone, "
      "--taken and -o belong to one photo, and a capture folder was given");
}

}  // namespace relight::cli
