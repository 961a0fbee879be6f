// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/one_photo_camera.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/version.h"
#include "relight/base/write_file.h"
#include "relight/cameras/colmap_model.h"
#include "relight/cameras/level_camera.h"
#include "relight/cameras/photo_orientation.h"
#include "relight/cameras/pose_from_points.h"
#include "relight/cameras/vertical_lines.h"
#include "relight/cameras/view_name.h"
#include "relight/capture/capture.h"
#include "relight/capture/photo_heading.h"
#include "relight/composite/contact_sheet.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include <charconv>
#include <cmath>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr double kSteepest_deg = 80;  // Beyond it a heading means little.

std::string Short(double value, int digits = 3) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

// "1,2.5,-3" as numbers; nothing when it is anything else.
std::optional<std::vector<double>> Numbers(std::string_view text) {
  std::vector<double> numbers;
  for (;;) {
    double value = 0;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return numbers;
    if (text.front() != ',') return std::nullopt;
    text.remove_prefix(1);
  }
}

// --- What the user and EXIF say
// ----------------------------------------------------------

void RequireInRange(const char* option,
                    const std::optional<double>& value,
                    double low,
                    double high,
                    const char* unit) {
  if (!value || (*value >= low && *value <= high)) return;
  throw OptionError(std::string(option) + " must be " + Short(low) + " to " +
                    Short(high) + " " + unit + ", got " + Short(*value));
}

void RequireThatGoesTogether(const OnePhotoRequest& r) {
  RequireInRange("--focal-35mm", r.focal_35mm_mm, 4, 3000, "mm");
  RequireInRange("--camera-height", r.camera_height_m, 0.05, 1000, "m");
  if (r.points.empty()) return;
  for (const auto& [option, given] :
       {std::pair("--horizon", r.horizon.has_value()),
        {"--heading", r.heading.has_value()},
        {"--camera-height", r.camera_height_m.has_value()}}) {
    if (!given) continue;
    throw OptionError(std::string("--point gives heading, tilt and height at once; leave "
                                  "out ") +
                      option + ", or the points");
  }
}

struct Moment {
  std::optional<Place> place;
  std::optional<LocalTime> time;
};

// Place and time as far as they are known; what is lacking for a sun becomes a note.
Moment MomentOf(const OnePhotoRequest& request,
                const PhotoFacts& facts,
                const std::optional<Place>& of_points,
                std::vector<std::string>& notes) {
  Moment moment;
  moment.place = request.place ? ParsePlace(*request.place)
                 : of_points   ? of_points
                               : facts.place;
  try {
    PhotoFacts placed = facts;  // A zone is asked for a place only when there is none
    placed.place = moment.place;
    const CaptureTime when = ResolveCaptureTime(placed, request.zone, request.taken);
    notes.insert(notes.end(), when.notes.begin(), when.notes.end());
    moment.time = when.time;
    if (!moment.place) moment.place = when.approximate_place;
  } catch (const InputError& error) {
    notes.push_back(std::string("the sun is not drawn: ") + error.what());
    return moment;
  }
  if (!moment.place) {
    notes.emplace_back("the sun is not drawn: no place in EXIF; give --place LAT,LON");
  }
  return moment;
}

// --- The lens
// ------------------------------------------------------------------------------

Camera LensOf(const OnePhotoRequest& request,
              const PhotoFacts& facts,
              OnePhotoCamera& found) {
  found.focal_35mm_mm = kPhoneFocal35mm_mm;
  if (request.focal_35mm_mm) {
    found.focal_35mm_mm = *request.focal_35mm_mm;
    found.focal_from = "--focal-35mm";
  } else if (facts.focal_35mm_mm) {
    found.focal_35mm_mm = *facts.focal_35mm_mm;
    found.focal_from = "EXIF";
  } else {
    found.focal_from =
        facts.focal_mm ? "a 4:3 phone's, for EXIF has " + Short(*facts.focal_mm) +
                             " mm but no 35 mm equivalent; --focal-35mm tells better"
                       : "a 4:3 phone's, for EXIF has none; --focal-35mm tells better";
  }
  Camera camera;
  camera.width_px = facts.width;
  camera.height_px = facts.height;
  camera.focal_px = Eigen::Vector2d::Constant(
      FocalPixelsFrom35mm(found.focal_35mm_mm, facts.width, facts.height));
  camera.center_px = {facts.width / 2.0, facts.height / 2.0};
  return camera;
}

// --- Orientation from horizon, lines and heading
// -------------------------------------------

