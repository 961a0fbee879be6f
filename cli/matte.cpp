// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/capture/view_matte.h"
#include "relight/photo/image_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;

struct MatteRequest {
  fs::path source;
  std::optional<fs::path> trimap, output, foreground;
  bool force = false;
  std::map<std::string, std::string> options;
};

int OfCapture(const MatteRequest& request, const ConsoleOptions& console) {
  if (request.trimap || request.output || request.foreground) {
    throw OptionError(
        "--trimap, -o and --foreground belong to one photo; a capture has trimaps/ "
        "and mattes/");
  }
  const Capture capture = OpenCapture(request.source);
  const CaptureOptions options = OptionsFrom(capture.file, request.options);
  StageRecords records(capture.folder);
  const Progress progress = ShowProgress(console, "mattes");
  const auto count = static_cast<double>(capture.file.views.size());
  double done = 0;
  int without = 0;
  for (const ViewEntry& view : capture.file.views) {
    const bool made = MakeMatte(capture,
                                view,
                                records,
                                options.photo,
                                request.force,
                                progress.Part(done / count, (done + 1) / count));
    if (made && !console.quiet)
      fmt::print("{}\n", (capture.folder / "mattes" / (view.name + ".png")).string());
    without +=
        NeedOf(capture, view, records, options.photo, false) == MatteNeed::kMissing;
    ++done;
  }
  if (without > 0) {
    throw InputError(
        fmt::format("{}: {} photos have neither matte nor trimap; put a trimap (0 no "
                    "tree, 255 tree, 128 "
                    "unknown) named like the photo into {}",
                    request.source.string(),
                    without,
                    (request.source / "trimaps").string()));
  }
  Say(console, fmt::format("{} mattes are up to date", capture.file.views.size()));
  return 0;
}

int OfPhoto(const MatteRequest& request, const ConsoleOptions& console) {
  if (!request.trimap) {
    throw OptionError("give --trimap FILE: 0 no tree, 255 tree, 128 unknown");
  }
  const CaptureOptions options = OptionsFrom({}, request.options);
  const Photo photo = ReadPhoto(request.source, options.photo);
  const Progress progress = ShowProgress(console, "matte");
  const cv::Mat1f alpha = MatteFromTrimap(photo, *request.trimap, progress.Part(0, 0.7));
  const fs::path output = request.output.value_or(
      request.source.parent_path() / (request.source.stem().string() + "_matte.png"));
  for (const fs::path& written : {output, request.foreground.value_or(fs::path())}) {
    std::error_code ignored;
    if (!written.empty() && (fs::equivalent(written, request.source, ignored) ||
                             fs::equivalent(written, *request.trimap, ignored))) {
      throw InputError(written.string() + ": is an input; give another name");
    }
  }
  if (request.foreground) {
    WriteLinear(*request.foreground,
                {{"", ForegroundOf(photo, alpha, progress.Part(0.7, 1))}});
    if (!console.quiet) fmt::print("{}\n", request.foreground->string());
  }
  WriteMatte(output, alpha);
  if (!console.quiet) fmt::print("{}\n", output.string());
  return 0;
}

}  // namespace

Verb AddMatte(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("matte", "Separate the tree from what is behind it");
  auto request = std::make_shared<MatteRequest>();
  app->add_option("source", request->source, "capture folder with trimaps/, or one photo")
      ->required()
      ->type_name("DIR|PHOTO");
  app->add_option("--trimap", request->trimap, "0 no tree, 255 tree, 128 unknown")
      ->type_name("FILE");
  app->add_option("-o,--output", request->output, "16-bit .png [PHOTO_matte.png]")
      ->type_name("FILE");
  app->add_option("--foreground",
                  request->foreground,
                  "write the tree's colours without what is behind, 32-bit linear .exr")
      ->type_name("FILE");
  app->add_flag("--force", request->force, "make mattes again that are up to date");
  AddFlags(*app, ReadPhotoOptions(), "Photo", request->options);
  return {app, [request, &console] {
            return std::filesystem::is_directory(request->source)
                       ? OfCapture(*request, console)
                       : OfPhoto(*request, console);
          }};
}

}  // namespace relight::cli
