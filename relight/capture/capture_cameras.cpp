// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_cameras.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/colmap_model.h"
#include "relight/cameras/import_cameras.h"
#include "relight/cameras/level_camera.h"
#include "relight/cameras/view_name.h"
#include "relight/capture/capture_folder.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/image_file.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/read_photo.h"
#include "relight/photo/true_heading.h"
#include "relight/photo/write_photo.h"
#include "relight/sky/solar_position.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <sstream>
#include <system_error>
#include <tuple>

namespace relight {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

// --- Texts of the command line ------------------------------------------------------

// "1,2,3": that many numbers. Throws OptionError.
std::vector<double> Numbers(const std::string& text,
                            std::size_t count,
                            const char* what) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) break;
    numbers.push_back(value);
    at = next;
    if (at < end && *at == ',') ++at;
  }
  if (at == end && numbers.size() == count) return numbers;
  throw OptionError(std::string(what) + ", got \"" + text + "\"");
}

KnownHeading HeadingFrom(const std::string& text, const std::string& first_view) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) {
    return {first_view, RadFromDeg(ParseHeading(text))};
  }
  return {text.substr(0, equals), RadFromDeg(ParseHeading(text.substr(equals + 1)))};
}

// --- What the photos say ------------------------------------------------------------

struct PhotoOfView {
  ViewEntry entry;
  PhotoFacts facts;
  std::optional<LocalTime> time;
};

std::vector<PhotoOfView> PhotosOf(const Capture& capture) {
  std::vector<PhotoOfView> photos;
  for (const ViewEntry& entry : capture.file.views) {
    PhotoOfView photo{entry, ReadPhotoFacts(capture.PhotoOf(entry)), {}};
    try {
      const auto taken = entry.taken              ? entry.taken
                         : photo.facts.local_time ? std::nullopt
                                                  : capture.file.taken;
      photo.time = ResolveCaptureTime(photo.facts, capture.file.zone, taken).time;
    } catch (const InputError&) {
      // Cameras need no time; who needs it says so
    }
    photos.push_back(std::move(photo));
  }
  return photos;
}

std::vector<CameraClues> CluesOf(const Capture& capture,
                                 const std::vector<PhotoOfView>& photos,
                                 std::vector<std::string>& notes) {
  std::vector<CameraClues> clues;
  std::set<std::string> said;
  for (const PhotoOfView& photo : photos) {
    CameraClues clue{.view = photo.entry.name, .place = photo.facts.place};
    if (photo.facts.heading_deg && !photo.facts.heading_is_magnetic) {
      clue.heading_rad = RadFromDeg(*photo.facts.heading_deg);
    } else if (photo.facts.heading_deg) {
      std::optional<Place> place = photo.facts.place;
      if (!place && capture.file.place) place = ParsePlace(*capture.file.place);
      if (place && photo.time) {
        const TrueHeading heading =
            TrueFromMagnetic(*photo.facts.heading_deg, *place, photo.time->utc);
        clue.heading_rad = RadFromDeg(heading.heading_deg);
        for (const std::string& note : heading.declination.notes) {
          if (said.insert(note).second) notes.push_back(note);
        }
      }
    }
    clues.push_back(clue);
  }
  return clues;
}

// --- COLMAP -------------------------------------------------------------------------

const fs::path kWork = fs::path("cache") / "colmap";

// The part of a photo where nothing moves: all but what is above the tree's lower quarter
// and no tree. A camera at eye height has its horizon there.
cv::Mat1b StillPart(const cv::Mat1f& alpha) {
  int top = -1, bottom = -1;
  for (int y = 0; y < alpha.rows; ++y) {
    if (cv::countNonZero(alpha.row(y) > 0.5f) == 0) continue;
    if (top < 0) top = y;
    bottom = y;
  }
  cv::Mat1b still(alpha.size(), std::uint8_t{255});
  if (top < 0) return still;
  const int horizon = bottom - (bottom - top) / 4;
  cv::Mat1b tree = alpha > 0.1f;
  cv::dilate(tree, tree, cv::Mat(), {-1, -1}, 4);
  tree.rowRange(0, horizon).copyTo(still.rowRange(0, horizon));
  return still;
}

