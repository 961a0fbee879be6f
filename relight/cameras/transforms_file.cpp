// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/transforms_file.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/number_text.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace relight {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLimitBytes = 500'000'000;
constexpr const char* kRemedy =
    "write the file again, with \"ns-process-data\" or \"colmap2nerf.py\"";

fs::path FileIn(const fs::path& path) {
  if (!fs::is_directory(path)) return path;
  for (const char* name : {"transforms.json", "transforms_train.json"}) {
    if (fs::is_regular_file(path / name)) return path / name;
  }
  throw InputError(path.string() + ": no transforms.json in this folder; give the file");
}

Json Parsed(const fs::path& file) {
  const std::string text = ReadText(file, kLimitBytes);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::size_t at = std::min<std::size_t>(error.byte, text.size());
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
    const auto line = 1 + std::count(text.begin(), end, '\n');
    throw InputError(file.string() + ":" + std::to_string(line) +
                     ": is no JSON from here on, or is cut off; " + kRemedy);
  } catch (const Json::exception&) {  // Of what is JSON: 1e999
    throw InputError(file.string() + ": has a number that is too large; " + kRemedy);
  }
}

// A frame's fields over those of the file.
class Fields {
 public:
  Fields(const Json& frame, const Json& top, std::string where)
      : frame_(frame), top_(top), where_(std::move(where)) {}

  const Json* Find(const char* name) const {
    for (const Json* object : {&frame_, &top_}) {
      const auto found = object->find(name);
      if (found != object->end() && !found->is_null()) return &*found;
    }
    return nullptr;
  }
  std::optional<double> Number(const char* name) const {
    const Json* found = Find(name);
    if (found == nullptr) return std::nullopt;
    // Some converters write numbers as text
    const auto number = found->is_number() ? std::optional(found->get<double>())
                        : found->is_string()
                            ? NumberFrom(found->get_ref<const std::string&>())
                            : std::nullopt;
    if (!number || !std::isfinite(*number)) Fail(std::string(name) + " is no number");
    return number;
  }
  double NumberOr(const char* name, double otherwise) const {
    return Number(name).value_or(otherwise);
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(where_ + ": " + what + "; " + kRemedy);
  }
  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(where_ + ": " + what +
                     "; undistort the photos first, or export OPENCV cameras");
  }

 private:
  const Json& frame_;
  const Json& top_;
  std::string where_;
};

std::optional<double> FocalFrom(const Fields& fields,
                                const char* pixels,
                                const char* degrees,
                                const char* radians,
                                int size_px) {
  if (const auto focal_px = fields.Number(pixels)) return focal_px;
  auto angle_rad = fields.Number(radians);
  if (const auto angle_deg = fields.Number(degrees)) angle_rad = RadFromDeg(*angle_deg);
  if (!angle_rad) return std::nullopt;
  return size_px / 2.0 / std::tan(*angle_rad / 2);
}

bool IsFisheye(const Fields& fields) {
  for (const char* other : {"ftheta_p0", "latlong", "transform_matrix_start"}) {
    if (fields.Find(other) != nullptr) {
      fields.Refuse(std::string("a camera with ") + other + " is not read");
    }
  }
  if (const Json* model = fields.Find("camera_model")) {
    for (const char* known : {"OPENCV",
                              "PINHOLE",
                              "SIMPLE_PINHOLE",
                              "SIMPLE_RADIAL",
                              "RADIAL",
                              "perspective"}) {
      if (*model == known) return false;
    }
    if (*model == "OPENCV_FISHEYE" || *model == "fisheye") return true;
    fields.Refuse("camera_model " +
                  model->dump(-1, ' ', true, Json::error_handler_t::replace) +
                  " is not read; known are OPENCV, OPENCV_FISHEYE and PINHOLE");
  }
  const Json* fisheye = fields.Find("is_fisheye");
  if (fisheye == nullptr || *fisheye == false) return false;
  // instant-ngp takes it for a fisheye only when a coefficient says so
  for (const char* k : {"k1", "k2", "k3", "k4"}) {
    if (fields.NumberOr(k, 0) != 0) return true;
  }
  return false;
}

void SetLens(Camera& camera, const Fields& fields) {
  const std::array<double, 4> k = {fields.NumberOr("k1", 0),
                                   fields.NumberOr("k2", 0),
                                   fields.NumberOr("k3", 0),
                                   fields.NumberOr("k4", 0)};
  if (IsFisheye(fields)) {
    camera.lens = {
        .k1 = k[0], .k2 = k[1], .k3 = k[2], .k4 = k[3], .model = LensModel::kFisheye};
    return;
  }
  camera.lens.p1 = fields.NumberOr("p1", 0);
  camera.lens.p2 = fields.NumberOr("p2", 0);
  if (!SetRadialPolynomial(camera, k)) {
    fields.Refuse("a lens of k4 = " + std::to_string(k[3]) + " is not read");
  }
}

// Answers false when the photo's size is not known and such cameras are left out.
bool SetSize(Camera& camera,
             const Fields& fields,
             const std::string& view,
             const PhotoSizes& photos,
             UnknownPhotos unknown,
             const std::string& file) {
  const auto w = fields.Number("w"), h = fields.Number("h");
  if (!w || !h) {
    const auto size = SizeOfView(view, photos, unknown, file);
    if (!size) return false;
    camera.width_px = size->width_px;
    camera.height_px = size->height_px;
    return true;
  }
  const auto width = SizeFrom(*w), height = SizeFrom(*h);
  if (!width || !height) fields.Fail("w or h is a size that no photo has");
  camera.width_px = *width;
  camera.height_px = *height;
  return true;
}

