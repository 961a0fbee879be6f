// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/metashape_file.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/camera_parts.h"
#include "relight/cameras/number_text.h"

#include <GeographicLib/Geocentric.hpp>
#include <pugixml.hpp>

#include <algorithm>
#include <cstring>
#include <map>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLimitBytes = 500'000'000;
constexpr const char* kRemedy =
    "export the cameras again with File > Export > Export Cameras, Agisoft XML";
constexpr const char* kOtherLens =
    "; in Optimize Cameras clear it and export again, or export undistorted photos with "
    "their cameras";

// x_world = scale rotation x + translation.
struct Similarity {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

// A camera in its chunk.
struct ChunkCamera {
  std::string label;
  std::string component;
  int quarter_turns;  // Clockwise, that make the photo upright.
  Camera camera;      // Without a pose.
  Eigen::Matrix3d axes;
  Eigen::Vector3d position;
};

class Document {
 public:
  explicit Document(const fs::path& file) : file_(file.string()) {
    const std::string text = ReadText(file, kLimitBytes);
    const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
    if (!result) {
      const auto at = std::min<std::size_t>(
          static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)),
          text.size());
      const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
      const auto line = 1 + std::count(text.begin(), end, '\n');
      throw InputError(file_ + ":" + std::to_string(line) +
                       ": is no XML from here on, or is cut off (" +
                       result.description() + "); " + kRemedy);
    }
  }
  pugi::xml_node Chunk() const {
    const pugi::xml_node chunk = document_.child("document").child("chunk");
    if (!chunk) Fail("has no <document> with a <chunk>");
    if (chunk.next_sibling("chunk")) {
      throw InputError(file_ + ": has several chunks; export one of them");
    }
    return chunk;
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(file_ + ": " + what + "; " + kRemedy);
  }
  [[noreturn]] void Refuse(const std::string& what, const std::string& remedy) const {
    throw InputError(file_ + ": " + what + remedy);
  }
  const std::string& File() const { return file_; }

  // The number in an element below `node`; `otherwise` when there is none.
  double NumberOr(pugi::xml_node node, const char* name, double otherwise) const {
    const pugi::xml_node child = node.child(name);
    if (!child) return otherwise;
    const auto number = NumberFrom(child.text().get());
    if (!number) Fail(std::string("<") + name + "> is no number");
    return *number;
  }
  std::vector<double> Numbers(pugi::xml_node node, std::size_t count) const {
    const auto numbers = NumbersFrom(node.text().get());
    if (!numbers || numbers->size() != count) {
      Fail(std::string("<") + node.name() + "> does not have " + std::to_string(count) +
           " numbers");
    }
    return *numbers;
  }

 private:
  std::string file_;
  pugi::xml_document document_;
};

// --- Sensors -------------------------------------------------------------------------

pugi::xml_node CalibrationOf(pugi::xml_node sensor) {
  for (const pugi::xml_node calibration : sensor.children("calibration")) {
    if (std::strcmp(calibration.attribute("class").value(), "adjusted") == 0) {
      return calibration;
    }
  }
  return sensor.child("calibration");
}

void SetSize(Camera& camera,
             pugi::xml_node sensor,
             pugi::xml_node calibration,
             const Document& document) {
  for (const pugi::xml_node node : {calibration, sensor}) {
    const pugi::xml_node resolution = node.child("resolution");
    const auto w = NumberFrom(resolution.attribute("width").value());
    const auto h = NumberFrom(resolution.attribute("height").value());
    const auto width = SizeFrom(w.value_or(0)), height = SizeFrom(h.value_or(0));
    if (!width || !height) continue;
    camera.width_px = *width;
    camera.height_px = *height;
    return;
  }
  document.Fail(std::string("the sensor \"") + sensor.attribute("label").value() +
                "\" has no resolution");
}

// How far the terms that no Camera has move a point in the frame, at the most.
struct Unexpressed {
  double skew_px, tangential_px;
};

