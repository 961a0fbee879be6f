// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/photo/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;

struct MatteRequest {
  fs::path source;
  MatteGuide guide;
  std::optional<fs::path> output, foreground, trimap_output;
  bool force = false, json = false;
  std::map<std::string, std::string> options;
};

constexpr double kSure = 0.5;  // Below it a photo wants a stroke.

nlohmann::json ReportJson(const MatteReport& report) {
  return {{"view", report.view},
          {"matte", report.file},
          {"made_from", report.made_from},
          {"confidence", report.confidence},
          {"doubts", report.doubts}};
}

void SayDoubts(const ConsoleOptions& console,
               const std::string& of,
               const std::vector<std::string>& doubts) {
  for (const std::string& doubt : doubts) Say(console, of + ": " + doubt);
}

// Those of the volume and those with a guide of their own; all, without cameras.
std::vector<ViewEntry> ViewsToMatte(const Capture& capture,
                                    const CaptureOptions& options) {
  if (!fs::exists(capture.folder / "cameras" / "images.txt")) return capture.file.views;
  const auto all = CamerasOf(capture), of_volume = VolumeCamerasOf(capture, options);
  std::vector<ViewEntry> views;
  for (const ViewEntry& view : capture.file.views) {
    const bool between = all.contains(view.name) && !of_volume.contains(view.name);
    if (!between || FileOfView(capture, "trimaps", view.name) ||
        FileOfView(capture, "scribbles", view.name)) {
      views.push_back(view);
    }
  }
  return views;
}

int OfCapture(const MatteRequest& request, const ConsoleOptions& console) {
  const MatteGuide& guide = request.guide;
  if (guide.trimap || !guide.scribbles.empty() || guide.refine || !guide.screen.empty() ||
      request.output || request.foreground || request.trimap_output) {
    throw OptionError(
        "--trimap, --scribbles, --refine, --screen, -o, --foreground and --save-trimap "
        "belong to one photo; a capture has trimaps/, scribbles/ and mattes/");
  }
  const Capture capture = OpenCapture(request.source);
  const CaptureOptions options = OptionsFrom(capture.file, request.options);
  StageRecords records(capture.folder);
  CaptureMattes mattes(capture, records, options);
  const Progress progress = ShowProgress(console, "mattes");
  const std::vector<ViewEntry> views = ViewsToMatte(capture, options);
  if (views.size() < capture.file.views.size()) {
    Say(console,
        fmt::format("mattes are made of {} of {} views: those of the volume, and those "
                    "with a guide of their own (--most-views N takes more or fewer; a "
                    "view that is relit gets its matte then)",
                    views.size(),
                    capture.file.views.size()));
  }
  const auto count = static_cast<double>(views.size());
  double done = 0;
  nlohmann::json json = nlohmann::json::array();
  std::vector<std::string> unsure;
  for (const ViewEntry& view : views) {
    const bool made =
        mattes.Make(view, request.force, progress.Part(done / count, (done + 1) / count));
    const MatteReport report = mattes.ReportOf(view);
    ++done;
    json.push_back(ReportJson(report));
    if (report.confidence < kSure) unsure.push_back(view.name);
    if (!made || request.json) continue;
    if (!console.quiet) fmt::print("{}\n", (capture.folder / report.file).string());
    if (report.made_from.rfind("trimaps", 0) != 0) {
      Say(console, fmt::format("{}: confidence {:.2f}", view.name, report.confidence));
    }
    SayDoubts(console, view.name, report.doubts);
  }
  if (request.json) fmt::print("{}\n", json.dump(1));
  if (!unsure.empty()) {
    std::string names = unsure.front();
    for (std::size_t i = 1; i < unsure.size(); ++i) names += ", " + unsure[i];
    Say(console,
        fmt::format(
            "look at {}: unsure. Draw strokes, white on the tree and black beside "
            "it, on an empty picture of the photo's size, into {}",
            names,
            (capture.folder / "scribbles" / (unsure.front() + ".png")).string()));
  }
  Say(console, fmt::format("{} mattes are up to date", views.size()));
  return 0;
}

