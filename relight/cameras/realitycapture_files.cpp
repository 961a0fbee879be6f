// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/realitycapture_files.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/number_text.h"
#include "relight/cameras/view_name.h"

#include <pugixml.hpp>

#include <algorithm>
#include <map>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLimitBytes = 500'000'000;
constexpr double kFilm_mm = 36;
constexpr const char* kRemedy =
    "export again: Alignment > Registration, Internal/External camera parameters, or "
    "Alignment > Metadata (XMP)";
constexpr const char* kOtherLens =
    "; choose the distortion model Brown3 or Brown4 in the alignment settings, align and "
    "export again, or export undistorted photos";

// What both kinds of files hold.
struct FilmCamera {
  double focal_mm = 0, aspect = 1;
  Eigen::Vector2d center = {0, 0};        // Of the longer side, from the middle.
  std::array<double, 4> radial = {};      // k1 to k4.
  std::array<double, 2> tangential = {};  // t1, t2.
};

Camera CameraOf(const FilmCamera& film, PhotoSize size, const std::string& where) {
  Camera camera;
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  const double longer_px = std::max(size.width_px, size.height_px);
  const double focal_px = film.focal_mm / kFilm_mm * longer_px;
  camera.focal_px = {focal_px, focal_px * film.aspect};
  camera.center_px =
      Eigen::Vector2d(size.width_px, size.height_px) / 2 + longer_px * film.center;
  if (!(camera.focal_px.minCoeff() > 0)) {
    throw InputError(where + ": the focal length is not above 0; " + kRemedy);
  }
  camera.lens.p1 = film.tangential[1];
  camera.lens.p2 = film.tangential[0];
  if (!SetRadialPolynomial(camera, film.radial)) {
    throw InputError(where + ": a k4 of " + std::to_string(film.radial[3]) +
                     " is too strong to be read" + kOtherLens);
  }
  return camera;
}

void NoteTangential(CalibratedScene& scene, const std::string& file) {
  const auto has = [](const NamedCamera& named) {
    return named.camera.lens.p1 != 0 || named.camera.lens.p2 != 0;
  };
  if (std::any_of(scene.cameras.begin(), scene.cameras.end(), has)) {
    scene.notes.push_back(file +
                          " has tangential distortion (t1, t2), whose order its makers "
                          "do not say: t1 was taken to go with r^2 + 2 x^2.");
  }
}

// --- The table -----------------------------------------------------------------------