Unexpressed ShiftOf(const Camera& camera,
                    double b2,
                    const std::array<double, 4>& p,
                    bool p1_too) {
  // Beyond the frame by a fifth: r is the undistorted distance
  const double r = 1.2 * CornerRadius(camera), r2 = r * r;
  const double tangential = 3 * (std::abs(p[0]) + std::abs(p[1])) * r2;
  const double factor =
      (p1_too ? 1.0 : 0.0) + std::abs(p[2]) * r2 + std::abs(p[3]) * r2 * r2;
  return {std::abs(b2) * r, tangential * factor * camera.focal_px.maxCoeff()};
}

Camera ReadSensor(pugi::xml_node sensor, const Document& document) {
  const std::string name =
      std::string("the sensor \"") + sensor.attribute("label").value() + "\"";
  const pugi::xml_node calibration = CalibrationOf(sensor);
  if (!calibration) document.Fail(name + " has no calibration: align the photos first");
  const pugi::xml_attribute given = calibration.attribute("type");
  const std::string type = given                      ? given.value()
                           : sensor.attribute("type") ? sensor.attribute("type").value()
                                                      : "frame";
  const bool fisheye = type == "fisheye" || type == "equidistant_fisheye";
  if (type != "frame" && !fisheye) {
    document.Refuse(name + " is of the type " + type +
                        ", which is not read; known are frame and fisheye",
                    "; export undistorted photos with their cameras");
  }
  for (const pugi::xml_node node : {sensor, calibration}) {
    if (node.child("corrections")) {
      document.Refuse(name + " has additional corrections, which are not read",
                      kOtherLens);
    }
  }

  Camera camera;
  SetSize(camera, sensor, calibration, document);
  const auto number = [&](const char* of) {
    return document.NumberOr(calibration, of, 0);
  };
  const bool photoscan_1_1 = static_cast<bool>(calibration.child("fx"));
  std::array<double, 4> p = {number("p1"), number("p2"), number("p3"), number("p4")};
  double skew = number("b2");
  camera.center_px = {number("cx"), number("cy")};
  if (photoscan_1_1) {
    skew = number("skew");
    camera.focal_px = {number("fx"), number("fy")};
    std::swap(p[0], p[1]);
  } else {
    camera.focal_px = {number("f") + number("b1"), number("f")};
    camera.center_px += Eigen::Vector2d(camera.width_px, camera.height_px) / 2;
  }
  if (!(camera.focal_px.minCoeff() > 0)) {
    document.Fail(name + " has no focal length <f> above 0");
  }

  const Unexpressed shift = ShiftOf(camera, skew, p, fisheye);
  if (!(shift.skew_px < kIgnoredShift_px)) {
    document.Refuse(name + " has a skew (b2) of " + std::to_string(skew) +
                        " pixels, which is not read",
                    kOtherLens);
  }
  if (!(shift.tangential_px < kIgnoredShift_px)) {
    document.Refuse(name + (fisheye ? " is a fisheye with p1 or p2" : " has p3 or p4") +
                        ", which is not read",
                    kOtherLens);
  }
  const std::array<double, 4> k = {
      number("k1"), number("k2"), number("k3"), number("k4")};
  if (fisheye) {
    camera.lens = {
        .k1 = k[0], .k2 = k[1], .k3 = k[2], .k4 = k[3], .model = LensModel::kFisheye};
    return camera;
  }
  camera.lens.p1 = p[1];
  camera.lens.p2 = p[0];
  if (!SetRadialPolynomial(camera, k)) {
    document.Refuse(name + " has a k4 of " + std::to_string(k[3]) +
                        ", which is too strong to be read",
                    kOtherLens);
  }
  return camera;
}

// --- Cameras -------------------------------------------------------------------------

Similarity ReadTransform(pugi::xml_node transform, const Document& document) {
  Similarity s;
  if (!transform) return s;
  if (const pugi::xml_node rotation = transform.child("rotation")) {
    const std::vector<double> m = document.Numbers(rotation, 9);
    s.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data());
  }
  if (const pugi::xml_node translation = transform.child("translation")) {
    s.translation =
        Eigen::Map<const Eigen::Vector3d>(document.Numbers(translation, 3).data());
  }
  s.scale = document.NumberOr(transform, "scale", 1);
  if (!PoseFromAxes(s.rotation, s.translation) || !(s.scale > 0)) {
    document.Fail("a <transform> is no rotation, translation and scale");
  }
  return s;
}