// A file that says by its name that it is of another kind than what is written misleads.
void RequireEnding(const fs::path& file, const char* ending, const char* what) {
  std::string has = file.extension().string();
  std::transform(has.begin(), has.end(), has.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (has == ending) return;
  throw OptionError(file.string() + ": " + what + " is written as " + ending +
                    "; give a name that ends so");
}

void RequireOutputs(const MatteRequest& request, const fs::path& output) {
  RequireEnding(output, ".png", "the matte");
  if (request.foreground) RequireEnding(*request.foreground, ".exr", "the foreground");
  if (request.trimap_output) RequireEnding(*request.trimap_output, ".png", "the trimap");
  if (request.trimap_output && *request.trimap_output == output) {
    throw OptionError(output.string() +
                      ": matte and trimap would be one file; give two names");
  }
  std::vector<fs::path> inputs = request.guide.scribbles;
  inputs.push_back(request.source);
  if (request.guide.trimap) inputs.push_back(*request.guide.trimap);
  if (request.guide.refine) inputs.push_back(*request.guide.refine);
  for (const auto& written :
       {std::optional(output), request.foreground, request.trimap_output}) {
    for (const fs::path& input : inputs) {
      std::error_code ignored;
      if (written && fs::equivalent(*written, input, ignored)) {
        throw InputError(written->string() + ": is an input; give another name");
      }
    }
    if (written) RequirePlaceFor(*written);
  }
}

int OfPhoto(const MatteRequest& request, const ConsoleOptions& console) {
  RequireOneGuide(request.guide);
  const CaptureOptions options = OptionsFrom({}, request.options);
  const fs::path output = request.output.value_or(
      request.source.parent_path() / (request.source.stem().string() + "_matte.png"));
  RequireOutputs(request, output);
  const Progress progress = ShowProgress(console, "matte");
  const Photo photo = ReadPhoto(request.source, options.photo);
  const PhotoMatte matte = EstimatePhotoMatte(photo,
                                              request.source,
                                              request.guide,
                                              options.matte,
                                              nullptr,
                                              progress.Part(0, 0.8));
  if (request.foreground) {
    // An alpha in the photo is no matter here: the matte is what was asked for
    const Photo opaque{photo.pixels};
    WriteLinear(
        *request.foreground,
        {{"", ForegroundOf(opaque, matte.alpha, matte.screen, progress.Part(0.8, 1))}},
        {},
        LinearDepth::kHalf);
  }
  if (request.trimap_output) {
    cv::Mat1f labels;
    matte.trimap.convertTo(labels, CV_32F, 1.0 / 255);
    WriteMatte(*request.trimap_output, labels);
  }
  WriteMatte(output, matte.alpha);
  if (request.json) {
    nlohmann::json json = ReportJson({request.source.stem().string(),
                                      output.string(),
                                      matte.made_from,
                                      matte.confidence,
                                      matte.doubts});
    if (request.foreground) json["foreground"] = request.foreground->string();
    fmt::print("{}\n", json.dump(1));
    return 0;
  }
  if (!console.quiet) {
    fmt::print("{}\n", output.string());
    for (const auto& more : {request.foreground, request.trimap_output}) {
      if (more) fmt::print("{}\n", more->string());
    }
  }
  Say(console,
      fmt::format("made from {}, confidence {:.2f}", matte.made_from, matte.confidence));
  SayDoubts(console, request.source.string(), matte.doubts);
  return 0;
}

}  // namespace

Verb AddMatte(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("matte", "Separate the tree from what is behind it");
  auto request = std::make_shared<MatteRequest>();
  MatteGuide& guide = request->guide;
  app->add_option("source", request->source, "capture folder, or one photo")
      ->required()
      ->type_name("DIR|PHOTO");
  app->add_option("--trimap", guide.trimap, "0 no tree, 255 tree, 128 unknown")
      ->type_name("FILE")
      ->group("What is known (else: found, for a tree against sky)");
  app->add_option("--scribbles",
                  guide.scribbles,
                  "strokes, white or green on the tree, black or red beside it; or two "
                  "masks, of tree and of background")
      ->type_name("FILE")
      ->expected(1, 2)
      ->group("What is known (else: found, for a tree against sky)");
  app->add_flag("--automatic",
                guide.automatic,
                "with --scribbles: find what is not scribbled on")
      ->group("What is known (else: found, for a tree against sky)");
  app->add_option("--refine",
                  guide.refine,
                  "mask cut by hand: its edge and its filled holes are made anew")
      ->type_name("ALPHA")
      ->group("What is known (else: found, for a tree against sky)");
  app->add_option("--screen",
                  guide.screen,
                  "blue or green screen behind: auto, blue, green or R,G,B of 0 to 255")
      ->type_name("COLOUR")
      ->group("What is known (else: found, for a tree against sky)");
  app->add_option("-o,--output", request->output, "16-bit .png [PHOTO_matte.png]")
      ->type_name("FILE");
  app->add_option(
         "--foreground",
         request->foreground,
         "write the tree's colours without what is behind, linear half-float .exr")
      ->type_name("FILE");
  app->add_option("--save-trimap",
                  request->trimap_output,
                  "write the trimap that was found, to draw on, .png")
      ->type_name("FILE");
  app->add_flag("--force", request->force, "make mattes again that are up to date");
  app->add_flag("--json", request->json, "print what was made, and how sure it is");
  AddFlags(*app, MatteOptions(), "Matte", request->options);
  AddFlags(*app, ViewSelectionOptions(), "Matte", request->options);
  AddFlags(*app, ReadPhotoOptions(), "Photo", request->options);
  return {app, [request, &console] {
            return std::filesystem::is_directory(request->source)
                       ? OfCapture(*request, console)
                       : OfPhoto(*request, console);
          }};
}

}  // namespace relight::cli
