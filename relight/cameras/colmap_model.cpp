// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/colmap_model.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/text_lines.h"
#include "relight/cameras/view_name.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRemedy =
    "export the model again with \"colmap model_converter --output_type TXT\"";

// What stands at each place of a model's parameters: one focal length or two, then the
// centre, then the lens.
struct Model {
  const char* name;
  int id;  // In binary files.
  LensModel lens;
  int focals;
  std::array<double Lens::*, 8> lens_parameters;
  int lens_count;

  std::size_t Parameters() const { return focals + 2 + lens_count; }
};
constexpr auto kBrown = LensModel::kBrown;
constexpr auto kFisheye = LensModel::kFisheye;
constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", 0, kBrown, 1, {}, 0},
    {"PINHOLE", 1, kBrown, 2, {}, 0},
    {"SIMPLE_RADIAL", 2, kBrown, 1, {&Lens::k1}, 1},
    {"RADIAL", 3, kBrown, 1, {&Lens::k1, &Lens::k2}, 2},
    {"OPENCV", 4, kBrown, 2, {&Lens::k1, &Lens::k2, &Lens::p1, &Lens::p2}, 4},
    {"OPENCV_FISHEYE", 5, kFisheye, 2, {&Lens::k1, &Lens::k2, &Lens::k3, &Lens::k4}, 4},
    {"FULL_OPENCV",
     6,
     kBrown,
     2,
     {&Lens::k1,
      &Lens::k2,
      &Lens::p1,
      &Lens::p2,
      &Lens::k3,
      &Lens::k4,
      &Lens::k5,
      &Lens::k6},
     8},
    {"SIMPLE_RADIAL_FISHEYE", 8, kFisheye, 1, {&Lens::k1}, 1},
    {"RADIAL_FISHEYE", 9, kFisheye, 1, {&Lens::k1, &Lens::k2}, 2}};

[[noreturn]] void RefuseModel(const std::string& where, const std::string& model) {
  throw InputError(where + ": camera model " + model +
                   " is not read; known are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, "
                   "RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE and the two "
                   "RADIAL_FISHEYE; undistort the photos first with \"colmap "
                   "image_undistorter\"");
}

Camera CameraFrom(const Model& model,
                  int width,
                  int height,
                  const std::vector<double>& parameters) {
  Camera camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.focal_px = {parameters[0], parameters[model.focals - 1]};
  camera.center_px = {parameters[model.focals], parameters[model.focals + 1]};
  camera.lens.model = model.lens;
  for (int i = 0; i < model.lens_count; ++i) {
    camera.lens.*model.lens_parameters[i] = parameters[model.focals + 2 + i];
  }
  return camera;
}

// Answers false when the numbers are no pose.
bool SetPose(Camera& camera,
             const Eigen::Quaterniond& rotation,
             const Eigen::Vector3d& translation) {
  if (!(std::abs(rotation.norm() - 1.0) < 1e-2) || !translation.allFinite()) return false;
  camera.camera_from_world.linear() = rotation.normalized().toRotationMatrix();
  camera.camera_from_world.translation() = translation;
  return true;
}

// --- Text ---------------------------------------------------------------------------

// X Y POINT3D_ID of each, or nothing.
bool IsLineOfPoints(const std::string& line) {
  std::istringstream numbers(line);
  int count = 0;
  for (double value = 0; numbers >> value;) ++count;
  return numbers.eof() && count % 3 == 0;
}

std::map<std::uint32_t, Camera> ReadCamerasText(const fs::path& file) {
  TextLines lines(file, kRemedy);
  std::map<std::uint32_t, Camera> cameras;
  std::string line;
  while (lines.Next(line)) {
    std::istringstream words(line);
    std::uint32_t id = 0;
    std::string name;
    int width = 0, height = 0;
    if (!(words >> id >> name >> width >> height)) {
      lines.Fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    }
    std::vector<double> parameters;
    for (double value = 0; words >> value;) parameters.push_back(value);
    if (!words.eof()) lines.Fail("a camera parameter is not a number");
    const auto* model = std::find_if(std::begin(kModels),
                                     std::end(kModels),
                                     [&](const Model& m) { return name == m.name; });
    if (model == std::end(kModels)) RefuseModel(lines.Where(), name);
    if (parameters.size() != model->Parameters()) {
      lines.Fail("camera model " + name + " has " + std::to_string(model->Parameters()) +
                 " parameters, found " + std::to_string(parameters.size()));
    }
    if (!cameras.emplace(id, CameraFrom(*model, width, height, parameters)).second) {
      lines.Fail("camera " + std::to_string(id) + " is there twice");
    }
  }
  return cameras;
}

