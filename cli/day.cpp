// SPDX-License-Identifier: Apache-2.0
#include "cli/console.h"
#include "cli/light_json.h"
#include "cli/verbs.h"
#include "cli/view_options.h"
#include "relight/capture/relit_day.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace relight::cli {
namespace {

nlohmann::json FrameJson(const DayFrame& frame) {
  nlohmann::json json = LightJson(frame.light);
  json["name"] = frame.name;
  return json;
}

int RunVerb(const DayRequest& request, bool json, const ConsoleOptions& console) {
  const DayPlan plan = PlanDay(request);
  SayAll(console, plan.notes);
  const DayResult result = RunDay(plan, ShowStages(console, plan.view.stages));
  SayAll(console, result.notes);
  Say(console,
      fmt::format("{} frames made{}{}",
                  result.made,
                  result.kept > 0 ? fmt::format(", {} were there already", result.kept)
                                  : std::string(),
                  result.exposure_ev == 0
                      ? std::string()
                      : fmt::format(", all exposed by {:+.2f} EV", result.exposure_ev)));
  std::vector<std::string> files;
  for (const auto& frame : result.frames) files.push_back(frame.string());
  for (const auto& file : {result.sun_table, result.contact_sheet, result.page}) {
    files.push_back(file.string());
  }
  if (result.video) files.push_back(result.video->string());
  if (!json) {
    if (console.quiet) return 0;
    for (const std::string& file : files) fmt::print("{}\n", file);
    return 0;
  }
  nlohmann::json frames = nlohmann::json::array(), left_out = nlohmann::json::array();
  for (const DayFrame& frame : plan.frames) frames.push_back(FrameJson(frame));
  for (const DayFrame& frame : plan.left_out) left_out.push_back(FrameJson(frame));
  std::vector<std::string> notes = plan.notes;
  notes.insert(notes.end(), result.notes.begin(), result.notes.end());
  fmt::print("{}\n",
             nlohmann::json({{"folder", plan.folder.string()},
                             {"sky", SkiesJson(result.light, plan.view.options.light)},
                             {"view", plan.view.name},
                             {"heading_deg", plan.view.heading_deg},
                             {"files", files},
                             {"frames", frames},
                             {"left_out", left_out},
                             {"made", result.made},
                             {"kept", result.kept},
                             {"exposure_ev", result.exposure_ev},
                             {"notes", notes}})
                 .dump(1));
  return 0;
}

}  // namespace

Verb AddDay(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand(
      "day", "A sequence of frames over a day, with page and video");
  auto request = std::make_shared<DayRequest>();
  auto json = std::make_shared<bool>(false);
  DayRequest& r = *request;
  AddViewOptions(*app, r);

  const char* wanted = "Frames";
  app->add_option("--dates", r.dates, "days as 2011-07-22, with commas [the photo's own]")
      ->type_name("DATES")
      ->group(wanted);
  app->add_option(
         "--hours", r.hours, "first and last: 9..18, 9:30..sunset [sunrise..sunset]")
      ->type_name("FIRST..LAST")
      ->group(wanted);
  app->add_option("--every", r.every, "time between frames: 15m, 1h, 1h30m [30m]")
      ->type_name("TIME")
      ->group(wanted);
  app->add_option("--exposure",
                  r.exposure,
                  "one for all: same (evening is dark), auto (the brightest frame as "
                  "bright as the photo), or stops [same]")
      ->type_name("same|auto|EV")
      ->group(wanted);
  app->add_option("--over", r.over, "a backdrop of the same size in place of the photo")
      ->type_name("PHOTO")
      ->group(wanted);
  app->add_flag("--alone", r.alone, "tree and shadow alone, on transparency")
      ->group(wanted);

  const char* output = "Output";
  app->add_option(
         "-o,--output",
         r.output,
         "folder of the frames; left out: VIEW_day beside the photo, or in DIR/out")
      ->type_name("FOLDER")
      ->group(output);
  app->add_option("--format", r.format, "of the frames [png]")
      ->type_name("png|exr")
      ->group(output);
  app->add_flag("--force", r.force, "make every stage and every frame again")
      ->group(output);
  app->add_flag("--json", *json, "print the result as JSON")->group(output);
  AddModelOptions(*app, r);
  return {app, [request, json, &console] { return RunVerb(*request, *json, console); }};
}

}  // namespace relight::cli
