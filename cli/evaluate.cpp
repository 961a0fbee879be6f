// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"
#include "relight/ratio/relighting_score.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <memory>

namespace relight::cli {
namespace {

struct EvaluateRequest {
  std::filesystem::path result, truth, input, alpha;
  double scale = 1.0;
  bool json = false;
};

ScoredPicture Load(const std::filesystem::path& file) {
  const Photo photo = ReadPhoto(file);
  return {photo.pixels, photo.alpha};
}

nlohmann::json Row(const RelightingFigures& f) {
  nlohmann::json row = {{"psnr_low", f.psnr_low},
                        {"corr_low", f.corr_low},
                        {"contrast", f.contrast},
                        {"corr_high", f.corr_high},
                        {"level", f.level},
                        {"colour", f.colour},
                        {"psnr", f.psnr},
                        {"ssim", f.ssim},
                        {"gain", f.gain}};
  if (f.ring) row["ring"] = *f.ring;
  return row;
}

int RunVerb(const EvaluateRequest& request) {
  const RelightingScore score = ScoreRelighting({.result = Load(request.result),
                                                 .truth = Load(request.truth),
                                                 .source = Load(request.input),
                                                 .matte = ReadMatte(request.alpha)},
                                                {.scale = request.scale});
  if (request.json) {
    fmt::print("{}\n",
               nlohmann::json({{"result", Row(score.result)},
                               {"nothing", Row(score.nothing)},
                               {"histogram", Row(score.histogram)},
                               {"pixels", score.pixels}})
                   .dump(1));
    return 0;
  }
  constexpr std::array kNames = {"psnr_low",
                                 "corr_low",
                                 "contrast",
                                 "corr_high",
                                 "level",
                                 "colour",
                                 "ring",
                                 "psnr",
                                 "ssim"};
  fmt::print("{:10}", "");
  for (const char* name : kNames) fmt::print("{:>10}", name);
  fmt::print("   over {} pixels\n", score.pixels);
  const auto print = [&](const char* name, const RelightingFigures& figures) {
    const nlohmann::json row = Row(figures);
    fmt::print("{:10}", name);
    for (const char* figure : kNames) {
      if (row.contains(figure)) {
        fmt::print("{:10.3f}", row[figure].get<double>());
      } else {
        fmt::print("{:>10}", "-");
      }
    }
    fmt::print("\n");
  };
  print("result", score.result);
  print("nothing", score.nothing);
  print("histogram", score.histogram);
  return 0;
}

}  // namespace

Verb AddEvaluate(CLI::App& program, const ConsoleOptions&) {
  CLI::App* app = program.add_subcommand(
      "evaluate", "Score a relit picture against the true one of that hour");
  auto request = std::make_shared<EvaluateRequest>();
  app->add_option("result", request->result, "the relit picture")
      ->required()
      ->type_name("RESULT");
  app->add_option("truth", request->truth, "the tree alone at that hour, with alpha")
      ->required()
      ->type_name("TRUTH");
  app->add_option("--input",
                  request->input,
                  "what was relit, for the rows \"nothing\" and \"histogram\"")
      ->required()
      ->type_name("FILE");
  app->add_option("--alpha", request->alpha, "the true matte")
      ->required()
      ->type_name("FILE");
  app->add_option("--scale",
                  request->scale,
                  "what the input was multiplied by before relighting [1]")
      ->type_name("G");
  app->add_flag("--json", request->json, "print the figures as JSON");
  return {app, [request] { return RunVerb(*request); }};
}

}  // namespace relight::cli
