// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture.h"

#include "relight/base/angles.h"
#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/colmap_model.h"
#include "relight/cameras/view_name.h"
#include "relight/capture/capture_folder.h"
#include "relight/photo/photo_facts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>
#include <system_error>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr std::array kImageExtensions = {".jpg",
                                         ".jpeg",
                                         ".png",
                                         ".tif",
                                         ".tiff",
                                         ".exr",
                                         ".heic",
                                         ".heif",
                                         ".dng",
                                         ".cr2",
                                         ".cr3",
                                         ".nef",
                                         ".arw",
                                         ".orf",
                                         ".raf",
                                         ".rw2"};

bool IsImage(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(
      extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
      });
  return std::find(kImageExtensions.begin(), kImageExtensions.end(), extension) !=
         kImageExtensions.end();
}

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && IsImage(entry.path()) && name[0] != '.') {
      images.push_back(entry.path());
    }
  }
  std::sort(images.begin(), images.end());
  return images;
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

void CopyPhoto(const fs::path& from, const fs::path& to) {
  WriteFileWhole(to, [&](const fs::path& temporary) {
    std::error_code error;
    fs::copy_file(from, temporary, fs::copy_options::overwrite_existing, error);
    if (error) {
      throw InputError(to.string() + ": cannot be written: " + error.message() +
                       "; free some space or make the capture on another disk");
    }
  });
}

}  // namespace

CaptureOptions OptionsFrom(const CaptureFile& file,
                           const std::map<std::string, std::string>& from_user) {
  CaptureOptions options;
  const auto set = [&](const std::string& name, const std::string& text) {
    if (SetField(options, name, text)) return CheckFields(options);
    std::string list;
    Describe(options, [&](auto&, const FieldInfo& info) {
      list += (list.empty() ? "" : ", ") + std::string(info.name);
    });
    throw OptionError("unknown option \"" + name + "\"; known are " + list);
  };
  for (const auto& [name, entry] : file.options) {
    try {
      set(name, entry.text);
    } catch (const OptionError& error) {
      throw InputError(entry.where + ": " + error.what());
    }
  }
  for (const auto& [name, text] : from_user) set(name, text);
  // The paper as a whole, its volume too
  if (options.light.method == Method::kCabral2011 &&
      !file.options.contains("volume-method") && !from_user.contains("volume-method")) {
    options.volume.method = VolumeMethod::kReche2004;
  }
  return options;
}

Capture OpenCapture(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw InputError(folder.string() + (fs::exists(folder)
                                            ? ": is a file, and this needs a capture "
                                              "folder; make one with: relight init "
                                              "FOLDER PHOTO…"
                                            : ": no such folder; check the name, or make "
                                              "a capture with: relight init FOLDER "
                                              "PHOTO…"));
  }
  if (!fs::exists(folder / "capture.toml")) {
    throw InputError(
        folder.string() +
        ": not a capture folder (no capture.toml in it); make it one with: relight "
        "init " +
        folder.string() + " PHOTO…");
  }
  return {folder, ReadCaptureFile(folder / "capture.toml")};
}

const ViewEntry& FindView(const Capture& capture, const std::string& name) {
  std::vector<std::string> names;
  for (const ViewEntry& view : capture.file.views) {
    if (view.name == name) return view;
    names.push_back(view.name);
  }
  throw InputError(capture.folder.string() + ": no view \"" + name +
                   "\"; its views are " + Listed(names));
}

std::optional<CaptureView> CaptureOfPhoto(const fs::path& photo) {
  std::error_code ignored;
  const fs::path own = fs::absolute(photo, ignored).lexically_normal().parent_path();
  for (const fs::path& folder : {own, own.parent_path()}) {
    if (!fs::is_regular_file(folder / "capture.toml", ignored)) continue;
    const Capture capture = OpenCapture(folder);
    const auto& views = capture.file.views;
    for (const ViewEntry& view : views) {
      if (fs::equivalent(capture.PhotoOf(view), photo, ignored))
        return CaptureView{folder, view.name};
    }
    for (const ViewEntry& view : views) {
      if (photo.stem() == view.name) return CaptureView{folder, view.name};
    }
  }
  return {};
}

