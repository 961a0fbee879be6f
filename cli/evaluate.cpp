// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/version.h"
#include "relight/base/write_file.h"
#include "relight/capture/evaluated_hours.h"
#include "relight/composite/contact_sheet.h"
#include "relight/photo/image_file.h"
#include "relight/ratio/luminance_error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {

struct EvaluateRequest {
  std::filesystem::path result, truth;
  EvaluateOptions how;
  std::map<std::string, std::string> photo;
  std::optional<std::filesystem::path> difference, page;
  bool json = false;
};

nlohmann::json JsonOf(const RelightingScore& score) {
  nlohmann::json json = {{"pixels", score.pixels}};
  for (const auto& [name, figures] : RowsOf(score)) {
    nlohmann::json row = {{"gain", figures.gain}};
    for (const std::string& figure : FigureNames()) {
      if (const auto value = FigureOf(figures, figure)) row[figure] = *value;
    }
    json[name] = row;
  }
  return json;
}

void PrintHead(int width, const std::string& end) {
  fmt::print("{:{}}", "", width);
  for (const std::string& name : FigureNames()) fmt::print("{:>10}", name);
  fmt::print("{}\n", end);
}

void PrintRow(int width, const std::string& name, const RelightingFigures& figures) {
  fmt::print("{:{}}", name, width);
  for (const std::string& figure : FigureNames()) {
    if (const auto value = FigureOf(figures, figure)) {
      fmt::print("{:10.3f}", *value);
    } else {
      fmt::print("{:>10}", "-");
    }
  }
  fmt::print("\n");
}

void PrintRows(const RelightingScore& score) {
  constexpr int kWidth = 18;
  PrintHead(kWidth, fmt::format("   over {} pixels", score.pixels));
  for (const auto& [name, figures] : RowsOf(score)) PrintRow(kWidth, name, figures);
}

void WriteDifference(const EvaluateRequest& request,
                     const RelightingPictures& pictures,
                     const RelightingScore& score) {
  const std::filesystem::path& file = *request.difference;
  const cv::Mat1f error = LuminanceError(pictures, score, request.how.score);
  const std::string software = std::string("relight ") + Version();
  if (file.extension() == ".exr") {
    WriteLinear(file, {{"", error}}, {{"relight:software", software}});
    return;
  }
  const nlohmann::json record = {{"result", request.result.filename().string()},
                                 {"truth", request.truth.filename().string()},
                                 {"full_colour_at", kFullColorError}};
  WriteSheet(file,
             LuminanceErrorPicture(error, ScoredInside(pictures)),
             {.software = software, .json = record.dump()});
}

void RequireNoInput(const EvaluateRequest& request, const std::filesystem::path& output) {
  for (const auto& input : {std::optional(request.result),
                            std::optional(request.truth),
                            request.how.input,
                            request.how.alpha}) {
    std::error_code unused;
    if (input && std::filesystem::equivalent(*input, output, unused)) {
      throw InputError(output.string() +
                       " is an input; give the output a name of its own");
    }
  }
}

int RunOne(const EvaluateRequest& request) {
  const HourPair pair{.name = request.result.stem().string(),
                      .result = request.result,
                      .truth = request.truth};
  const RelightingPictures pictures =
      ReadRelightingPictures(request.result, request.truth, request.how);
  const RelightingScore score = ScoreRelighting(pictures, request.how.score);
  if (request.difference) WriteDifference(request, pictures, score);
  if (request.page) {
    WriteTextWhole(*request.page,
                   EvaluationPage(pair.name, {EvaluateHour(pair, request.how)}));
  }
  if (request.json) {
    fmt::print("{}\n", JsonOf(score).dump(1));
  } else {
    PrintRows(score);
  }
  return 0;
}