// Upright pictures that COLMAP can read, in cache/: links to JPEGs that are so already,
// copies of the others.
ColmapJob MakeJob(const Capture& capture,
                  const std::vector<PhotoOfView>& photos,
                  const ColmapOptions& options,
                  const Progress& progress) {
  ColmapJob job;
  MakeFolderOf(capture.folder, "cache");
  std::error_code error;
  fs::remove_all(capture.folder / "cache" / "photos", error);
  fs::remove_all(capture.folder / "cache" / "masks", error);
  job.photos = MakeFolderOf(capture.folder, fs::path("cache") / "photos");
  job.work = MakeFolderOf(capture.folder, kWork);
  const fs::path masks = MakeFolderOf(capture.folder, fs::path("cache") / "masks");

  int masked = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const auto& [entry, facts, time] = photos[i];
    progress.Report(static_cast<double>(i) / static_cast<double>(photos.size()));
    const fs::path photo = fs::absolute(capture.PhotoOf(entry));
    std::string extension = photo.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(c));
    PhotoSize size{facts.width, facts.height};
    std::string name = entry.name + ".jpg";
    const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
    if (is_jpeg && facts.orientation == 1) {
      fs::create_symlink(photo, job.photos / name, error);
      if (error) fs::copy_file(photo, job.photos / name, error);
    } else {
      Photo pixels = ReadPhoto(photo);
      const double shrink = std::max(
          {1.0, std::max(size.width_px, size.height_px) / (1.5 * options.longest_px)});
      size = {static_cast<int>(std::lround(size.width_px / shrink)),
              static_cast<int>(std::lround(size.height_px / shrink))};
      cv::resize(pixels.pixels,
                 pixels.pixels,
                 {size.width_px, size.height_px},
                 0,
                 0,
                 cv::INTER_AREA);
      pixels.alpha.release();
      WritePhoto(job.photos / name, pixels, {"relight", "{}"});
    }
    if (const auto matte = FileOfView(capture, "mattes", entry.name)) {
      cv::Mat1f alpha = ReadMatte(*matte);
      cv::resize(alpha, alpha, {size.width_px, size.height_px}, 0, 0, cv::INTER_AREA);
      cv::Mat1f still;
      StillPart(alpha).convertTo(still, CV_32F, 1 / 255.0);
      WriteMatte(masks / (name + ".png"), still);
      ++masked;
    }

    // Photos of one size and focal length share a lens
    std::optional<double> focal_px;
    if (facts.focal_35mm_mm) {
      focal_px = FocalPixelsFrom35mm(*facts.focal_35mm_mm, size.width_px, size.height_px);
    }
    const auto same =
        std::find_if(job.groups.begin(), job.groups.end(), [&](const ColmapGroup& group) {
          return group.size.width_px == size.width_px &&
                 group.size.height_px == size.height_px && group.focal_px == focal_px;
        });
    if (same != job.groups.end()) {
      same->files.push_back(name);
    } else {
      job.groups.push_back({{name}, size, focal_px});
    }
  }
  if (masked > 0) job.masks = masks;
  return job;
}

// What a run needs to be foretold, without touching a file.
ColmapJob JobOfSizes(const std::vector<PhotoOfView>& photos) {
  ColmapJob job;
  for (const PhotoOfView& photo : photos) {
    job.groups.push_back(
        {{photo.entry.name}, {photo.facts.width, photo.facts.height}, {}});
  }
  return job;
}

// --- From a model to the capture ----------------------------------------------------

bool HasProportions(const Camera& camera, int width, int height) {
  const double stretch = static_cast<double>(camera.width_px) * height /
                         (static_cast<double>(camera.height_px) * width);
  return std::abs(stretch - 1) <= 0.01;
}

// The camera of the upright photo at its own size, from that of the picture that a
// program read: as stored, when `orientation` turns it upright.
Camera ForPhoto(const Camera& camera, const PhotoFacts& facts, int orientation) {
  const bool lies = orientation == 6 || orientation == 8;
  if (orientation == 3 || (lies && HasProportions(camera, facts.height, facts.width))) {
    return camera.Upright(orientation).Resized(facts.width, facts.height);
  }
  if (!HasProportions(camera, facts.width, facts.height)) {
    throw InputError(facts.file + ": is " + std::to_string(facts.width) + " x " +
                     std::to_string(facts.height) + " pixels, its camera " +
                     std::to_string(camera.width_px) + " x " +
                     std::to_string(camera.height_px) +
                     ": not the same picture; give the photos that the model was made "
                     "from");
  }
  return camera.Resized(facts.width, facts.height);
}

