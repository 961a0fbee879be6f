// SPDX-License-Identifier: Apache-2.0
#include "cli/cameras_of_photo.h"
#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/capture/capture.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace relight::cli {
namespace {

struct CamerasRequest {
  std::filesystem::path folder;
  std::vector<std::string> import;  // FORMAT PATH
  bool matching_only = false;
  CamerasOfPhotoRequest alone;  // When `folder` is a photo.
};

int RunVerb(const CamerasRequest& request, const ConsoleOptions& console) {
  if (request.import.empty() && !std::filesystem::is_directory(request.folder)) {
    CamerasOfPhotoRequest alone = request.alone;
    alone.photo.photo = request.folder;
    return RunCamerasOfPhoto(alone, console);
  }
  RefuseForCapture(request.alone);
  if (request.import.empty()) {
    throw OptionError(request.folder.string() +
                      ": is a capture folder; give --import FORMAT PATH");
  }
  if (request.import[0] != "colmap") {
    throw OptionError(
        "--import reads the format colmap (a text model: cameras.txt, images.txt), "
        "got \"" +
        request.import[0] + "\"");
  }
  const Capture capture = OpenCapture(request.folder);
  const ImportSummary summary =
      ImportColmap(capture, request.import[1], request.matching_only);
  SayAll(console, summary.notes);
  Say(console,
      fmt::format("{} cameras of {} photos; their world is taken as east, north, up in "
                  "metres with the tree's foot near the origin",
                  summary.views.size(),
                  capture.file.views.size()));
  if (!console.quiet) fmt::print("{}\n", (request.folder / "cameras").string());
  return 0;
}

}  // namespace

Verb AddCameras(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand(
      "cameras", "Give the photos of a capture, or one photo, cameras");
  auto request = std::make_shared<CamerasRequest>();
  app->add_option("folder", request->folder, "capture folder, or one photo")
      ->required()
      ->type_name("DIR|PHOTO");
  app->add_option("--import",
                  request->import,
                  "colmap and the folder of a text model (cameras.txt, images.txt)")
      ->expected(2)
      ->type_name("FORMAT PATH");
  app->add_flag("--matching-only",
                request->matching_only,
                "leave out cameras without photo and photos without camera");
  AddCamerasOfPhoto(*app, request->alone);
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
