// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/volume/vdb_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {

struct VolumeRequest {
  std::filesystem::path folder;
  bool force = false, json = false;
  std::map<std::string, std::string> options;
};

int RunVerb(const VolumeRequest& request, const ConsoleOptions& console) {
  const Capture capture = OpenCapture(request.folder);
  const CaptureOptions options = OptionsFrom(capture.file, request.options);
  StageRecords records(capture.folder);
  const auto cameras = VolumeCamerasOf(capture, options);
  if (const std::string note = SelectionNote(capture, options); !note.empty())
    Say(console, note);
  const Progress progress = ShowProgress(console, "mattes");
  CaptureMattes mattes(capture, records, options);
  for (const auto& [name, camera] : cameras) {
    mattes.Make(FindView(capture, name), false, progress);
  }
  const auto file = request.folder / "volume.vdb";
  std::optional<OpacitySummary> made;
  if (VolumeIsStale(capture, records, options, request.force)) {
    made = MakeVolume(capture, records, options, ShowProgress(console, "volume"));
  } else {
    Say(console, file.string() + " is up to date (--force makes it again)");
  }
  const ExtinctionGrid grid = ReadVolume(file);
  const std::size_t occupied = FindOccupied(grid).cell.size();
  if (!request.json) {
    Say(console,
        fmt::format("{} x {} x {} voxels of {:.3f} m, {} hold tree",
                    grid.cells.x(),
                    grid.cells.y(),
                    grid.cells.z(),
                    grid.cell_m,
                    occupied));
    if (made) {
      Say(console,
          fmt::format("the mattes are met within {:.3f} rms", made->residual_rms));
    }
    if (!console.quiet) fmt::print("{}\n", file.string());
    return 0;
  }
  nlohmann::json json = {{"file", file.string()},
                         {"cells", {grid.cells.x(), grid.cells.y(), grid.cells.z()}},
                         {"cell_m", grid.cell_m},
                         {"occupied_voxels", occupied},
                         {"views", cameras.size()},
                         {"made", made.has_value()}};
  if (made) {
    json["residual_rms"] = made->residual_rms;
    json["densified_voxels"] = made->densified_voxels;
  }
  fmt::print("{}\n", json.dump(1));
  return 0;
}

}  // namespace

Verb AddVolume(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("volume", "Estimate the tree's volume from its mattes");
  auto request = std::make_shared<VolumeRequest>();
  app->add_option("folder", request->folder, "capture folder")
      ->required()
      ->type_name("DIR");
  app->add_flag("--force", request->force, "make it again");
  app->add_flag("--json", request->json, "print figures as JSON");
  AddFlags(*app, OpacityOptions(), "Volume", request->options);
  AddFlags(*app, ViewSelectionOptions(), "Volume", request->options);
  AddFlags(*app, MatteOptions(), "Matte", request->options);
  AddFlags(*app, ReadPhotoOptions(), "Photo", request->options);
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
