// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/colmap_text.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/view_name.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

// One file, read line by line, that knows where it is.
class Lines {
 public:
  explicit Lines(const fs::path& file) : file_(file), text_(ReadText(file)) {}

  // The next line that is no comment; blank lines count only when asked for.
  bool Next(std::string& line, bool blank_too = false) {
    while (std::getline(text_, line)) {
      ++number_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const std::size_t first = line.find_first_not_of(" \t");
      if (first == std::string::npos && !blank_too) continue;
      if (first != std::string::npos && line[first] == '#') continue;
      return true;
    }
    return false;
  }
  std::string Where() const { return file_.string() + ":" + std::to_string(number_); }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(
        Where() + ": " + what +
        "; export the model again with \"colmap model_converter --output_type TXT\"");
  }

 private:
  fs::path file_;
  std::istringstream text_;
  int number_ = 0;
};

struct Model {
  const char* name;
  std::size_t parameters;
};
constexpr Model kModels[] = {{"SIMPLE_PINHOLE", 3},
                             {"PINHOLE", 4},
                             {"SIMPLE_RADIAL", 4},
                             {"RADIAL", 5},
                             {"OPENCV", 8}};

Camera CameraFrom(const std::string& model,
                  int width,
                  int height,
                  const std::vector<double>& p,
                  const Lines& lines) {
  const auto* known = std::find_if(std::begin(kModels),
                                   std::end(kModels),
                                   [&](const Model& m) { return model == m.name; });
  if (known == std::end(kModels)) {
    throw InputError(
        lines.Where() + ": camera model " + model +
        " is not read; known are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and "
        "OPENCV; undistort the photos first with \"colmap image_undistorter\"");
  }
  if (p.size() != known->parameters) {
    lines.Fail("camera model " + model + " has " + std::to_string(known->parameters) +
               " parameters, found " + std::to_string(p.size()));
  }
  const bool one_focal = model != "PINHOLE" && model != "OPENCV";
  const std::size_t center = one_focal ? 1 : 2;
  Camera camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.focal_px = {p[0], one_focal ? p[0] : p[1]};
  camera.center_px = {p[center], p[center + 1]};
  const std::size_t lens = center + 2;
  if (p.size() > lens) camera.lens.k1 = p[lens];
  if (p.size() > lens + 1) camera.lens.k2 = p[lens + 1];
  if (p.size() > lens + 3) {
    camera.lens.p1 = p[lens + 2];
    camera.lens.p2 = p[lens + 3];
  }
  const bool finite =
      std::all_of(p.begin(), p.end(), [](double v) { return std::isfinite(v); });
  if (!finite || camera.focal_px.minCoeff() <= 0 || width <= 0 || height <= 0) {
    lines.Fail("sizes and focal lengths must be positive");
  }
  return camera;
}

// X Y POINT3D_ID of each, or nothing.
bool IsLineOfPoints(const std::string& line) {
  std::istringstream numbers(line);
  int count = 0;
  for (double value = 0; numbers >> value;) ++count;
  return numbers.eof() && count % 3 == 0;
}

std::map<long, Camera> ReadCameras(const fs::path& file) {
  Lines lines(file);
  std::map<long, Camera> cameras;
  std::string line;
  while (lines.Next(line)) {
    std::istringstream words(line);
    long id = 0;
    std::string model;
    int width = 0, height = 0;
    if (!(words >> id >> model >> width >> height)) {
      lines.Fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    }
    std::vector<double> parameters;
    for (double value = 0; words >> value;) parameters.push_back(value);
    if (!words.eof()) lines.Fail("a camera parameter is not a number");
    if (!cameras.emplace(id, CameraFrom(model, width, height, parameters, lines))
             .second) {
      lines.Fail("camera " + std::to_string(id) + " is there twice");
    }
  }
  return cameras;
}

}  // namespace

std::vector<NamedCamera> ReadColmapText(const fs::path& folder) {
  for (const char* name : {"cameras.txt", "images.txt"}) {
    if (!fs::exists(folder / name)) {
      throw InputError(
          (folder / name).string() +
          ": not there; give the folder of a COLMAP text model (cameras.txt and "
          "images.txt; \"colmap model_converter --output_type TXT\" writes it)");
    }
  }
  const std::map<long, Camera> cameras = ReadCameras(folder / "cameras.txt");

  Lines lines(folder / "images.txt");
  std::vector<NamedCamera> result;
  std::string line;
  while (lines.Next(line)) {
    std::istringstream words(line);
    long image = 0, camera_id = 0;
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
    const Eigen::Quaterniond rotation(qw, qx, qy, qz);
    const Eigen::Vector3d translation(tx, ty, tz);
    if (!(std::abs(rotation.norm() - 1.0) < 1e-2) || !translation.allFinite()) {
      lines.Fail("the pose is not a rotation (unit quaternion) and a translation");
    }
    NamedCamera named{ViewNameOf(name), found->second};
    named.camera.camera_from_world.linear() = rotation.normalized().toRotationMatrix();
    named.camera.camera_from_world.translation() = translation;
    if (std::any_of(result.begin(), result.end(), [&](const NamedCamera& other) {
          return other.view == named.view;
        })) {
      throw InputError(
          lines.Where() + ": a second image of the name " + named.view +
          " (extensions and folders do not count); rename one of the photos");
    }
    result.push_back(named);
    if (lines.Next(line, /*blank_too=*/true) && !IsLineOfPoints(line)) {
      lines.Fail("expected the line of points, perhaps empty, of the image before");
    }
  }
  if (result.empty()) {
    throw InputError((folder / "images.txt").string() +
                     ": no image in it; no photo was registered in this model");
  }
  std::sort(result.begin(), result.end(), [](const NamedCamera& a, const NamedCamera& b) {
    return a.view < b.view;
  });
  return result;
}

void WriteColmapText(const fs::path& folder, const std::vector<NamedCamera>& cameras) {
  std::ostringstream camera_text, image_text;
  camera_text << std::setprecision(17)
              << "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS; world = ENU metres\n";
  image_text << std::setprecision(17)
             << "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points\n";
  int id = 0;
  for (const auto& [view, camera] : cameras) {
    ++id;
    camera_text << id << (camera.lens.IsPinhole() ? " PINHOLE " : " OPENCV ")
                << camera.width_px << ' ' << camera.height_px << ' '
                << camera.focal_px.x() << ' ' << camera.focal_px.y() << ' '
                << camera.center_px.x() << ' ' << camera.center_px.y();
    if (!camera.lens.IsPinhole()) {
      camera_text << ' ' << camera.lens.k1 << ' ' << camera.lens.k2 << ' '
                  << camera.lens.p1 << ' ' << camera.lens.p2;
    }
    camera_text << '\n';
    const Eigen::Quaterniond q(camera.camera_from_world.linear());
    const Eigen::Vector3d t = camera.camera_from_world.translation();
    image_text << id << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z()
               << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << id << ' ' << view
               << "\n\n";
  }
  std::error_code error;
  fs::create_directories(folder, error);
  WriteTextWhole(folder / "cameras.txt", camera_text.str());
  WriteTextWhole(folder / "images.txt", image_text.str());
  WriteTextWhole(folder / "points3D.txt", "# 3D point list: empty\n");
}

}  // namespace relight