void ReadImagesText(const fs::path& file,
                    const std::map<std::uint32_t, Camera>& cameras,
                    CalibratedScene& scene) {
  TextLines lines(file, kRemedy);
  std::string line;
  while (lines.Next(line)) {
    std::istringstream words(line);
    std::uint32_t image = 0, camera_id = 0;
    double qw = 0, qx = 0, qy = 0, qz = 0, tx = 0, ty = 0, tz = 0;
    std::string name;
    if (!(words >> image >> qw >> qx >> qy >> qz >> tx >> ty >> tz >> camera_id >>
          std::ws) ||
        !std::getline(words, name)) {
      lines.Fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    }
    RequireInsideCapture(name, lines.Where());
    const auto found = cameras.find(camera_id);
    if (found == cameras.end()) {
      lines.Fail("camera " + std::to_string(camera_id) + " is not in cameras.txt");
    }
    NamedCamera named{ViewNameOf(name), found->second};
    if (!SetPose(named.camera, {qw, qx, qy, qz}, {tx, ty, tz})) {
      lines.Fail("the pose is not a rotation (unit quaternion) and a translation");
    }
    scene.cameras.push_back(named);
    if (lines.Next(line, /*blank_too=*/true) && !IsLineOfPoints(line)) {
      lines.Fail("expected the line of points, perhaps empty, of the image before");
    }
  }
}

void ReadPointsText(const fs::path& file, CalibratedScene& scene) {
  TextLines lines(file, kRemedy);
  std::string line;
  while (lines.Next(line)) {
    std::istringstream words(line);
    double id = 0, x = 0, y = 0, z = 0, r = 0, g = 0, b = 0, error = 0, image = 0,
           index = 0;
    if (!(words >> id >> x >> y >> z >> r >> g >> b >> error)) {
      lines.Fail("expected POINT3D_ID X Y Z R G B ERROR and a track");
    }
    ScenePoint point{{x, y, z}, 0};
    while (words >> image >> index) ++point.views;
    scene.points.push_back(point);
  }
}

// --- Binary -------------------------------------------------------------------------

// Numbers of a little-endian file, one after the other; counts in it are not believed.
class BinaryFile {
 public:
  explicit BinaryFile(const fs::path& file)
      : file_(file), bytes_(ReadText(file, kLimitBytes)) {}

  template <class Value>
  Value Next() {
    Value value{};
    std::memcpy(&value, Take(sizeof value), sizeof value);
    return value;
  }
  void Skip(std::uint64_t count, std::uint64_t bytes_each) {
    if (count > (bytes_.size() - at_) / bytes_each) Fail("is cut off");
    at_ += count * bytes_each;
  }
  std::string Name() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) Fail("is cut off");
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }
  std::string Where() const {
    return file_.string() + ": at byte " + std::to_string(at_);
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(Where() + ": " + what + "; " + kRemedy);
  }

 private:
  static constexpr std::size_t kLimitBytes = 2'000'000'000;

  const char* Take(std::size_t count) {
    if (bytes_.size() - at_ < count) Fail("is cut off");
    const char* taken = bytes_.data() + at_;
    at_ += count;
    return taken;
  }

  fs::path file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

std::map<std::uint32_t, Camera> ReadCamerasBinary(const fs::path& path) {
  BinaryFile file(path);
  std::map<std::uint32_t, Camera> cameras;
  for (auto left = file.Next<std::uint64_t>(); left > 0; --left) {
    const auto id = file.Next<std::uint32_t>();
    const auto model_id = file.Next<std::int32_t>();
    const auto width = file.Next<std::uint64_t>(), height = file.Next<std::uint64_t>();
    const auto* model = std::find_if(std::begin(kModels),
                                     std::end(kModels),
                                     [&](const Model& m) { return model_id == m.id; });
    if (model == std::end(kModels)) RefuseModel(file.Where(), std::to_string(model_id));
    std::vector<double> parameters(model->Parameters());
    for (double& parameter : parameters) parameter = file.Next<double>();
    constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
    if (width > kMost || height > kMost) file.Fail("a size that no photo has");
    if (!cameras
             .emplace(id,
                      CameraFrom(*model,
                                 static_cast<int>(width),
                                 static_cast<int>(height),
                                 parameters))
             .second) {
      file.Fail("camera " + std::to_string(id) + " is there twice");
    }
  }
  return cameras;
}

void ReadImagesBinary(const fs::path& path,
                      const std::map<std::uint32_t, Camera>& cameras,
                      CalibratedScene& scene) {
  BinaryFile file(path);
  for (auto left = file.Next<std::uint64_t>(); left > 0; --left) {
    file.Next<std::uint32_t>();  // IMAGE_ID
    std::array<double, 7> pose{};
    for (double& number : pose) number = file.Next<double>();
    const auto camera_id = file.Next<std::uint32_t>();
    const std::string name = file.Name();
    RequireInsideCapture(name, file.Where());
    const auto found = cameras.find(camera_id);
    if (found == cameras.end()) {
      file.Fail("camera " + std::to_string(camera_id) + " is not in cameras.bin");
    }
    NamedCamera named{ViewNameOf(name), found->second};
    if (!SetPose(named.camera,
                 {pose[0], pose[1], pose[2], pose[3]},
                 {pose[4], pose[5], pose[6]})) {
      file.Fail("the pose is not a rotation (unit quaternion) and a translation");
    }
    scene.cameras.push_back(named);
    constexpr std::uint64_t kBytesPerPoint = 2 * sizeof(double) + sizeof(std::uint64_t);
    file.Skip(file.Next<std::uint64_t>(), kBytesPerPoint);
  }
}

