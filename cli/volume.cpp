// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/base/version.h"
#include "relight/base/write_file.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/capture/volume_report.h"
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
  bool force = false, json = false, report = false;
  std::optional<std::string> leave_out, grid, up;
  std::optional<std::filesystem::path> import;
  std::optional<double> metres_per_unit;
  std::map<std::string, std::string> options;
};

// What a user should know of the mattes, from how they fit each other.
void SayFit(const OpacitySummary& summary, const ConsoleOptions& console) {
  for (const ViewWeight& view : summary.views) {
    if (view.weight == 1.0) continue;
    Say(console,
        fmt::format(
            "{}: its matte does not fit the others ({:.2f} rms); it counts for {:.0f} "
            "%. Look at its matte and camera",
            view.view,
            view.residual_rms,
            100 * view.weight));
  }
  if (summary.hidden_voxels > 0) {
    Say(console,
        fmt::format("{} voxels lie where no photo sees into the crown; they are filled "
                    "from their surroundings",
                    summary.hidden_voxels));
  }
}

nlohmann::json JsonOf(const OpacitySummary& summary) {
  nlohmann::json json = {{"residual_rms", summary.residual_rms},
                         {"densified_voxels", summary.densified_voxels},
                         {"hidden_voxels", summary.hidden_voxels},
                         {"iterations", summary.iterations}};
  for (const ViewWeight& view : summary.views) {
    json["mattes"].push_back({{"view", view.view},
                              {"residual_rms", view.residual_rms},
                              {"weight", view.weight}});
  }
  return json;
}

