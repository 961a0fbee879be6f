// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the fuzzers of the camera formats share. An input is a file, or, for formats of
// several files, these with kNextFile between them.

#include "relight/base/error.h"
#include "relight/cameras/camera_parts.h"
#include "tests/support/scratch_folder.h"

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace relight::fuzz {

inline constexpr std::string_view kNextFile = "<next file>";

// Sizes of the photos that the seeds have cameras of.
inline const PhotoSizes& Photos() {
  static const PhotoSizes photos = {{"view_10", {640, 480}}, {"view_11", {480, 640}}};
  return photos;
}

// Writes the parts of the input to the files named, in a folder of this process.
inline const tests::ScratchFolder& Written(const unsigned char* data,
                                           std::size_t size,
                                           const std::vector<std::string>& names) {
  static const tests::ScratchFolder folder;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  for (const std::string& name : names) {
    const std::size_t end = std::min(rest.find(kNextFile), rest.size());
    const bool is_last = &name == &names.back();
    const std::string_view part = is_last ? rest : rest.substr(0, end);
    std::ofstream(folder / name, std::ios::binary) << part;
    rest.remove_prefix(std::min(rest.size(), end + kNextFile.size()));
  }
  return folder;
}

// Reads a scene and looks through its cameras. An InputError is an answer; whatever else
// is thrown is found.
template <class Read>
int Survives(const Read& read) {
  try {
    const CalibratedScene scene = read();
    for (const NamedCamera& named : scene.cameras) {
      const Eigen::Vector3d ray = named.camera.RayInWorld({3, 5});
      named.camera.Project(named.camera.PositionInWorld() + ray);
    }
  } catch (const InputError&) {
  }
  return 0;
}

}  // namespace relight::fuzz