int RunFolders(const EvaluateRequest& request, const ConsoleOptions& console) {
  if (request.difference) {
    throw OptionError(
        "--difference belongs to one picture; of folders, -o PAGE.html shows the "
        "differences");
  }
  const HourPairs matched = MatchHours(request.result, request.truth);
  SayAll(console, matched.notes);
  std::vector<EvaluatedHour> hours;
  const Progress progress = ShowProgress(console, "hours");
  for (const HourPair& pair : matched.pairs) {
    progress.Report(double(hours.size()) / double(matched.pairs.size()));
    hours.push_back(EvaluateHour(pair, request.how));
  }
  progress.Report(1.0);
  if (request.page) {
    WriteTextWhole(*request.page,
                   EvaluationPage(request.result.filename().string() + " against " +
                                      request.truth.filename().string(),
                                  hours));
  }
  const RelightingScore mean = MeanScore(hours);
  if (request.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const EvaluatedHour& hour : hours) {
      nlohmann::json json = JsonOf(hour.score);
      json["name"] = hour.pair.name;
      json["result_file"] = hour.pair.result.string();
      json["truth_file"] = hour.pair.truth.string();
      list.push_back(json);
    }
    fmt::print("{}\n", nlohmann::json({{"hours", list}, {"mean", JsonOf(mean)}}).dump(1));
    return 0;
  }
  PrintHead(18, "");
  for (const EvaluatedHour& hour : hours) PrintRow(18, hour.pair.name, hour.score.result);
  fmt::print("\nmean of {} hours\n", hours.size());
  PrintRows(mean);
  return 0;
}

int RunVerb(const EvaluateRequest& given, const ConsoleOptions& console) {
  EvaluateRequest request = given;
  for (const auto& [name, text] : given.photo) SetField(request.how.photo, name, text);
  for (const auto& output : {request.difference, request.page}) {
    if (!output) continue;
    RequireNoInput(request, *output);
    RequirePlaceFor(*output);
  }
  if (request.page && request.page->extension() != ".html") {
    throw OptionError("-o writes a page; give a name that ends in .html, got " +
                      request.page->string());
  }
  if (request.difference) {
    const std::string end = request.difference->extension().string();
    if (end != ".png" && end != ".jpg" && end != ".exr") {
      throw OptionError("--difference writes .png, .jpg or .exr, got " +
                        request.difference->string());
    }
  }
  const bool folder = std::filesystem::is_directory(request.result);
  if (folder != std::filesystem::is_directory(request.truth)) {
    throw InputError((folder ? request.result : request.truth).string() +
                     " is a folder and " +
                     (folder ? request.truth : request.result).string() +
                     " is not; give two pictures, or two folders of hours");
  }
  return folder ? RunFolders(request, console) : RunOne(request);
}

}  // namespace

Verb AddEvaluate(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand(
      "evaluate", "Score a relit picture, or a folder of hours, against the true ones");
  auto request = std::make_shared<EvaluateRequest>();
  app->add_option("result",
                  request->result,
                  "the relit picture, or a folder of them, as relight day writes it")
      ->required()
      ->type_name("RESULT");
  app->add_option("truth",
                  request->truth,
                  "the true picture of that hour: the tree alone with alpha, or a photo "
                  "from the same place; or a folder of them, with the names of the "
                  "results or the times in their names (oak_1730.jpg)")
      ->required()
      ->type_name("TRUTH");
  app->add_option("--input",
                  request->how.input,
                  "what was relit, for the rows \"nothing\", \"histogram\", \"reinhard\" "
                  "and \"monge_kantorovich\": itself, and given the truth's colours")
      ->type_name("FILE");
  app->add_option("--alpha", request->how.alpha, "the true matte [the truth's own alpha]")
      ->type_name("FILE");
  app->add_option("--difference",
                  request->difference,
                  "write the signed error of luminance after the best gain: white is "
                  "right, red too bright, blue too dark, full colour at half of the "
                  "truth's 99th percentile; .exr has the values as shares of it")
      ->type_name("FILE");
  app->add_option("-o,--output",
                  request->page,
                  "write a page: figures as curves over the hours, pictures side by side")
      ->type_name("PAGE.html");
  app->add_option("--scale",
                  request->how.score.scale,
                  "what the input was multiplied by before relighting [1]")
      ->type_name("G");
  app->add_flag("--json", request->json, "print the figures as JSON");
  AddFlags(*app, ReadPhotoOptions(), "Photo, of truth and input", request->photo);
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