// As --box takes them.
std::vector<double> Corners(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d &low = box.min(), &high = box.max();
  return {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
}

int Judge(const VolumeRequest& request,
          const Capture& capture,
          const CaptureOptions& options,
          const ConsoleOptions& console) {
  const HeldOut judged =
      JudgeVolume(capture, options, *request.leave_out, ShowProgress(console, "volume"));
  SayFit(judged.summary, console);
  if (request.json) {
    nlohmann::json json = JsonOf(judged.summary);
    json["left_out"] = *request.leave_out;
    json["held_out_rmse"] = judged.rmse;
    json["used_rmse"] = judged.rmse_used;
    json["occupied_voxels"] = judged.summary.occupied_voxels;
    fmt::print("{}\n", json.dump(1));
  } else {
    fmt::print(
        "{}: {:.4f} rms of opacity over 0.10 m where it was left out; {:.4f} in "
        "the mean of the views used\n",
        *request.leave_out,
        judged.rmse,
        judged.rmse_used);
  }
  return 0;
}

// Puts a tree of another program into the capture; as a file of the user's own, it stays
// until --force.
void Import(const VolumeRequest& request, const CaptureOptions& options) {
  VdbImport from;
  from.grid = request.grid.value_or("");
  from.scale_per_m = options.volume.scale;
  from.unit_m = request.metres_per_unit.value_or(1.0);
  from.up = request.up == "y" ? UpAxis::kY : UpAxis::kZ;
  if (request.options.contains("cells")) from.cells = options.volume.cells;
  const ExtinctionGrid grid = ImportVdb(*request.import, from);
  WriteVolume(request.folder / "volume.vdb",
              grid,
              {{"software", std::string("relight ") + Version()},
               {"imported", request.import->filename().string()}});
}

// Everything that only an import has a use for.
void RequireImport(const VolumeRequest& request) {
  if (request.import) {
    if (request.leave_out) {
      throw OptionError("--leave-out judges a volume made from mattes; without --import");
    }
    return;
  }
  for (const auto& [flag, given] :
       {std::pair{"--grid", request.grid.has_value()},
        {"--up", request.up.has_value()},
        {"--metres-per-unit", request.metres_per_unit.has_value()}}) {
    if (given) throw OptionError(std::string(flag) + " belongs to --import FILE.vdb");
  }
}

void Report(const VolumeRequest& request,
            const Capture& capture,
            const CaptureOptions& options,
            const ConsoleOptions& console) {
  const auto file = request.folder / "volume.html";
  WriteTextWhole(file, VolumeReport(capture, options, ShowProgress(console, "report")));
  if (!console.quiet && !request.json) fmt::print("{}\n", file.string());
}

int RunVerb(const VolumeRequest& request, const ConsoleOptions& console) {
  RequireImport(request);
  const Capture capture = OpenCapture(request.folder);
  const CaptureOptions options = OptionsFrom(capture.file, request.options);
  if (request.import) Import(request, options);
  StageRecords records(capture.folder);
  const auto cameras = VolumeCamerasOf(capture, options);
  if (const std::string note = SelectionNote(capture, options); !note.empty())
    Say(console, note);
  const Progress progress = ShowProgress(console, "mattes");
  CaptureMattes mattes(capture, records, options);
  const bool needs_mattes = !request.import || request.report;
  for (const auto& [name, camera] : cameras) {
    if (needs_mattes) mattes.Make(FindView(capture, name), false, progress);
  }
  if (request.leave_out) return Judge(request, capture, options, console);
  const auto file = request.folder / "volume.vdb";
  std::optional<MadeVolume> made;
  if (request.import) {
    Say(console, file.string() + " is from " + request.import->string());
  } else if (VolumeIsStale(capture, records, options, request.force)) {
    made = MakeVolume(capture, records, options, ShowProgress(console, "volume"));
  } else {
    Say(console,
        file.string() +
            (VolumeIsEdited(capture, records)
                 ? " is not as relight made it; it stays as it is"
                 : " is up to date") +
            " (--force makes it again)");
  }
  if (request.report) Report(request, capture, options, console);
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
      Say(console, "the box is from " + made->box_from);
      if (const std::string words = AgreementInWords(made->agreement); !words.empty())
        Say(console, words);
      Say(console,
          fmt::format("the mattes are met within {:.3f} rms",
                      made->summary.residual_rms));
      SayFit(made->summary, console);
    }
    if (!console.quiet) fmt::print("{}\n", file.string());
    return 0;
  }
  nlohmann::json json = {{"file", file.string()},
                         {"cells", {grid.cells.x(), grid.cells.y(), grid.cells.z()}},
                         {"cell_m", grid.cell_m},
                         {"box_m", Corners(grid.Bounds())},
                         {"occupied_voxels", occupied},
                         {"views", cameras.size()},
                         {"made", made.has_value()}};
  if (made) {
    json.update(JsonOf(made->summary));
    json["box_from"] = made->box_from;
    json["kth_smallest"] = made->agreement.kth_smallest;
    json["lost_share"] = made->agreement.lost;
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
  app->add_option("--leave-out",
                  request->leave_out,
                  "judge: make a volume without this view and compare it with the view's "
                  "matte; volume.vdb stays as it is")
      ->type_name("VIEW");
  app->add_flag("--report",
                request->report,
                "write a page to look at: slices, each view beside its matte, how the "
                "fit went; DIR/volume.html");
  app->add_option("--import",
                  request->import,
                  "in place of mattes: a volume of another program; it stays until "
                  "--force. --scale is its extinction [1/m] at a density of 1, --cells N "
                  "takes coarser voxels")
      ->type_name("FILE.vdb");
  app->add_option("--grid",
                  request->grid,
                  "with --import: which grid of the file [extinction, density, or its "
                  "only one]")
      ->type_name("NAME");
  app->add_option("--metres-per-unit",
                  request->metres_per_unit,
                  "with --import: metres of a unit of the file's world [1]")
      ->check(CLI::Range(1e-6, 1e6).description(""))
      ->type_name("M");
  app->add_option("--up", request->up, "with --import: its axis that is up [z]")
      ->check(CLI::IsMember({"z", "y"}).description(""))
      ->type_name("z|y");
  app->add_flag("--json", request->json, "print figures as JSON");
  AddFlags(*app, OpacityOptions(), "Volume", request->options);
  AddFlags(*app, VolumeBoxOptions(), "Volume", request->options);
  AddFlags(*app, ViewSelectionOptions(), "Volume", request->options);
  AddFlags(*app, MatteOptions(), "Matte", request->options);
  AddFlags(*app, ReadPhotoOptions(), "Photo", request->options);
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
