// SPDX-License-Identifier: Apache-2.0
#pragma once

// `relight cameras PHOTO`: the camera of one photo.

#include "cli/console.h"
#include "relight/capture/one_photo_camera.h"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>

namespace relight::cli {

struct CamerasOfPhotoRequest {
  OnePhotoRequest photo;  // Its `photo` is set by the verb.
  std::optional<std::filesystem::path> output;
  bool json = false;
};

void AddCamerasOfPhoto(CLI::App& app, CamerasOfPhotoRequest& request);

int RunCamerasOfPhoto(const CamerasOfPhotoRequest& request,
                      const ConsoleOptions& console);

// Throws OptionError when a capture folder was given options of one photo.
void RefuseForCapture(const CamerasOfPhotoRequest& request);

}  // namespace relight::cli