std::string Listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 12;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    list += (i > 0 ? ", " : "") + names[i];
  }
  if (names.size() > kMost)
    list += " and " + std::to_string(names.size() - kMost) + " more";
  return list;
}

// Only the cameras of the capture's photos, in the photos' own pixels.
void MatchPhotos(const Capture& capture,
                 const std::vector<PhotoOfView>& photos,
                 const CamerasRequest& request,
                 CamerasSummary& summary) {
  // COLMAP was given upright copies here, and Metashape says itself how its photos lie;
  // other programs do not heed the EXIF orientation
  const bool is_as_stored =
      request.import &&
      (request.import_format.empty() ? GuessCameraFormat(*request.import)
                                     : request.import_format) != "metashape";
  std::vector<NamedCamera> kept;
  std::vector<std::string> without_photo;
  for (NamedCamera& named : summary.scene.cameras) {
    const auto photo =
        std::find_if(photos.begin(), photos.end(), [&](const PhotoOfView& p) {
          return p.entry.name == named.view;
        });
    if (photo == photos.end()) {
      without_photo.push_back(named.view);
      continue;
    }
    kept.push_back(
        {named.view,
         ForPhoto(
             named.camera, photo->facts, is_as_stored ? photo->facts.orientation : 1)});
  }
  for (const PhotoOfView& photo : photos) {
    const bool has = std::any_of(kept.begin(), kept.end(), [&](const NamedCamera& named) {
      return named.view == photo.entry.name;
    });
    if (!has) summary.missing.push_back(photo.entry.name);
  }
  if (kept.empty()) {
    throw InputError((request.import ? request.import->string() : "COLMAP's model") +
                     ": none of its images has the name of a photo in " +
                     capture.folder.string() + " (extensions do not count)");
  }
  if (request.import && !request.matching_only &&
      (!without_photo.empty() || !summary.missing.empty())) {
    std::string what;
    if (!without_photo.empty()) {
      what += "cameras without a photo in the capture: " + Listed(without_photo);
    }
    if (!summary.missing.empty()) {
      what += (what.empty() ? "" : "; ") +
              std::string("photos without a camera in the model: ") +
              Listed(summary.missing);
    }
    throw InputError(
        request.import->string() + ": " + what +
        "; add what is missing, or take only those that match with --matching-only");
  }
  summary.scene.cameras = std::move(kept);
}

GivenFrame GivenBy(const CamerasRequest& request,
                   const Capture& capture,
                   const std::vector<PhotoOfView>& photos,
                   const std::string& first_view) {
  GivenFrame given;
  if (request.up) {
    const auto up =
        Numbers(*request.up, 3, "up is a direction X,Y,Z in the model's frame");
    given.up = Eigen::Vector3d(up[0], up[1], up[2]);
    if (given.up->norm() == 0) throw OptionError("up 0,0,0 is no direction");
  }
  if (request.heading) {
    given.heading = HeadingFrom(*request.heading, first_view);
  }
  if (!request.scale_from.empty()) {
    const double length_m = Numbers(
        request.scale_from.at(2), 1, "scale-from ends with a length in metres")[0];
    if (!(length_m > 0)) throw OptionError("scale-from needs a length above 0 m");
    if (request.scale_from.at(0) == request.scale_from.at(1)) {
      throw OptionError("scale-from needs two views, got " + request.scale_from.at(0) +
                        " twice");
    }
    given.distance = {request.scale_from.at(0), request.scale_from.at(1), length_m};
  }
  if (!request.north_from_shadow.empty()) {
    const std::string& view = request.north_from_shadow.at(0);
    const char* form =
        "north-from-shadow is VIEW x1,y1 x2,y2, from the shadow's foot to "
        "its tip, in pixels";
    const auto foot = Numbers(request.north_from_shadow.at(1), 2, form);
    const auto tip = Numbers(request.north_from_shadow.at(2), 2, form);
    FindView(capture, view);
    const auto photo =
        std::find_if(photos.begin(), photos.end(), [&](const PhotoOfView& p) {
          return p.entry.name == view;
        });
    std::optional<Place> place = photo->facts.place;
    if (!place && capture.file.place) place = ParsePlace(*capture.file.place);
    if (!place || !photo->time) {
      throw InputError(photo->facts.file +
                       ": no time or no place, so that its sun is not known; write "
                       "taken = \"…\" and place = \"LAT,LON\" into " +
                       (capture.folder / "capture.toml").string());
    }
    const SolarPosition sun = SolarPositionAt(photo->time->utc, *place);
    if (sun.elevation_rad <= 0) {
      throw InputError(photo->facts.file + ": the sun was below the horizon at " +
                       FormatLocal(*photo->time) + "; it threw no shadow");
    }
    given.shadow = {view, {foot[0], foot[1]}, {tip[0], tip[1]}, sun.azimuth_rad};
  }
  return given;
}