Eigen::Vector3d UpFromText(const std::string& horizon, const Camera& camera) {
  const auto refuse = [&](const std::string& why) {
    throw OptionError(
        "--horizon must be its row Y, or two of its pixels X1,Y1,X2,Y2, in "
        "pixels from the photo's upper left corner" +
        why + "; got \"" + horizon + "\"");
  };
  const auto numbers = Numbers(horizon);
  if (!numbers || (numbers->size() != 1 && numbers->size() != 4)) refuse("");
  const std::vector<double>& n = *numbers;
  const Eigen::Vector2d a(n.size() == 1 ? 0 : n[0], n.size() == 1 ? n[0] : n[1]);
  const Eigen::Vector2d b(n.size() == 1 ? camera.width_px : n[2],
                          n.size() == 1 ? n[0] : n[3]);
  const Eigen::Vector2d along = (b - a).cwiseAbs();
  if (along.x() < 0.02 * camera.width_px || along.y() > 1.7 * along.x())
    refuse(" that lie well apart, side by side");
  const Eigen::Vector3d up = UpFromHorizon(a, b, camera.focal_px.x(), camera.center_px);
  if (std::abs(DegFromRad(PitchOf(up))) > kSteepest_deg)
    refuse(" (this one is more than 80 degrees from where the camera looks)");
  return up;
}

Eigen::Vector3d UpOf(const OnePhotoRequest& request,
                     const cv::Mat3b& display_rgb,
                     OnePhotoCamera& found) {
  Camera& camera = found.camera;
  if (request.horizon) {
    found.tilt_from = "--horizon";
    return UpFromText(*request.horizon, camera);
  }
  cv::Mat1b grey;
  cv::cvtColor(display_rgb, grey, cv::COLOR_RGB2GRAY);
  if (const auto lines = FindUprightLines(grey, camera)) {
    camera.lens = lines->lens;
    found.tilt_from = std::to_string(lines->lines) +
                      " upright lines that agree, sure to " + Short(lines->error_deg, 1) +
                      " deg" +
                      (lines->lens.IsPinhole()
                           ? ""
                           : " (they are bent: k1 " + Short(lines->lens.k1, 2) + ")") +
                      "; --horizon wins over them";
    return lines->up_in_camera;
  }
  found.tilt_from =
      "taken as level, for no horizon is given and too few upright lines agree; "
      "--horizon tells better";
  return -Eigen::Vector3d::UnitY();
}

double HeadingOf(const OnePhotoRequest& request,
                 const PhotoFacts& facts,
                 const Moment& moment,
                 OnePhotoCamera& found) {
  if (request.heading) {
    found.heading_from = "--heading";
    return ParseHeading(*request.heading);
  }
  std::optional<Instant> utc;
  if (moment.time) utc = moment.time->utc;
  if (const auto heading = HeadingFromExif(facts, moment.place, utc)) {
    found.heading_from = "EXIF";
    if (!heading->note.empty()) found.notes.push_back(heading->note);
    return heading->heading_deg;
  }
  const std::string photo = request.photo.string();
  throw InputError(
      facts.heading_deg
          ? photo +
                ": its compass heading is magnetic, and true north needs a place; "
                "give --place 48.85,2.35, or --heading SW"
          : photo +
                ": no heading in EXIF (which way the camera looked); give --heading "
                "SW, or four or more --point X,Y=LAT,LON; a map that shows what is in "
                "the photo's middle tells it");
}

void PoseFromHorizon(const OnePhotoRequest& request,
                     const PhotoFacts& facts,
                     const cv::Mat3b& display_rgb,
                     const Moment& moment,
                     OnePhotoCamera& found) {
  Camera& camera = found.camera;
  const double heading_deg = HeadingOf(request, facts, moment, found);
  const Eigen::Vector3d up = UpOf(request, display_rgb, found);
  camera.camera_from_world.linear() = RotationFromUp(up, RadFromDeg(heading_deg));
  const double height_m = request.camera_height_m.value_or(kEyeHeight_m);
  camera.camera_from_world.translation() =
      -height_m * camera.camera_from_world.linear().col(2);
  found.height_from = request.camera_height_m
                          ? "--camera-height"
                          : "a standing person's; --camera-height tells better";
  found.origin = moment.place;
  found.origin_is = "the ground below the camera";
}

// --- Pose from points
// ------------------------------------------------------------------------

struct NamedPoint {
  Eigen::Vector2d pixel;
  Place place;  // Its altitude: metres above the ground.
};

