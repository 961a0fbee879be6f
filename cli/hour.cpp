// SPDX-License-Identifier: Apache-2.0
#include "cli/console.h"
#include "cli/light_json.h"
#include "cli/verbs.h"
#include "cli/view_options.h"
#include "relight/base/error.h"
#include "relight/capture/relit_hour.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>

namespace relight::cli {
namespace {

int RunVerb(const HourRequest& request, bool json, const ConsoleOptions& console) {
  const HourPlan plan = PlanHour(request);
  SayAll(console, plan.notes);
  const HourResult result = RunHour(plan, ShowStages(console, plan.view.stages));
  Say(console,
      "photo: " + plan.view.input.words + ". Wanted: " + plan.target.words + ".");
  SayAll(console, result.notes);
  Say(console,
      fmt::format("the tree is {:.2f} times as bright as in the photo{}",
                  result.mean_ratio,
                  result.exposure_ev == 0
                      ? std::string()
                      : fmt::format(", exposed by {:+.2f} EV", result.exposure_ev)));
  if (!json) {
    if (console.quiet) return 0;
    for (const auto& file : result.files) fmt::print("{}\n", file.string());
    return 0;
  }
  nlohmann::json files = nlohmann::json::array();
  for (const auto& file : result.files) files.push_back(file.string());
  std::vector<std::string> notes = plan.notes;
  notes.insert(notes.end(), result.notes.begin(), result.notes.end());
  nlohmann::json fit;  // null without --fit-light
  if (result.fit) {
    const auto number = [](const FittedNumber& n) {
      return nlohmann::json{{"times", std::exp(n.log_value)},
                            {"log_deviation", n.deviation},
                            {"flat", n.flat}};
    };
    fit = {{"sky", number(result.fit->sky)},
           {"density", number(result.fit->density)},
           {"log_spread", result.fit->spread},
           {"log_spread_unfitted", result.fit->unfitted}};
  }
  nlohmann::json stages = nlohmann::json::array();
  for (const PlannedStage& stage : plan.view.stages) stages.push_back(stage.name);
  fmt::print("{}\n",
             nlohmann::json({{"files", files},
                             {"view", plan.view.name},
                             {"heading_deg", plan.view.heading_deg},
                             {"input", LightJson(plan.view.input)},
                             {"target", LightJson(plan.target)},
                             {"sky", SkiesJson(result.light, plan.view.options.light)},
                             {"fit", fit},
                             {"stages", stages},
                             {"mean_ratio", result.mean_ratio},
                             {"weak_share", result.weak_share},
                             {"exposure_ev", result.exposure_ev},
                             {"clipped_in", result.clipped_in},
                             {"clipped_out", result.clipped_out},
                             {"notes", notes}})
                 .dump(1));
  return 0;
}

}  // namespace

Verb AddHour(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("hour", "Relight a photo to another hour (the main job)");
  auto request = std::make_shared<HourRequest>();
  auto json = std::make_shared<bool>(false);
  HourRequest& r = *request;
  AddViewOptions(*app, r);

  const char* wanted = "Wanted light";
  app->add_option(
         "--to",
         r.to,
         "the hour: 17:00, 2011-09-23T17:00, with an offset (…+02:00), +3h, same")
      ->type_name("WHEN")
      ->group(wanted);
  app->add_option(
         "--to-light",
         r.to_light,
         "the sun as the camera sees it: 0 straight ahead, 90 from the right, 180 behind")
      ->type_name("AZ,EL")
      ->group(wanted);
  app->add_option(
         "--like", r.like, "hour and place of this photo, light as its camera sees it")
      ->type_name("PHOTO")
      ->group(wanted);
  app->add_option(
         "--exposure", r.exposure, "same (evening is dark), auto, or stops [same]")
      ->type_name("same|auto|EV")
      ->group(wanted);

  const char* output = "Output";
  app->add_option(
         "-o,--output",
         r.output,
         ".exr .png .tif .jpg, or .ora with the tree and its shadow as layers; left out: "
         "PHOTO_1700.png beside the photo, or in DIR/out")
      ->type_name("FILE")
      ->group(output);
  app->add_flag(
         "--whole", r.whole, "the whole photo with the tree relit (always for .jpg)")
      ->group(output);
  app->add_flag("--keep-shadow",
                r.keep_shadow,
                "with --whole: leave the ground as taken, with its old shadow")
      ->group(output);
  app->add_option(
         "--over", r.over, "put tree and shadow on this photo of the same size, flat")
      ->type_name("PHOTO")
      ->group(output);
  app->add_option("--shadow",
                  r.shadow,
                  "write the tree's shadow on the ground, to multiply with; linear in "
                  ".exr, else sRGB")
      ->type_name("FILE")
      ->group(output);
  app->add_option("--quality", r.quality, "of a .jpg, 1 to 100 [95]")
      ->type_name("N")
      ->check(CLI::Range(1, 100).description(""))
      ->group(output);
  app->add_option(
         "--irradiance", r.irradiance, "write the light of both hours, 32-bit .exr [lx]")
      ->type_name("FILE")
      ->group(output);
  app->add_option("--ratio", r.ratio, "write the ratio of the two, 32-bit .exr")
      ->type_name("FILE")
      ->group(output);
  app->add_flag("--components",
                r.components,
                "with --irradiance: sun, sky and indirect light too")
      ->group(output);
  app->add_option("--confidence",
                  r.confidence,
                  "write how sure each pixel is, from 0 to 1: 16-bit grey .png; an .exr "
                  "result has it as a channel")
      ->type_name("FILE")
      ->group(output);
  app->add_option("--correction-features",
                  r.correction_features,
                  "write what the learned correction reads, a layer a feature, .exr")
      ->type_name("FILE")
      ->group(output);
  app->add_flag("--force", r.force, "make every stage again")->group(output);
  app->add_flag("--json", *json, "print the result as JSON")->group(output);

  AddModelOptions(*app, r);
  return {app, [request, json, &console] { return RunVerb(*request, *json, console); }};
}

}  // namespace relight::cli