void ReadPointsBinary(const fs::path& path, CalibratedScene& scene) {
  BinaryFile file(path);
  for (auto left = file.Next<std::uint64_t>(); left > 0; --left) {
    file.Next<std::uint64_t>();  // POINT3D_ID
    ScenePoint point;
    for (int axis = 0; axis < 3; ++axis) point.position[axis] = file.Next<double>();
    file.Skip(1, 3 + sizeof(double));  // Colour and error
    const auto track = file.Next<std::uint64_t>();
    file.Skip(track, 2 * sizeof(std::uint32_t));
    point.views = static_cast<int>(std::min<std::uint64_t>(track, 1'000'000));
    scene.points.push_back(point);
  }
}

const char* WrittenModel(const Lens& lens) {
  if (lens.model == LensModel::kFisheye) return "OPENCV_FISHEYE";
  if (lens.IsPinhole()) return "PINHOLE";
  const bool full = lens.k3 != 0 || lens.k4 != 0 || lens.k5 != 0 || lens.k6 != 0;
  return full ? "FULL_OPENCV" : "OPENCV";
}

}  // namespace

CalibratedScene ReadColmap(const fs::path& folder) {
  const auto has = [&](const char* name) { return fs::is_regular_file(folder / name); };
  CalibratedScene scene;
  if (has("cameras.txt") && has("images.txt")) {
    ReadImagesText(folder / "images.txt", ReadCamerasText(folder / "cameras.txt"), scene);
    if (has("points3D.txt")) ReadPointsText(folder / "points3D.txt", scene);
    FinishScene(scene, (folder / "images.txt").string());
    return scene;
  }
  if (has("cameras.bin") && has("images.bin")) {
    ReadImagesBinary(
        folder / "images.bin", ReadCamerasBinary(folder / "cameras.bin"), scene);
    if (has("points3D.bin")) ReadPointsBinary(folder / "points3D.bin", scene);
    FinishScene(scene, (folder / "images.bin").string());
    return scene;
  }
  const char* missing = has("cameras.txt")   ? "images.txt"
                        : has("images.txt")  ? "cameras.txt"
                        : has("cameras.bin") ? "images.bin"
                                             : "cameras.txt";
  throw InputError((folder / missing).string() +
                   ": not there; give the folder of a COLMAP model (cameras.txt and "
                   "images.txt, or cameras.bin and images.bin)");
}

void WriteColmap(const fs::path& folder, const CalibratedScene& scene) {
  std::ostringstream camera_text, image_text, point_text;
  camera_text << std::setprecision(17)
              << "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS; world = ENU metres\n";
  image_text << std::setprecision(17)
             << "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points\n";
  point_text << std::setprecision(9)
             << "# POINT3D_ID X Y Z R G B ERROR, tracks are not kept\n";
  int id = 0;
  for (const auto& [view, camera] : scene.cameras) {
    ++id;
    const std::string name = WrittenModel(camera.lens);
    const auto* model = std::find_if(std::begin(kModels),
                                     std::end(kModels),
                                     [&](const Model& m) { return name == m.name; });
    camera_text << id << ' ' << name << ' ' << camera.width_px << ' ' << camera.height_px
                << ' ' << camera.focal_px.x() << ' ' << camera.focal_px.y() << ' '
                << camera.center_px.x() << ' ' << camera.center_px.y();
    for (int i = 0; i < model->lens_count; ++i) {
      camera_text << ' ' << camera.lens.*model->lens_parameters[i];
    }
    camera_text << '\n';
    const Eigen::Quaterniond q(camera.camera_from_world.linear());
    const Eigen::Vector3d t = camera.camera_from_world.translation();
    image_text << id << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z()
               << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << id << ' ' << view
               << "\n\n";
  }
  id = 0;
  for (const ScenePoint& point : scene.points) {
    point_text << ++id << ' ' << point.position.x() << ' ' << point.position.y() << ' '
               << point.position.z() << " 128 128 128 0\n";
  }
  std::error_code error;
  fs::create_directories(folder, error);
  WriteTextWhole(folder / "cameras.txt", camera_text.str());
  WriteTextWhole(folder / "images.txt", image_text.str());
  WriteTextWhole(folder / "points3D.txt", point_text.str());
}

}  // namespace relight