// Clockwise, for EXIF's orientation of a camera: 1, 6, 3 or 8; mirrored ones are not
// made.
int QuarterTurns(pugi::xml_node camera, const Document& document) {
  const double orientation = document.NumberOr(camera, "orientation", 1);
  if (orientation == 1) return 0;
  if (orientation == 6) return 1;
  if (orientation == 3) return 2;
  if (orientation == 8) return 3;
  document.Refuse(std::string("the photo of the camera \"") +
                      camera.attribute("label").value() + "\" is mirrored",
                  "; turn it in its file and align again");
}

// The camera of the upright photo. Whoever turned the pixels in the file, and left the
// orientation in the project, is seen by the photo's size.
Camera Upright(Camera camera, int quarter_turns, const PhotoSize* photo) {
  if (quarter_turns % 2 == 1 && photo != nullptr && camera.width_px != camera.height_px &&
      photo->width_px == camera.width_px && photo->height_px == camera.height_px) {
    return camera;
  }
  for (int turn = 0; turn < quarter_turns; ++turn) camera = QuarterTurned(camera);
  return camera;
}

// All <camera>, in groups too.
std::vector<pugi::xml_node> CameraNodes(pugi::xml_node cameras) {
  std::vector<pugi::xml_node> found, open = {cameras};
  while (!open.empty()) {
    const pugi::xml_node node = open.back();
    open.pop_back();
    for (const pugi::xml_node child : node.children()) {
      if (std::strcmp(child.name(), "camera") == 0) found.push_back(child);
      if (std::strcmp(child.name(), "group") == 0) open.push_back(child);
    }
  }
  return found;
}

std::vector<ChunkCamera> ReadCameras(pugi::xml_node chunk,
                                     const Document& document,
                                     CalibratedScene& scene) {
  std::map<std::string, pugi::xml_node> sensors;
  for (const pugi::xml_node sensor : chunk.child("sensors").children("sensor")) {
    sensors.emplace(sensor.attribute("id").value(), sensor);
  }
  std::map<std::string, Camera> calibrated;
  std::vector<ChunkCamera> cameras;
  int not_aligned = 0;
  for (const pugi::xml_node node : CameraNodes(chunk.child("cameras"))) {
    const std::string label = node.attribute("label").value();
    const pugi::xml_node transform = node.child("transform");
    if (!transform) {
      ++not_aligned;
      continue;
    }
    const std::string id = node.attribute("sensor_id").value();
    const auto sensor = sensors.find(id);
    if (sensor == sensors.end()) {
      std::string what = "the sensor \"" + id;
      what += "\" of the camera \"" + label + "\" is not in the file";
      document.Fail(what);
    }
    auto camera = calibrated.find(id);
    if (camera == calibrated.end()) {
      camera = calibrated.emplace(id, ReadSensor(sensor->second, document)).first;
    }
    const std::vector<double> m = document.Numbers(transform, 16);
    ChunkCamera read{label,
                     node.attribute("component_id").value(),
                     QuarterTurns(node, document),
                     camera->second,
                     Eigen::Matrix3d::Zero(),
                     {m[3], m[7], m[11]}};
    read.axes << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    cameras.push_back(read);
  }
  if (not_aligned > 0) {
    scene.notes.push_back(std::to_string(not_aligned) + " of the cameras in " +
                          document.File() + " were not aligned.");
  }
  return cameras;
}

