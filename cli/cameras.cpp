// SPDX-License-Identifier: Apache-2.0
#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/capture/capture.h"
#include "relight/capture/capture_times.h"

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
};

int RunVerb(const CamerasRequest& request, const ConsoleOptions& console) {
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
  SayAll(console, DoubtsOfCapture(capture));
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
  CLI::App* app =
      program.add_subcommand("cameras", "Give the photos of a capture their cameras");
  auto request = std::make_shared<CamerasRequest>();
  app->add_option("folder", request->folder, "capture folder")
      ->required()
      ->type_name("DIR");
  app->add_option("--import",
                  request->import,
                  "colmap and the folder of a text model (cameras.txt, images.txt)")
      ->required()
      ->expected(2)
      ->type_name("FORMAT PATH");
  app->add_flag("--matching-only",
                request->matching_only,
                "leave out cameras without photo and photos without camera");
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