std::optional<fs::path> FileOfView(const Capture& capture,
                                   const std::string& subfolder,
                                   const std::string& view) {
  for (const char* extension : kImageExtensions) {
    const fs::path file = capture.folder / subfolder / (view + extension);
    if (fs::is_regular_file(file)) return file;
  }
  return std::nullopt;
}

std::map<std::string, Camera> CamerasOf(const Capture& capture) {
  if (!fs::exists(capture.folder / "cameras" / "images.txt")) {
    const std::string command = "relight cameras " + capture.folder.string();
    throw InputError(
        capture.folder.string() + ": no cameras yet; find them with: " + command +
        "\nor import what another program found: " + command + " --import PATH");
  }
  std::map<std::string, Camera> cameras;
  for (const NamedCamera& named : ReadColmap(capture.folder / "cameras").cameras) {
    const bool has_photo = std::any_of(
        capture.file.views.begin(), capture.file.views.end(), [&](const ViewEntry& view) {
          return view.name == named.view;
        });
    if (!has_photo) {
      throw InputError(
          (capture.folder / "cameras" / "images.txt").string() + ": camera \"" +
          named.view +
          "\" has no photo in capture.toml; add the photo with \"relight init\", or "
          "make the cameras again with \"relight cameras\"");
    }
    cameras[named.view] = named.camera;
  }
  return cameras;
}

Capture InitCapture(const fs::path& folder, std::span<const fs::path> photos) {
  // What there is, and what is given
  Capture capture{folder, {}};
  if (fs::exists(folder / "capture.toml"))
    capture.file = ReadCaptureFile(folder / "capture.toml");
  std::vector<fs::path> found;
  for (const fs::path& given : photos) {
    if (fs::is_directory(given)) {
      const std::vector<fs::path> images = ImagesIn(given);
      if (images.empty()) throw InputError(given.string() + ": no photo in this folder");
      found.insert(found.end(), images.begin(), images.end());
    } else {
      found.push_back(given);
    }
  }
  if (photos.empty() && fs::is_directory(folder / "photos"))
    found = ImagesIn(folder / "photos");
  if (found.empty()) {
    throw InputError(folder.string() + ": no photos given and none in " +
                     (folder / "photos").string() + "; name them: relight init " +
                     folder.string() + " PHOTO…");
  }

  // Everything is looked at before anything is written
  std::map<std::string, fs::path> photo_of_name;
  for (const fs::path& photo : found) {
    const PhotoFacts facts = ReadPhotoFacts(photo);
    if (facts.made_by_relight) {
      throw InputError(photo.string() +
                       ": is a result of relight; give the photo it was made from");
    }
    const std::string name = ViewNameOf(photo);
    const auto [same, added] = photo_of_name.emplace(name, photo);
    if (!added) {
      throw InputError(photo.string() + " and " + same->second.string() +
                       " would both be the view \"" + name + "\"; rename one");
    }
  }

  // Only what is new is added
  std::vector<ViewEntry> added;
  for (const auto& [name, photo] : photo_of_name) {
    const fs::path kept = fs::path("photos") / photo.filename();
    const auto same = std::find_if(
        capture.file.views.begin(), capture.file.views.end(), [&](const ViewEntry& view) {
          return view.name == name;
        });
    const fs::path there =
        folder / (same == capture.file.views.end() ? kept : same->photo);
    if (fs::exists(there) && HashOfFile(there) != HashOfFile(photo)) {
      throw InputError(photo.string() + ": another photo is the view \"" + name +
                       "\" already, " + there.string() +
                       "; rename the new one, or take the old one away first");
    }
    if (same == capture.file.views.end()) added.push_back({name, kept, std::nullopt});
  }
  for (const auto& [name, photo] : photo_of_name) {
    const fs::path kept = folder / "photos" / photo.filename();
    if (fs::exists(kept)) continue;
    MakeFolderOf(folder, "photos");
    CopyPhoto(photo, kept);
  }
  capture.file.views.insert(capture.file.views.end(), added.begin(), added.end());
  const fs::path toml = folder / "capture.toml";
  WriteTextWhole(toml,
                 fs::exists(toml) ? ReadText(toml) + ViewsText(added)
                                  : CaptureFileText(capture.file));
  return capture;
}

}  // namespace relight