NamedPoint ParsePoint(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto pixel = Numbers(std::string_view(text).substr(0, equals));
  if (equals == std::string::npos || !pixel || pixel->size() != 2) {
    throw OptionError(
        "--point must be X,Y=LAT,LON or X,Y=LAT,LON,H: a pixel, its place, and how many "
        "metres it is above the ground; got \"" +
        text + "\"");
  }
  return {{(*pixel)[0], (*pixel)[1]}, ParsePlace(text.substr(equals + 1))};
}

void PoseFromPlaces(const OnePhotoRequest& request,
                    const std::vector<NamedPoint>& named,
                    OnePhotoCamera& found) {
  const Place& origin = named.front().place;
  std::vector<GroundPoint> points;
  for (const NamedPoint& point : named) {
    if (point.pixel.x() < 0 || point.pixel.x() > found.camera.width_px ||
        point.pixel.y() < 0 || point.pixel.y() > found.camera.height_px) {
      throw OptionError("--point: pixel " + Short(point.pixel.x(), 6) + "," +
                        Short(point.pixel.y(), 6) + " is not in the photo of " +
                        std::to_string(found.camera.width_px) + " x " +
                        std::to_string(found.camera.height_px));
    }
    points.push_back(
        {point.pixel, EnuFromPlace(point.place, point.place.altitude_m, origin)});
  }
  const bool focal_is_guessed = found.focal_from.starts_with("a 4:3 phone's");
  PoseFromPoints pose;
  try {
    pose = FindPose(points, found.camera, focal_is_guessed);
  } catch (const InputError& error) {
    throw InputError(request.photo.string() + ": " + error.what());
  }
  found.camera = pose.camera;
  if (pose.focal_found) {
    found.focal_35mm_mm *=
        pose.camera.focal_px.x() / FocalPixelsFrom35mm(found.focal_35mm_mm,
                                                       pose.camera.width_px,
                                                       pose.camera.height_px);
    found.focal_from = "the points";
  }
  const std::string how = "the points (within " + Short(pose.rms_px, 2) + " px, rms)";
  found.tilt_from = found.heading_from = found.height_from = how;
  found.point_residual_px = pose.residual_px;
  found.position_error_m = pose.position_error_m;
  found.notes.insert(found.notes.end(), pose.notes.begin(), pose.notes.end());
  found.origin = origin;
  found.origin->altitude_m = 0;
  found.origin_is = "the ground at point 1";
}

// --- Foot and sun
// ------------------------------------------------------------------------------

// The tree's foot becomes the origin.
void StandOnFoot(const std::string& text, OnePhotoCamera& found) {
  const auto pixel = Numbers(text);
  if (!pixel || pixel->size() != 2)
    throw OptionError(
        "--foot must be X,Y, the pixel where the trunk meets the ground; "
        "got \"" +
        text + "\"");
  const auto foot = GroundAt(found.camera, {(*pixel)[0], (*pixel)[1]}, 0);
  if (!foot) {
    throw OptionError("--foot: pixel " + text +
                      " is not on the ground below the horizon; look at --foot and "
                      "--horizon again");
  }
  if (found.origin) found.origin = PlaceFromEnu(*foot, *found.origin);
  found.camera.camera_from_world =
      found.camera.camera_from_world * Eigen::Translation3d(*foot);
  found.origin_is = "the tree's foot";
  found.foot_in_world = Eigen::Vector3d::Zero();
}

void FindSun(const Moment& moment, OnePhotoCamera& found) {
  if (!moment.time || !moment.place) return;
  PhotoSun sun;
  sun.time = *moment.time;
  sun.position = SolarPositionAt(moment.time->utc, *moment.place);
  sun.in_camera = found.camera.camera_from_world.linear() * sun.position.direction;
  sun.azimuth_from_ahead_rad =
      RadFromDeg(WrapDeg180(DegFromRad(sun.position.azimuth_rad) - found.heading_deg));
  if (sun.position.elevation_rad <= 0) {
    found.notes.push_back(
        "the sun is " + Short(-DegFromRad(sun.position.elevation_rad)) +
        " deg below the horizon at " + FormatLocal(sun.time) +
        ": if the photo shows daylight, give its own --taken, --zone and --place");
  }
  found.sun = sun;
}

}  // namespace