std::optional<Eigen::Vector3d> OriginFrom(const CamerasRequest& request) {
  if (!request.origin) return std::nullopt;
  const auto at =
      Numbers(*request.origin, 3, "origin is a point X,Y,Z in metres east, north and up");
  return Eigen::Vector3d(at[0], at[1], at[2]);
}

bool HasAny(const GivenFrame& given) {
  return given.up || given.heading || given.distance || given.shadow;
}

// The scene in ENU metres, by what is known.
void PutOnEarth(const CamerasRequest& request,
                const std::vector<CameraClues>& clues,
                const GivenFrame& given,
                CamerasSummary& summary) {
  CalibratedScene& scene = summary.scene;
  const bool has_clues =
      HasAny(given) ||
      std::any_of(clues.begin(), clues.end(), [](const CameraClues& clue) {
        return clue.place || clue.heading_rad;
      });
  if (request.keep_frame || scene.enu_origin) return;
  if (!has_clues && request.import) {
    summary.notes.push_back(
        "no photo says where it was taken nor which way it looks, so that the model's "
        "world is taken as east, north, up in metres");
    return;
  }
  summary.georeference = FindGeoreference(scene, clues, given, request.georeference);
  const Georeference& found = *summary.georeference;
  if (found.kept_frame) {
    // Not moved by a digit; only the place of its origin is new
    if (found.origin) {
      CalibratedScene origin;
      origin.enu_origin = found.origin;
      scene.enu_origin = MovedTo(origin, found.translation).enu_origin;
    }
    return;
  }
  scene = InWorld(scene, found);
}

json FrameJson(const CamerasSummary& summary) {
  json frame = {{"frame", "east, north, up in metres"},
                {"made_by", summary.made_by},
                {"missing", summary.missing},
                {"notes", summary.notes}};
  if (const auto& origin = summary.scene.enu_origin) {
    frame["origin"] = {origin->latitude_deg, origin->longitude_deg, origin->altitude_m};
  }
  if (const auto& found = summary.georeference) {
    frame["north"] = {{"from", found->north_from},
                      {"error_deg", DegFromRad(found->north_error_rad)}};
    frame["up"] = {{"from", found->up_from},
                   {"error_deg", DegFromRad(found->up_error_rad)}};
    frame["scale"] = {{"from", found->scale_from}, {"error", found->scale_error}};
    frame["kept"] = found->kept_frame;
    for (const ViewResidual& residual : found->residuals) {
      json view = {{"view", residual.view}};
      if (residual.gps_m) view["gps_m"] = *residual.gps_m;
      if (residual.compass_rad) view["compass_deg"] = DegFromRad(*residual.compass_rad);
      view["gps_is_outlier"] = residual.gps_is_outlier;
      view["compass_is_outlier"] = residual.compass_is_outlier;
      frame["residuals"].push_back(view);
    }
  }
  frame["ground"] = {{"from", summary.tree.ground_from},
                     {"z_m", summary.tree.foot.z()},
                     {"error_m", summary.tree.ground_error_m},
                     {"slope_deg", DegFromRad(summary.tree.slope_rad)}};
  frame["tree_foot_m"] = {
      summary.tree.foot.x(), summary.tree.foot.y(), summary.tree.foot.z()};
  return frame;
}