// Components are not placed against each other: only the largest stays.
void KeepLargestComponent(std::vector<ChunkCamera>& cameras,
                          const Document& document,
                          CalibratedScene& scene) {
  std::map<std::string, int> sizes;
  for (const ChunkCamera& camera : cameras) ++sizes[camera.component];
  if (sizes.size() < 2) return;
  const auto largest =
      std::max_element(sizes.begin(), sizes.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  const std::string kept = largest->first;
  scene.notes.push_back(std::to_string(cameras.size() - largest->second) +
                        " of the cameras in " + document.File() +
                        " are of smaller components, and were left out.");
  std::erase_if(cameras, [&](const ChunkCamera& c) { return c.component != kept; });
}

pugi::xml_node TransformOf(pugi::xml_node chunk, const std::string& component) {
  for (const pugi::xml_node node : chunk.child("components").children("component")) {
    if (component == node.attribute("id").value() && node.child("transform")) {
      return node.child("transform");
    }
  }
  return chunk.child("transform");
}

// --- The world -----------------------------------------------------------------------

bool IsGeocentric(pugi::xml_node chunk) {
  const std::string reference = chunk.child("reference").text().get();
  if (reference.find("LOCAL_CS") != std::string::npos) return false;
  return reference.find("GEOGCS") != std::string::npos ||
         reference.find("GEOCCS") != std::string::npos ||
         reference.find("PROJCS") != std::string::npos;
}

// The place of ENU, and its axes as rows.
struct Enu {
  Place place;
  Eigen::Matrix3d enu_from_ecef;
};

// Nothing when the point is nowhere near the ground.
std::optional<Enu> EnuAt(const Eigen::Vector3d& ecef_m) {
  constexpr double kNear_m = 100e3;
  constexpr double kEarth_m = 6.37e6;
  if (!(std::abs(ecef_m.norm() - kEarth_m) < kNear_m)) return std::nullopt;
  Enu enu;
  std::vector<GeographicLib::Math::real> ecef_from_enu(9);
  GeographicLib::Geocentric::WGS84().Reverse(ecef_m.x(),
                                             ecef_m.y(),
                                             ecef_m.z(),
                                             enu.place.latitude_deg,
                                             enu.place.longitude_deg,
                                             enu.place.altitude_m,
                                             ecef_from_enu);
  // Rows first there, columns first here: transposed as wanted
  enu.enu_from_ecef = Eigen::Map<const Eigen::Matrix3d>(ecef_from_enu.data());
  return enu;
}

fs::path FileIn(const fs::path& path) {
  if (!fs::is_directory(path)) return path;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".xml") found.push_back(entry.path());
  }
  if (found.size() == 1) return found[0];
  throw InputError(path.string() + ": has " + std::to_string(found.size()) +
                   " files .xml; give the one with the cameras");
}

}  // namespace

CalibratedScene ReadMetashape(const fs::path& path, const PhotoSizes& photos) {
  const Document document(FileIn(path));
  const pugi::xml_node chunk = document.Chunk();
  CalibratedScene scene;
  std::vector<ChunkCamera> cameras = ReadCameras(chunk, document, scene);
  KeepLargestComponent(cameras, document, scene);
  if (cameras.empty()) FinishScene(scene, document.File());

  // From the chunk to its world
  const pugi::xml_node transform = TransformOf(chunk, cameras.front().component);
  const Similarity world = ReadTransform(transform, document);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (ChunkCamera& camera : cameras) {
    camera.axes = world.rotation * camera.axes;
    camera.position =
        world.scale * (world.rotation * camera.position) + world.translation;
    middle += camera.position / static_cast<double>(cameras.size());
  }

  // From the Earth's middle to the place
  if (transform && IsGeocentric(chunk)) {
    if (const std::optional<Enu> enu = EnuAt(middle)) {
      for (ChunkCamera& camera : cameras) {
        camera.axes = enu->enu_from_ecef * camera.axes;
        camera.position = enu->enu_from_ecef * (camera.position - middle);
      }
      scene.enu_origin = enu->place;
    } else {
      scene.notes.push_back(document.File() +
                            " has a geographic reference, but its cameras are not on "
                            "the Earth: taken as local.");
    }
  }

  for (const ChunkCamera& camera : cameras) {
    NamedCamera named{ViewOfImage(camera.label, photos), camera.camera};
    const auto pose = PoseFromAxes(camera.axes, camera.position);
    if (!pose) {
      document.Fail("the transform of the camera \"" + camera.label +
                    "\" is no rotation and position");
    }
    named.camera.camera_from_world = *pose;
    const auto photo = photos.find(named.view);
    named.camera = Upright(named.camera,
                           camera.quarter_turns,
                           photo != photos.end() ? &photo->second : nullptr);
    scene.cameras.push_back(named);
  }
  FinishScene(scene, document.File());
  return scene;
}

}  // namespace relight