std::vector<std::string_view> Cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// The lines of the file that hold something, numbered.
std::vector<std::pair<int, std::string_view>> LinesOf(std::string_view text) {
  std::vector<std::pair<int, std::string_view>> lines;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trimmed(text.substr(0, end));
    if (!line.empty()) lines.emplace_back(number, line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

class Table {
 public:
  explicit Table(const fs::path& file)
      : file_(file.string()), text_(ReadText(file, kLimitBytes)), lines_(LinesOf(text_)) {
    // "#cameras 12" may come before
    while (next_ < lines_.size()) {
      std::string_view header = lines_[next_++].second;
      if (header.starts_with('#')) header.remove_prefix(1);
      const std::vector<std::string_view> names = Cells(header);
      if (names[0] != "name") continue;
      width_ = names.size();  // A name may be there twice: the first counts
      for (std::size_t i = 0; i < names.size(); ++i) columns_.emplace(names[i], i);
      break;
    }
    for (const char* name : {"name", "x", "y", "alt", "heading", "pitch", "roll", "f"}) {
      if (columns_.contains(name)) continue;
      throw InputError(file_ + ": has no column \"" + name + "\" under #name,…; " +
                       kRemedy);
    }
  }
  bool NextRow() {
    if (next_ >= lines_.size()) return false;
    cells_ = Cells(lines_[next_++].second);
    if (cells_.size() != width_) {
      throw InputError(Where() + ": has " + std::to_string(cells_.size()) +
                       " columns, not " + std::to_string(width_) + " as the heading; " +
                       kRemedy);
    }
    return true;
  }
  std::string Name() const { return std::string(cells_[columns_.at("name")]); }
  // 0 for a column that is not there.
  double Number(const char* name) const {
    const auto column = columns_.find(name);
    if (column == columns_.end()) return 0;
    const auto number = NumberFrom(cells_[column->second]);
    if (!number) {
      throw InputError(Where() + ": " + name + " is no number; " + kRemedy);
    }
    return *number;
  }
  std::string Where() const {
    return file_ + ":" + std::to_string(lines_[next_ - 1].first);
  }

 private:
  std::string file_;
  std::string text_;
  std::vector<std::pair<int, std::string_view>> lines_;
  std::map<std::string, std::size_t, std::less<>> columns_;
  std::vector<std::string_view> cells_;
  std::size_t width_ = 0;
  std::size_t next_ = 0;
};

Eigen::Matrix3d Axes(double heading_deg, double pitch_deg, double roll_deg) {
  const auto turn = [](double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(RadFromDeg(angle_deg), axis).toRotationMatrix();
  };
  Eigen::Matrix3d axes = turn(-heading_deg, Eigen::Vector3d::UnitZ()) *
                         turn(pitch_deg, Eigen::Vector3d::UnitX()) *
                         turn(roll_deg, Eigen::Vector3d::UnitY());
  axes.rightCols<2>() *= -1;  // y up and z backwards to y down and z forward
  return axes;
}

CalibratedScene ReadTable(const fs::path& file,
                          const PhotoSizes& photos,
                          UnknownPhotos unknown) {
  CalibratedScene scene;
  Table table(file);
  while (table.NextRow()) {
    NamedCamera named{ViewOfImage(table.Name(), photos), {}};
    const auto size = SizeOfView(named.view, photos, unknown, table.Where());
    if (!size) continue;
    FilmCamera film;
    film.focal_mm = table.Number("f");
    film.center = {table.Number("px"), table.Number("py")};
    film.radial = {
        table.Number("k1"), table.Number("k2"), table.Number("k3"), table.Number("k4")};
    film.tangential = {table.Number("t1"), table.Number("t2")};
    named.camera = CameraOf(film, *size, table.Where());
    const auto pose = PoseFromAxes(
        Axes(table.Number("heading"), table.Number("pitch"), table.Number("roll")),
        {table.Number("x"), table.Number("y"), table.Number("alt")});
    if (!pose) throw InputError(table.Where() + ": is no pose; " + kRemedy);
    named.camera.camera_from_world = *pose;
    scene.cameras.push_back(named);
  }
  NoteTangential(scene, file.string());
  FinishScene(scene, file.string());
  return scene;
}

// --- XMP -----------------------------------------------------------------------------

// The fields of RealityCapture's namespace, whatever its prefix is, by their bare names.
std::map<std::string, std::string, std::less<>> FieldsOf(const fs::path& file) {
  const std::string text = ReadText(file, kLimitBytes);
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) {
    throw InputError(file.string() + ": is no XML, or is cut off (" +
                     result.description() + "); " + kRemedy);
  }
  const auto bare = [](std::string_view name) {
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
  };
  std::map<std::string, std::string, std::less<>> fields;
  for (const pugi::xml_node top : document.children()) {
    for (const pugi::xml_node rdf : top.children()) {
      for (const pugi::xml_node description : rdf.children()) {
        if (bare(description.name()) != "Description") continue;
        for (const pugi::xml_attribute attribute : description.attributes()) {
          fields.emplace(bare(attribute.name()), attribute.value());
        }
        for (const pugi::xml_node child : description.children()) {
          fields.emplace(bare(child.name()), child.text().get());
        }
      }
    }
  }
  return fields;
}

class Sidecar {
 public:
  explicit Sidecar(const fs::path& file)
      : file_(file.string()), fields_(FieldsOf(file)) {}

  bool HasPose() const {
    return fields_.contains("Rotation") && fields_.contains("Position");
  }
  std::vector<double> Numbers(const char* name, std::size_t count) const {
    const auto field = fields_.find(name);
    const auto numbers =
        field == fields_.end() ? std::nullopt : NumbersFrom(field->second);
    if (!numbers || numbers->size() != count) {
      throw InputError(file_ + ": xcr:" + name + " does not have " +
                       std::to_string(count) + " numbers; " + kRemedy);
    }
    return *numbers;
  }
  double NumberOr(const char* name, double otherwise) const {
    return fields_.contains(name) ? Numbers(name, 1)[0] : otherwise;
  }
  std::string Text(const char* name) const {
    const auto field = fields_.find(name);
    return field == fields_.end() ? "" : std::string(Trimmed(field->second));
  }
  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(file_ + ": " + what + kOtherLens);
  }
  const std::string& File() const { return file_; }

 private:
  std::string file_;
  std::map<std::string, std::string, std::less<>> fields_;
};