std::string Degrees(double angle_rad) {
  std::ostringstream text;
  text.precision(3);
  text << DegFromRad(angle_rad);
  return text.str();
}

// Whether cameras/ holds a model, and who made it. Throws what KeptCameras throws.
std::optional<CamerasSummary> CamerasThere(const Capture& capture) {
  std::error_code ignored;
  if (!fs::exists(capture.folder / "cameras" / "images.txt", ignored)) return {};
  return KeptCameras(capture);
}

// The kept scene with what the request says of its frame, and all else as it is. Its
// origin stays where it is among the cameras.
void TurnKept(const CamerasRequest& request,
              const std::vector<CameraClues>& clues,
              GivenFrame given,
              CamerasSummary& summary) {
  if (request.keep_frame || !HasAny(given)) return;
  CalibratedScene& scene = summary.scene;
  const std::optional<Georeference> before = summary.georeference;
  const bool says_north = given.heading || given.shadow;
  const bool says_up = given.up.has_value(), says_scale = given.distance.has_value();

  // The frame as it is, of what is not said
  if (!says_up) given.up = Eigen::Vector3d::UnitZ();
  if (!says_north) {
    // The most level camera says its heading best
    const auto level = std::min_element(
        scene.cameras.begin(), scene.cameras.end(), [](const auto& a, const auto& b) {
          return std::abs(a.camera.ForwardInWorld().z()) <
                 std::abs(b.camera.ForwardInWorld().z());
        });
    given.heading = {level->view, AzimuthOf(level->camera.ForwardInWorld())};
  }
  if (!says_scale) {
    const NamedCamera& first = scene.cameras.front();
    const auto away_m = [&](const NamedCamera& other) {
      return (other.camera.PositionInWorld() - first.camera.PositionInWorld()).norm();
    };
    const auto farthest = std::max_element(
        scene.cameras.begin(), scene.cameras.end(), [&](const auto& a, const auto& b) {
          return away_m(a) < away_m(b);
        });
    if (away_m(*farthest) > 0) {
      given.distance = {first.view, farthest->view, away_m(*farthest)};
    }
  }
  Georeference found = FindGeoreference(scene, clues, given, request.georeference);
  if (!found.kept_frame) {
    const std::optional<Place> origin = scene.enu_origin;
    scene = MovedTo(InWorld(scene, found), found.ToWorld(Eigen::Vector3d::Zero()));
    if (origin) scene.enu_origin = origin;
  }

  // Who told what is kept
  const auto keep = [&](std::string Georeference::*from, double Georeference::*error) {
    found.*from = before ? (*before).*from : "the frame that they had, taken as right";
    if (before) found.*error = (*before).*error;
  };
  if (!says_north) keep(&Georeference::north_from, &Georeference::north_error_rad);
  if (!says_up) keep(&Georeference::up_from, &Georeference::up_error_rad);
  if (!says_scale) keep(&Georeference::scale_from, &Georeference::scale_error);
  summary.georeference = std::move(found);
}

}  // namespace

bool TurnsKept(const Capture& capture, const CamerasRequest& request) {
  const bool says = request.heading || request.up || !request.scale_from.empty() ||
                    !request.north_from_shadow.empty() || request.origin ||
                    request.keep_frame;
  std::error_code ignored;
  return says && !request.import && !request.force &&
         fs::exists(capture.folder / "cameras" / "images.txt", ignored);
}

CamerasPlan PlanCameras(const Capture& capture, const CamerasRequest& request) {
  if (request.import) return {"importing " + request.import->string(), 0};
  if (TurnsKept(capture, request)) {
    return {
        "the cameras that are there are put on the Earth anew (--force: COLMAP finds "
        "others)",
        0};
  }
  const std::vector<PhotoOfView> photos = PhotosOf(capture);
  const bool exhaustive = IsExhaustive(request.colmap, photos.size());
  return {"COLMAP looks at " + std::to_string(photos.size()) + " photos and compares " +
              (exhaustive ? "each with each" : "each with the ten after it"),
          ColmapSeconds(JobOfSizes(photos), request.colmap)};
}