void SetIntrinsics(Camera& camera, const Fields& fields) {
  const auto fx = FocalFrom(fields, "fl_x", "x_fov", "camera_angle_x", camera.width_px);
  const auto fy = FocalFrom(fields, "fl_y", "y_fov", "camera_angle_y", camera.height_px);
  if (!fx && !fy) fields.Fail("has neither fl_x nor camera_angle_x");
  camera.focal_px = {fx.value_or(*(fy ? fy : fx)), fy.value_or(*(fx ? fx : fy))};
  camera.center_px = {fields.NumberOr("cx", camera.width_px / 2.0),
                      fields.NumberOr("cy", camera.height_px / 2.0)};
  SetLens(camera, fields);
}

void SetPose(Camera& camera, const Json& frame, const Fields& fields) {
  const auto matrix = frame.find("transform_matrix");
  if (matrix == frame.end() || !matrix->is_array() || matrix->size() < 3) {
    fields.Fail("transform_matrix is no matrix of 4 x 4");
  }
  Eigen::Matrix<double, 3, 4> world_from_camera;
  for (int row = 0; row < 3; ++row) {
    const Json& numbers = (*matrix)[row];
    if (!numbers.is_array() || numbers.size() != 4) {
      fields.Fail("transform_matrix is no matrix of 4 x 4");
    }
    for (int column = 0; column < 4; ++column) {
      if (!numbers[column].is_number()) fields.Fail("transform_matrix has no numbers");
      world_from_camera(row, column) = numbers[column].get<double>();
    }
  }
  Eigen::Matrix3d axes = world_from_camera.leftCols<3>();
  axes.rightCols<2>() *= -1;  // y up and z backwards to y down and z forward
  const auto pose = PoseFromAxes(axes, world_from_camera.col(3));
  if (!pose) fields.Fail("transform_matrix is no rotation and position");
  camera.camera_from_world = *pose;
}

Json IntrinsicsOf(const NamedCamera& named, const fs::path& file) {
  const Camera& camera = named.camera;
  const Lens& lens = camera.lens;
  const bool fisheye = lens.model == LensModel::kFisheye;
  if (!fisheye && (lens.k4 != 0 || lens.k5 != 0 || lens.k6 != 0)) {
    throw InputError(file.string() + ": the lens of " + named.view +
                     " has k4, k5 or k6, which transforms.json has no place for; export "
                     "colmap instead");
  }
  Json json = {{"w", camera.width_px},
               {"h", camera.height_px},
               {"fl_x", camera.focal_px.x()},
               {"fl_y", camera.focal_px.y()},
               {"cx", camera.center_px.x()},
               {"cy", camera.center_px.y()},
               {"k1", lens.k1},
               {"k2", lens.k2},
               {"k3", lens.k3}};
  if (fisheye) {
    json["k4"] = lens.k4;
  } else {
    json["p1"] = lens.p1;
    json["p2"] = lens.p2;
  }
  return json;
}

}  // namespace

CalibratedScene ReadTransforms(const fs::path& path,
                               const PhotoSizes& photos,
                               UnknownPhotos unknown) {
  const fs::path file = FileIn(path);
  const Json top = Parsed(file);
  const auto frames = top.is_object() ? top.find("frames") : top.end();
  if (!top.is_object() || frames == top.end() || !frames->is_array()) {
    throw InputError(file.string() + ": has no list \"frames\"; " + kRemedy);
  }
  CalibratedScene scene;
  for (std::size_t i = 0; i < frames->size(); ++i) {
    const Json& frame = (*frames)[i];
    const std::string where = file.string() + ": frame " + std::to_string(i);
    const Fields nothing(top, top, where);
    if (!frame.is_object()) nothing.Fail("is no object");
    const Fields fields(frame, top, where);
    const auto name = frame.find("file_path");
    if (name == frame.end() || !name->is_string()) fields.Fail("has no file_path");
    NamedCamera named{ViewOfImage(name->get_ref<const std::string&>(), photos), {}};
    if (!SetSize(named.camera, fields, named.view, photos, unknown, file.string()))
      continue;
    SetIntrinsics(named.camera, fields);
    SetPose(named.camera, frame, fields);
    scene.cameras.push_back(named);
  }
  FinishScene(scene, file.string());
  return scene;
}

void WriteTransforms(const fs::path& file, const CalibratedScene& scene) {
  Json top = {{"frames", Json::array()}};
  for (const NamedCamera& named : scene.cameras) {
    const bool fisheye = named.camera.lens.model == LensModel::kFisheye;
    const char* model = fisheye ? "OPENCV_FISHEYE" : "OPENCV";
    if (top.contains("camera_model") && top["camera_model"] != model) {
      throw InputError(file.string() +
                       ": some of the cameras are fisheyes and some are not, which "
                       "transforms.json cannot hold; export colmap instead");
    }
    top["camera_model"] = model;
    Json frame = IntrinsicsOf(named, file);
    frame["file_path"] = named.view;
    const Eigen::Matrix4d m = named.camera.camera_from_world.inverse().matrix();
    for (int row = 0; row < 4; ++row) {
      // y down and z forward to y up and z backwards
      frame["transform_matrix"].push_back({m(row, 0), -m(row, 1), -m(row, 2), m(row, 3)});
    }
    top["frames"].push_back(frame);
  }
  WriteTextWhole(file, top.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace relight
