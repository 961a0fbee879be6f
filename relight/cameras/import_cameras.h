// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras that another program calibrated, in any of the formats that are known, and the
// way back. docs/cameras.md says where each program writes its file.

#include "relight/cameras/camera_parts.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace relight {

// Words of --import, in the order in which they are listed: colmap, bundler, transforms,
// metashape, realitycapture. And of --export: colmap, transforms.
const std::vector<std::string>& ImportFormats();
const std::vector<std::string>& ExportFormats();

// The format of a file or folder, by its name, what is in the folder, or its first bytes.
// Throws InputError that lists the formats when it fits none of them, or several.
std::string GuessCameraFormat(const std::filesystem::path& path);

// `format` empty: guessed. `photos` gives the upright sizes of the user's photos. Throws
// InputError for an unknown word, a path that is not there, and as the readers do:
// colmap_model.h, bundler_file.h, transforms_file.h, metashape_file.h,
// realitycapture_files.h.
CalibratedScene ImportCameras(const std::string& format,
                              const std::filesystem::path& path,
                              const PhotoSizes& photos,
                              UnknownPhotos unknown = UnknownPhotos::kRefuse);

// colmap: into the folder `path`. transforms: into the file `path`, if it ends in .json,
// else as transforms.json into the folder. `files` gives the photos' file names by view;
// a view that has none there is written by its own name. Throws InputError for an unknown
// word, and when the files cannot be written.
void ExportCameras(const std::string& format,
                   const std::filesystem::path& path,
                   const CalibratedScene& scene,
                   const std::map<std::string, std::string>& files = {});

}  // namespace relight