CamerasSummary MakeCameras(const Capture& capture,
                           const CamerasRequest& request,
                           const Progress& progress) {
  const std::vector<PhotoOfView> photos = PhotosOf(capture);
  const std::optional<Eigen::Vector3d> origin = OriginFrom(request);
  if (!photos.empty()) {
    // What cannot be meant is told before COLMAP's minutes
    static_cast<void>(GivenBy(request, capture, photos, photos.front().entry.name));
  }
  CamerasSummary summary;
  const bool turns = TurnsKept(capture, request);
  if (turns) {
    summary = KeptCameras(capture);
    summary.missing.clear();
    summary.notes.clear();
  } else if (request.import) {
    PhotoSizes sizes;
    for (const PhotoOfView& photo : photos) {
      sizes[photo.entry.name] = {photo.facts.width, photo.facts.height};
    }
    summary.scene = ImportCameras(
        request.import_format,
        *request.import,
        sizes,
        request.matching_only ? UnknownPhotos::kLeaveOut : UnknownPhotos::kRefuse);
    summary.made_by = "import of " + request.import->string();
  } else {
    const auto there = request.force ? std::nullopt : CamerasThere(capture);
    if (there && there->made_by != "COLMAP") {
      throw InputError(
          (capture.folder / "cameras").string() + ": holds cameras already, " +
          (there->made_by == "unknown" ? "not made by relight" : "by " + there->made_by) +
          "; say what to change of them (--heading, --up, --scale-from, "
          "--north-from-shadow, --origin), import others (--import), or let "
          "COLMAP find others in their place (--force)");
    }
    if (photos.size() < 3) {
      throw InputError(capture.folder.string() + ": has " +
                       std::to_string(photos.size()) +
                       " photos, and COLMAP needs several that overlap; for one photo "
                       "alone: relight cameras PHOTO");
    }
    const ColmapJob job =
        MakeJob(capture, photos, request.colmap, progress.Part(0, 0.05));
    ColmapSummary found = RunColmap(job, request.colmap, progress.Part(0.05, 0.98));
    summary.scene = std::move(found.scene);
    summary.made_by = "COLMAP";
    summary.notes = std::move(found.notes);
    if (found.models > 1) {
      summary.notes.push_back("the photos fall into " + std::to_string(found.models) +
                              " groups that do not fit together; the largest is taken");
    }
  }
  summary.notes.insert(
      summary.notes.end(), summary.scene.notes.begin(), summary.scene.notes.end());
  MatchPhotos(capture, photos, request, summary);

  const std::vector<CameraClues> clues = CluesOf(capture, photos, summary.notes);
  const bool has_place = summary.scene.enu_origin.has_value();
  const std::string& first_view = summary.scene.cameras.front().view;
  const GivenFrame given = GivenBy(request, capture, photos, first_view);
  if (turns) {
    TurnKept(request, clues, given, summary);
  } else {
    PutOnEarth(request, clues, given, summary);
  }
  if (summary.georeference) {
    const auto& said = summary.georeference->notes;
    summary.notes.insert(summary.notes.end(), said.begin(), said.end());
  }

  // The tree's foot becomes the origin, unless the frame is the user's own
  summary.tree = FindTreePlace(summary.scene);
  const bool is_own =
      turns || request.keep_frame ||
      (summary.georeference ? summary.georeference->kept_frame : !has_place);
  if (origin) {
    summary.tree.foot = *origin;
    summary.tree.ground_from = "--origin";
  }
  if (origin || !is_own) {
    summary.scene = MovedTo(summary.scene, summary.tree.foot);
    summary.tree.foot.setZero();
  }
  if (!summary.missing.empty()) {
    summary.notes.push_back("without a camera: " + Listed(summary.missing) +
                            "; they are left out. What helps: more photos between them "
                            "and their neighbours, the same exposure, nothing blurred");
  }
  constexpr double kWide_rad = 20 * kRadPerDeg;
  if (summary.tree.is_looked_at) {
    std::vector<std::string> gaps;
    for (const ViewGap& gap : GapsAround(summary.scene, summary.tree.foot, kWide_rad)) {
      gaps.push_back(Degrees(gap.gap_rad) + " deg from " + gap.from + " to " + gap.to);
    }
    if (!gaps.empty()) {
      summary.notes.push_back("gaps between neighbours around the tree: " + Listed(gaps) +
                              "; photos in between make its volume better");
    }
  }

  const fs::path folder = MakeFolderOf(capture.folder, "cameras");
  WriteColmap(folder, summary.scene);
  WriteTextWhole(folder / "frame.json", FrameJson(summary).dump(1) + "\n");
  progress.Report(1);
  return summary;
}

