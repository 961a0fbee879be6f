// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/import_cameras.h"

#include "relight/base/error.h"
#include "relight/cameras/bundler_file.h"
#include "relight/cameras/colmap_model.h"
#include "relight/cameras/metashape_file.h"
#include "relight/cameras/realitycapture_files.h"
#include "relight/cameras/transforms_file.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <string_view>

namespace relight {
namespace fs = std::filesystem;
namespace {

std::string Listed(const std::vector<std::string>& words) {
  std::string listed;
  for (const std::string& word : words) listed += (listed.empty() ? "" : ", ") + word;
  return listed;
}

std::string FirstBytes(const fs::path& file) {
  std::string bytes(4096, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

// "" when it is none. Extensions that others use too are not believed alone.
std::string FormatOfFile(const fs::path& file) {
  const std::string name = file.filename().string(),
                    extension = file.extension().string();
  for (const char* known : {"cameras.txt", "images.txt", "cameras.bin", "images.bin"}) {
    if (name == known) return "colmap";
  }
  const std::string bytes = FirstBytes(file);
  const auto has = [&](std::string_view part) {
    return bytes.find(part) != std::string::npos;
  };
  if (bytes.starts_with("# Bundle file")) return "bundler";
  if (has("<document") && has("<chunk")) return "metashape";
  if (has("capturingreality.com/ns/xcr")) return "realitycapture";
  if (has("name,x,y,alt,")) return "realitycapture";
  if (extension == ".json" && (has("\"frames\"") || has("\"fl_x\"") ||
                               has("\"camera_angle_x\"") || has("\"camera_model\""))) {
    return "transforms";
  }
  if (name.starts_with("transforms") && extension == ".json") return "transforms";
  if (extension == ".out") return "bundler";
  return "";
}

std::string FormatsListed() {
  return "known are " + Listed(ImportFormats()) + ": say which with --import FORMAT PATH";
}

}  // namespace

const std::vector<std::string>& ImportFormats() {
  static const std::vector<std::string> formats = {
      "colmap", "bundler", "transforms", "metashape", "realitycapture"};
  return formats;
}

const std::vector<std::string>& ExportFormats() {
  static const std::vector<std::string> formats = {"colmap", "transforms"};
  return formats;
}

std::string GuessCameraFormat(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError(path.string() + ": not there; give the file or folder of cameras");
  }
  std::set<std::string> found;
  if (fs::is_directory(path)) {
    for (const auto& entry : fs::directory_iterator(path, error)) {
      if (!entry.is_regular_file(error)) continue;
      const std::string extension = entry.path().extension().string();
      for (const char* read : {".txt", ".bin", ".out", ".json", ".xml", ".csv", ".xmp"}) {
        if (extension == read) found.insert(FormatOfFile(entry.path()));
      }
    }
  } else {
    found.insert(FormatOfFile(path));
  }
  found.erase("");
  if (found.size() == 1) return *found.begin();
  if (found.empty()) {
    throw InputError(path.string() + ": the cameras' format is not recognised; " +
                     FormatsListed());
  }
  throw InputError(path.string() + ": holds cameras of several formats, " +
                   Listed({found.begin(), found.end()}) + "; " + FormatsListed());
}

CalibratedScene ImportCameras(const std::string& format,
                              const fs::path& path,
                              const PhotoSizes& photos,
                              UnknownPhotos unknown) {
  const auto& known = ImportFormats();
  if (!format.empty() && std::find(known.begin(), known.end(), format) == known.end()) {
    throw InputError("\"" + format + "\" is no format of cameras; " + FormatsListed());
  }
  const std::string guessed = format.empty() ? GuessCameraFormat(path) : format;
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError(path.string() + ": not there; give the file or folder of cameras");
  }
  if (guessed == "bundler") return ReadBundler(path, photos, unknown);
  if (guessed == "transforms") return ReadTransforms(path, photos, unknown);
  if (guessed == "metashape") return ReadMetashape(path, photos);
  if (guessed == "realitycapture") return ReadRealityCapture(path, photos, unknown);
  const bool is_folder = fs::is_directory(path, error);
  return ReadColmap(is_folder ? path : fs::absolute(path).parent_path());
}

void ExportCameras(const std::string& format,
                   const fs::path& path,
                   const CalibratedScene& scene,
                   const std::map<std::string, std::string>& files) {
  CalibratedScene named = scene;
  for (NamedCamera& camera : named.cameras) {
    const auto file = files.find(camera.view);
    if (file != files.end()) camera.view = file->second;
  }
  if (format == "colmap") {
    WriteColmap(path, named);
  } else if (format == "transforms") {
    if (path.extension() == ".json") {
      WriteTransforms(path, named);
    } else {
      std::error_code error;
      fs::create_directories(path, error);
      WriteTransforms(path / "transforms.json", named);
    }
  } else {
    throw InputError("\"" + format +
                     "\" is no format that cameras are written in; known "
                     "are " +
                     Listed(ExportFormats()));
  }
}

}  // namespace relight
