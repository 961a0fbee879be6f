// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/bundler_file.h"

#include "relight/base/error.h"
#include "relight/cameras/number_text.h"
#include "relight/cameras/text_lines.h"

#include <algorithm>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRemedy = "export the cameras again as Bundler .out, version 0.3";

fs::path FileIn(const fs::path& path) {
  if (!fs::is_directory(path)) return path;
  if (fs::is_regular_file(path / "bundle.out")) return path / "bundle.out";
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".out") found.push_back(entry.path());
  }
  if (found.size() == 1) return found[0];
  throw InputError(path.string() + ": has " + std::to_string(found.size()) +
                   " files .out and no bundle.out; give the file");
}

fs::path ListFor(const fs::path& file) {
  const fs::path folder = file.parent_path();
  fs::path base = file.filename();
  const std::string whole = base.string();
  base.replace_extension();  // COLMAP: model.bundle.out goes with model.list.txt
  const std::string stem = base.string(), first = base.stem().string();
  for (const fs::path& list : {folder / (stem + ".list.txt"),
                               folder / (first + ".list.txt"),
                               folder / (whole + ".list.txt"),
                               folder / "list.txt",
                               folder / ".." / "list.txt"}) {
    if (fs::is_regular_file(list)) return list;
  }
  throw InputError(file.string() + ": the photos' names are not known: " +
                   (folder / "list.txt").string() +
                   " is missing; put the list of photos there, one name a line, in the "
                   "order of the cameras");
}

// Without the flag and the focal length that may follow.
std::string NameIn(const std::string& line) {
  std::string_view rest = Trimmed(line);
  std::string_view name = rest;
  for (int word = 0; word < 2; ++word) {
    const std::size_t blank = rest.find_last_of(kBlanks);
    if (blank == std::string_view::npos || !NumberFrom(rest.substr(blank))) {
      return std::string(name);
    }
    rest = Trimmed(rest.substr(0, blank));
  }
  name = rest;
  return std::string(name);
}

std::vector<std::string> ReadList(const fs::path& file) {
  TextLines lines(file, kRemedy);
  std::vector<std::string> names;
  for (std::string line; lines.Next(line);) names.push_back(NameIn(line));
  return names;
}

class BundleLines {
 public:
  explicit BundleLines(const fs::path& file) : lines_(file, kRemedy) {}

  Eigen::Vector3d Three(const char* what) {
    const std::vector<double> numbers = Numbers(what);
    if (numbers.size() != 3) lines_.Fail(std::string("expected ") + what);
    return {numbers[0], numbers[1], numbers[2]};
  }
  std::vector<double> Numbers(const char* what) {
    std::string line;
    if (!lines_.Next(line)) lines_.Fail(std::string("is cut off before ") + what);
    const auto numbers = NumbersFrom(line);
    if (!numbers) lines_.Fail(std::string("expected ") + what);
    return *numbers;
  }
  [[noreturn]] void Fail(const std::string& what) const { lines_.Fail(what); }

 private:
  TextLines lines_;
};

bool IsVersion3(const fs::path& file) {
  const std::string text = ReadText(file);
  return text.starts_with("# Bundle file v0.3");
}

}  // namespace

CalibratedScene ReadBundler(const fs::path& path,
                            const PhotoSizes& photos,
                            UnknownPhotos unknown) {
  const fs::path file = FileIn(path);
  if (!IsVersion3(file)) {
    throw InputError(file.string() + ":1: expected \"# Bundle file v0.3\"; " + kRemedy);
  }
  const fs::path list = ListFor(file);
  const std::vector<std::string> names = ReadList(list);
  BundleLines lines(file);
  const std::vector<double> counts =
      lines.Numbers("the numbers of cameras and of points");
  if (counts.size() != 2) lines.Fail("expected the numbers of cameras and of points");
  if (counts[0] != static_cast<double>(names.size())) {
    lines.Fail("as many cameras as " + list.string() + " has names, " +
               std::to_string(names.size()) + ", were expected");
  }

  CalibratedScene scene;
  int unregistered = 0;
  for (const std::string& name : names) {
    const Eigen::Vector3d lens = lines.Three("f, k1 and k2 of a camera");
    Eigen::Matrix3d rotation;
    for (int row = 0; row < 3; ++row) {
      rotation.row(row) = lines.Three("a row of a camera's rotation").transpose();
    }
    const Eigen::Vector3d translation = lines.Three("a camera's translation");
    if (lens[0] == 0) {
      ++unregistered;
      continue;
    }
    NamedCamera named{ViewOfImage(name, photos), {}};
    const auto size = SizeOfView(named.view, photos, unknown, file.string());
    if (!size) continue;
    const Eigen::Vector3d position = -(rotation.transpose() * translation);
    rotation.bottomRows<2>() *= -1;  // y up and -z forward to y down and z forward
    const auto pose = PoseFromAxes(rotation.transpose(), position);
    if (!pose) lines.Fail("the pose of " + name + " is no rotation and translation");
    named.camera.camera_from_world = *pose;
    named.camera.width_px = size->width_px;
    named.camera.height_px = size->height_px;
    named.camera.focal_px = {lens[0], lens[0]};
    named.camera.center_px = {size->width_px / 2.0, size->height_px / 2.0};
    named.camera.lens.k1 = lens[1];
    named.camera.lens.k2 = lens[2];
    scene.cameras.push_back(named);
  }
  if (unregistered > 0) {
    scene.notes.push_back(std::to_string(unregistered) +
                          " of the photos were not registered by the program that made " +
                          file.string() + ".");
  }

  for (double left = counts[1]; left >= 1; --left) {
    ScenePoint point{lines.Three("a point"), 0};
    lines.Three("a point's colour");
    const std::vector<double> track = lines.Numbers("the views that see a point");
    if (track.empty() || track.size() != 1 + 4 * track[0]) {
      lines.Fail("expected N and camera, key, x and y of N views");
    }
    point.views = static_cast<int>(track.size() / 4);
    if (point.views > 0) scene.points.push_back(point);
  }
  FinishScene(scene, file.string());
  return scene;
}

}  // namespace relight