FilmCamera FilmOf(const Sidecar& sidecar) {
  FilmCamera film;
  film.focal_mm = sidecar.Numbers("FocalLength35mm", 1)[0];
  film.aspect = sidecar.NumberOr("AspectRatio", 1);
  film.center = {sidecar.NumberOr("PrincipalPointU", 0),
                 sidecar.NumberOr("PrincipalPointV", 0)};
  std::vector<double> distortion(6, 0);
  const std::string words = sidecar.Text("DistortionCoeficients");
  if (!words.empty()) {
    const auto numbers = NumbersFrom(words);
    // Three in old files
    if (!numbers || (numbers->size() != 6 && numbers->size() != 3)) {
      sidecar.Numbers("DistortionCoeficients", 6);
    }
    std::copy(numbers->begin(), numbers->end(), distortion.begin());
  }
  const bool straight = std::all_of(
      distortion.begin(), distortion.end(), [](double number) { return number == 0; });
  const std::string model = sidecar.Text("DistortionModel");
  const bool brown = model == "brown3" || model == "brown4" || model == "brown3t2" ||
                     model == "brown4t2";
  if (!brown && !straight) {
    sidecar.Refuse("the distortion model \"" + model +
                   "\" is not read; known are brown3, brown4, brown3t2 and brown4t2");
  }
  std::copy_n(distortion.begin(), 4, film.radial.begin());
  std::copy_n(distortion.begin() + 4, 2, film.tangential.begin());
  return film;
}

// Answers false when the photo's size is not known and such cameras are left out.
bool AddSidecar(const Sidecar& sidecar,
                const PhotoSizes& photos,
                UnknownPhotos unknown,
                CalibratedScene& scene) {
  NamedCamera named{ViewNameOf(sidecar.File()), {}};
  const auto size = SizeOfView(named.view, photos, unknown, sidecar.File());
  if (!size) return false;
  named.camera = CameraOf(FilmOf(sidecar), *size, sidecar.File());

  const double skew = sidecar.NumberOr("Skew", 0);
  const double skew_px = std::abs(skew) * std::max(size->width_px, size->height_px) *
                         CornerRadius(named.camera);
  if (!(skew_px < kIgnoredShift_px)) {
    sidecar.Refuse("a skew of " + std::to_string(skew) + " is not read");
  }
  const std::vector<double> m = sidecar.Numbers("Rotation", 9);
  const std::vector<double> position = sidecar.Numbers("Position", 3);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(m.data());
  const auto pose = PoseFromAxes(rotation.transpose(),
                                 Eigen::Map<const Eigen::Vector3d>(position.data()));
  if (!pose) {
    throw InputError(sidecar.File() + ": xcr:Rotation is no rotation; " + kRemedy);
  }
  named.camera.camera_from_world = *pose;
  scene.cameras.push_back(named);
  return true;
}

CalibratedScene ReadSidecars(const std::vector<fs::path>& files,
                             const std::string& folder,
                             const PhotoSizes& photos,
                             UnknownPhotos unknown) {
  CalibratedScene scene;
  std::vector<std::string> without_pose;
  for (const fs::path& file : files) {
    const Sidecar sidecar(file);
    if (!sidecar.HasPose()) {
      without_pose.push_back(file.filename().string());
    } else {
      AddSidecar(sidecar, photos, unknown, scene);
    }
  }
  if (!without_pose.empty()) {
    scene.notes.push_back(std::to_string(without_pose.size()) + " of the XMP files in " +
                          folder + " have no pose of RealityCapture, the first is " +
                          without_pose[0] + ".");
  }
  NoteTangential(scene, folder);
  FinishScene(scene, folder);
  return scene;
}

std::vector<fs::path> FilesIn(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

CalibratedScene ReadRealityCapture(const fs::path& path,
                                   const PhotoSizes& photos,
                                   UnknownPhotos unknown) {
  if (fs::is_directory(path)) {
    const std::vector<fs::path> sidecars = FilesIn(path, ".xmp");
    if (!sidecars.empty()) return ReadSidecars(sidecars, path.string(), photos, unknown);
    const std::vector<fs::path> tables = FilesIn(path, ".csv");
    if (tables.size() == 1) return ReadTable(tables[0], photos, unknown);
    throw InputError(path.string() + ": has no files .xmp and " +
                     std::to_string(tables.size()) +
                     " files .csv; give the one with the cameras");
  }
  if (path.extension() == ".xmp") {
    return ReadSidecars({path}, path.string(), photos, unknown);
  }
  return ReadTable(path, photos, unknown);
}

}  // namespace relight
