// SPDX-License-Identifier: Apache-2.0
#include "cli/verbs.h"
#include "relight/capture/capture.h"
#include "relight/capture/capture_times.h"
#include "relight/photo/photo_facts.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace relight::cli {
namespace {

struct InitRequest {
  std::filesystem::path folder;
  std::vector<std::filesystem::path> photos;
};

int RunVerb(const InitRequest& request, const ConsoleOptions& console) {
  const Capture capture = InitCapture(request.folder, request.photos);
  int without_time = 0, without_zone = 0, without_place = 0;
  for (const ViewEntry& view : capture.file.views) {
    const PhotoFacts facts = ReadPhotoFacts(capture.PhotoOf(view));
    const bool gps_time = facts.gps_time.has_value();
    without_time += !facts.local_time && !gps_time && !view.taken && !capture.file.taken;
    without_zone += facts.local_time && !facts.offset && !gps_time && !capture.file.zone;
    without_place += !facts.place && !capture.file.place;
  }
  const std::string toml = (request.folder / "capture.toml").string();
  Say(console, fmt::format("{}: {} views", toml, capture.file.views.size()));
  const auto lacks = [&](int photos, const char* what, const char* line) {
    if (photos > 0)
      Say(console,
          fmt::format("{} photos have {}; write {} into {}", photos, what, line, toml));
  };
  lacks(without_time, "no capture time", "taken = \"2011-07-22T13:00\"");
  lacks(without_zone, "a time without zone", "zone = \"Europe/Paris\"");
  lacks(without_place, "no place", "place = \"48.85,2.35\"");
  SayAll(console, DoubtsOfCapture(capture));
  const std::string folder = request.folder.string();
  if (!std::filesystem::exists(request.folder / "cameras" / "images.txt") &&
      capture.file.views.size() > 1) {
    Say(console, "no cameras yet: relight cameras " + folder + " finds them");
  }
  Say(console,
      "which pixels are tree: put a matte of each photo's size into " +
          (request.folder / "mattes").string() +
          ", or a trimap (0 no tree, 255 tree, "
          "128 unknown) into " +
          (request.folder / "trimaps").string() + ", named like the photo");
  if (!console.quiet) fmt::print("{}\n", toml);
  return 0;
}

}  // namespace

Verb AddInit(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("init", "Make a capture folder from photos of one tree");
  auto request = std::make_shared<InitRequest>();
  app->add_option(
         "folder", request->folder, "the capture folder; made when it is not there")
      ->required()
      ->type_name("DIR");
  app->add_option("photos",
                  request->photos,
                  "photos, or a folder of them; left out, those in DIR/photos")
      ->type_name("PHOTO…");
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