OnePhotoCamera FindOnePhotoCamera(const OnePhotoRequest& request,
                                  const PhotoFacts& facts,
                                  const cv::Mat3b& display_rgb) {
  RequireThatGoesTogether(request);
  OnePhotoCamera found;
  found.notes = facts.notes;
  std::vector<NamedPoint> points;
  for (const std::string& text : request.points) points.push_back(ParsePoint(text));
  std::optional<Place> of_points;
  if (!points.empty()) of_points = points.front().place;
  const Moment moment = MomentOf(request, facts, of_points, found.notes);

  found.camera = LensOf(request, facts, found);
  if (points.empty()) {
    PoseFromHorizon(request, facts, display_rgb, moment, found);
  } else {
    PoseFromPlaces(request, points, found);
  }

  const Eigen::Matrix3d rotation = found.camera.camera_from_world.linear();
  found.heading_deg = DegFromRad(AzimuthOf(found.camera.ForwardInWorld()));
  found.pitch_deg = DegFromRad(PitchOf(rotation.col(2)));
  found.roll_deg = DegFromRad(RollOf(rotation.col(2)));
  found.height_m = found.camera.PositionInWorld().z();
  if (request.foot) {
    StandOnFoot(*request.foot, found);
  } else {
    found.notes.push_back(
        "where the tree stands is not known (--foot X,Y): the world's "
        "origin is " +
        found.origin_is + "; relight hour puts it at the foot of the matte");
  }
  FindSun(moment, found);
  return found;
}

cv::Mat3b OverlayOf(const OnePhotoCamera& found, const cv::Mat3b& display_rgb) {
  CameraOverlayOptions options;
  options.trunk_foot_in_world = found.foot_in_world;
  if (found.sun) options.sun_in_world = found.sun->position.direction;
  // Adding 0 makes 0 of -0
  const auto tenths = [](double deg) {
    return Short(std::round(10 * deg) / 10 + 0.0, 4);
  };
  options.caption = "heading " + tenths(found.heading_deg) + ", pitch " +
                    tenths(found.pitch_deg) + ", roll " + tenths(found.roll_deg) +
                    " deg, " + Short(found.focal_35mm_mm) + " mm, grid 10 m";
  return CameraOverlay(display_rgb, found.camera, options);
}

fs::path CameraFolderOf(const fs::path& photo) {
  return photo.parent_path() / (photo.stem().string() + "_camera");
}

void WriteOnePhotoCamera(const fs::path& folder,
                         const fs::path& photo,
                         const OnePhotoCamera& found,
                         const cv::Mat3b& overlay) {
  // Neither the photo nor a capture's cameras
  const std::string view = ViewNameOf(photo);
  std::error_code ignored;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt", "overlay.jpg"}) {
    if (fs::equivalent(folder / name, photo, ignored)) {
      throw InputError((folder / name).string() +
                       ": is the photo itself; give another folder with -o");
    }
  }
  if (fs::exists(folder / "images.txt", ignored)) {
    const auto cameras = ReadColmap(folder).cameras;
    if (cameras.size() != 1 || cameras.front().view != view) {
      throw InputError(folder.string() + ": holds cameras of other photos (" +
                       cameras.front().view +
                       "), which are not written over; give another folder with -o");
    }
  }
  CalibratedScene scene;
  scene.cameras = {{view, found.camera}};
  WriteColmap(folder, scene);
  nlohmann::json made = {{"overlay_of", photo.filename().string()},
                         {"heading_deg", found.heading_deg},
                         {"pitch_deg", found.pitch_deg},
                         {"roll_deg", found.roll_deg},
                         {"height_m", found.height_m},
                         {"focal_35mm_mm", found.focal_35mm_mm}};
  WriteSheet(folder / "overlay.jpg",
             overlay,
             {std::string("relight ") + Version(), made.dump()});
}

std::optional<Camera> CameraBeside(const fs::path& photo, int width_px, int height_px) {
  const fs::path folder = CameraFolderOf(photo);
  std::error_code ignored;
  if (!fs::exists(folder / "images.txt", ignored)) return std::nullopt;
  const std::string remedy = "; make it again with: relight cameras " + photo.string();
  const std::vector<NamedCamera> cameras = ReadColmap(folder).cameras;
  if (cameras.size() != 1) {
    throw InputError(folder.string() + ": holds " + std::to_string(cameras.size()) +
                     " cameras, and one photo has one" + remedy);
  }
  const Camera& camera = cameras.front().camera;
  const double stretch = static_cast<double>(width_px) * camera.height_px /
                         (static_cast<double>(height_px) * camera.width_px);
  if (std::abs(stretch - 1) > 0.01) {
    throw InputError(folder.string() + ": its camera is of a picture of " +
                     std::to_string(camera.width_px) + " x " +
                     std::to_string(camera.height_px) + " pixels, the photo is " +
                     std::to_string(width_px) + " x " + std::to_string(height_px) +
                     remedy);
  }
  return camera.Resized(width_px, height_px);
}

}  // namespace relight