CalibratedScene SceneOf(const Capture& capture) {
  static_cast<void>(CamerasOf(capture));
  CalibratedScene scene = ReadColmap(capture.folder / "cameras");
  const fs::path frame_file = capture.folder / "cameras" / "frame.json";
  std::error_code ignored;
  if (!fs::is_regular_file(frame_file, ignored)) return scene;
  const json frame =
      json::parse(ReadText(frame_file, 10'000'000), nullptr, /*allow_exceptions=*/false);
  if (!frame.is_object() || !frame.contains("origin")) return scene;
  const json& origin = frame["origin"];
  const bool is_place = origin.is_array() && origin.size() == 3 &&
                        std::all_of(origin.begin(), origin.end(), [](const json& n) {
                          return n.is_number();
                        });
  if (is_place) scene.enu_origin = Place{origin[0], origin[1], origin[2]};
  return scene;
}

CamerasSummary KeptCameras(const Capture& capture) {
  CamerasSummary summary;
  summary.scene = SceneOf(capture);
  summary.tree = FindTreePlace(summary.scene);
  summary.made_by = "unknown";
  const fs::path file = capture.folder / "cameras" / "frame.json";
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return summary;
  const json frame = json::parse(ReadText(file, 10'000'000), nullptr, false);
  try {
    summary.made_by = frame.at("made_by");
    summary.missing = frame.value("missing", summary.missing);
    summary.notes = frame.value("notes", summary.notes);
    summary.tree.ground_from = frame.at("ground").at("from");
    if (!frame.contains("north")) return summary;
    Georeference found;
    found.kept_frame = frame.at("kept");
    found.north_from = frame.at("north").at("from");
    found.north_error_rad = RadFromDeg(frame.at("north").at("error_deg"));
    found.up_from = frame.at("up").at("from");
    found.up_error_rad = RadFromDeg(frame.at("up").at("error_deg"));
    found.scale_from = frame.at("scale").at("from");
    found.scale_error = frame.at("scale").at("error");
    for (const json& view : frame.value("residuals", json::array())) {
      ViewResidual residual{.view = view.at("view")};
      if (view.contains("gps_m")) residual.gps_m = view.at("gps_m");
      if (view.contains("compass_deg"))
        residual.compass_rad = RadFromDeg(view.at("compass_deg"));
      residual.gps_is_outlier = view.at("gps_is_outlier");
      residual.compass_is_outlier = view.at("compass_is_outlier");
      found.residuals.push_back(residual);
    }
    summary.georeference = found;
  } catch (const json::exception&) {
    summary.notes.push_back(file.string() +
                            ": was changed and cannot be read; \"relight cameras\" "
                            "writes it again");
  }
  return summary;
}

std::vector<ViewGap> GapsAround(const CalibratedScene& scene,
                                const Eigen::Vector3d& foot,
                                double least_rad) {
  struct Around {
    double azimuth_rad;
    std::string view;
  };
  std::vector<Around> ring;
  for (const auto& [view, camera] : scene.cameras) {
    ring.push_back({AzimuthOf(camera.PositionInWorld() - foot), view});
  }
  std::sort(ring.begin(), ring.end(), [](const Around& a, const Around& b) {
    return std::tie(a.azimuth_rad, a.view) < std::tie(b.azimuth_rad, b.view);
  });
  std::vector<ViewGap> gaps;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Around& next = ring[(i + 1) % ring.size()];
    double gap_rad = next.azimuth_rad - ring[i].azimuth_rad;
    if (i + 1 == ring.size()) gap_rad += 2 * std::numbers::pi;
    if (gap_rad > least_rad) gaps.push_back({ring[i].view, next.view, gap_rad});
  }
  return gaps;
}

}  // namespace relight
