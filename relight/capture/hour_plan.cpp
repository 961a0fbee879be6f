// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/hour_plan.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/field_text.h"
#include "relight/base/write_file.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/true_heading.h"
#include "relight/photo/write_photo.h"
#include "relight/sky/light_in_words.h"

#include <algorithm>

namespace relight {
namespace fs = std::filesystem;
namespace {

std::string DefaultOutputName(const HourPlan& plan) {
  std::string name = plan.view.name;
  if (!plan.target.time) return name + "_relit.png";
  const std::string target = FormatLocal(*plan.target.time);
  const bool other_day =
      plan.view.input.time &&
      FormatLocal(*plan.view.input.time).substr(0, 10) != target.substr(0, 10);
  if (other_day) name += "_" + target.substr(0, 10);
  return name + "_" + target.substr(11, 2) + target.substr(14, 2) + ".png";
}

void CheckOutputs(const HourPlan& plan) {
  const HourRequest& r = plan.request;
  std::vector<fs::path> inputs = InputsOf(plan.view);
  for (const auto& given : {r.like, r.over}) {
    if (given) inputs.push_back(*given);
  }
  std::vector<fs::path> outputs = {plan.output};
  for (const auto& linear : {r.irradiance, r.ratio, r.correction_features}) {
    if (!linear) continue;
    if (linear->extension() != ".exr") {
      throw OptionError(linear->string() +
                        ": light, ratio and features are written as .exr");
    }
    outputs.push_back(*linear);
  }
  if (r.shadow) outputs.push_back(*r.shadow);
  if (r.confidence) outputs.push_back(*r.confidence);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    RequireNoInput(outputs[i], inputs);
    if (i > 0 || r.output) RequirePlaceFor(outputs[i]);
    if (std::find(outputs.begin(),
                  outputs.begin() + static_cast<std::ptrdiff_t>(i),
                  outputs[i]) != outputs.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw OptionError(outputs[i].string() + ": is named for two outputs");
    }
  }
  const auto require_format = [](const fs::path& file, std::vector<std::string> known) {
    if (std::find(known.begin(), known.end(), file.extension()) != known.end()) return;
    std::string list;
    for (const std::string& e : known) list += (list.empty() ? "" : " ") + e;
    throw OptionError(file.string() + ": the format is told by the extension, one of " +
                      list);
  };
  std::vector<std::string> formats = WritableExtensions();
  if (r.shadow) require_format(*r.shadow, formats);
  if (r.confidence) require_format(*r.confidence, {".png"});
  formats.emplace_back(kLayers);
  require_format(plan.output, formats);
  if (r.whole && r.over) {
    throw OptionError(
        "--whole is the tree on its own photo, --over on another; give one of them");
  }
  if (r.whole && plan.output.extension() == kLayers) {
    throw OptionError(plan.output.string() +
                      ": holds the tree and its shadow as layers; leave --whole out, or "
                      "put the photo below them with --over");
  }
}

void RequireOneLight(const HourRequest& r) {
  const int given = (r.to ? 1 : 0) + (r.to_light ? 1 : 0) + (r.like ? 1 : 0);
  if (given == 1) return;
  throw OptionError(
      given == 0 ? "give the hour that is wanted: --to 17:00, --to-light AZ,EL or --like "
                   "PHOTO"
                 : "--to, --to-light and --like each say the light that is wanted; give "
                   "one of them");
}

// What the user said of the wanted light and the output.
CommandWords WordsOf(const HourRequest& r) {
  CommandWords said{"hour", {}};
  said.Add("--to", r.to);
  said.Add("--like", r.like);
  said.Add("--to-light", r.to_light);
  if (r.exposure != "same") said.Add("--exposure", std::optional(r.exposure));
  if (r.whole) said.Add("--whole");
  if (r.keep_shadow) said.Add("--keep-shadow");
  if (r.quality != HourRequest().quality)
    said.Add("--quality", std::optional(FieldText(r.quality)));
  said.Add("--irradiance", r.irradiance);
  if (r.components) said.Add("--components");
  said.Add("--ratio", r.ratio);
  said.Add("--confidence", r.confidence);
  said.Add("--correction-features", r.correction_features);
  said.Add("--shadow", r.shadow);
  said.Add("--over", r.over);
  said.Add("-o", r.output);
  return said;
}

// The hour of a backdrop, with the sun as its camera sees it.
HourLight LightLike(const fs::path& file,
                    const ViewPlan& view,
                    Place& place,
                    std::vector<std::string>& notes) {
  const PhotoFacts like = ReadPhotoFacts(file);
  if (!like.local_time && !like.gps_time) {
    throw InputError(
        file.string() +
        ": no capture time in EXIF, so the light of its hour is not known; give the hour "
        "with --to WHEN in place of --like");
  }
  HourLight light;
  const CaptureTime taken = ResolveCaptureTime(like, view.request.zone);
  light.time = taken.time;
  if (const auto doubt = ZoneAgainstGps(like, taken.zone)) notes.push_back(*doubt);
  if (like.place) {
    place = *like.place;
  } else if (view.place) {
    notes.push_back(file.string() + " has no place; the photo's own is taken");
  } else {
    throw InputError(file.string() + ": no place in EXIF; give --place LAT,LON");
  }
  light.sun = SolarPositionAt(light.time->utc, place);
  if (!like.heading_deg) {
    notes.push_back(file.string() +
                    " has no heading; taken to look the same way as the photo");
    return light;
  }
  double heading_deg = *like.heading_deg;
  if (like.heading_is_magnetic) {
    heading_deg = TrueFromMagnetic(heading_deg, place, light.time->utc).heading_deg;
  }
  light.sun = SunAt(light.sun.azimuth_rad + RadFromDeg(view.heading_deg - heading_deg),
                    light.sun.elevation_rad);
  return light;
}

}  // namespace

HourLight PlanTarget(const HourRequest& request,
                     const ViewPlan& view,
                     std::vector<std::string>& notes) {
  RequireOneLight(request);
  HourLight target;
  Place place = view.place.value_or(Place{});
  if (request.to_light) {
    target.sun = ParseLight(*request.to_light, "--to-light", view.heading_deg);
  } else if (request.like) {
    target = LightLike(*request.like, view, place, notes);
  } else {
    try {
      target.time = ParseWhen(*request.to, view.input.time.value(), view.zone);
    } catch (const OptionError& error) {
      throw OptionError(std::string("--to: ") + error.what());
    }
    target.sun = SolarPositionAt(target.time->utc, place);
  }
  RequireSunUp(target,
               "wanted",
               place,
               LowestTargetSun(view.options.light),
               "choose an hour of daylight with --to");
  target.words = LightInFewWords(target.sun.azimuth_rad - RadFromDeg(view.heading_deg),
                                 target.sun.elevation_rad);
  return target;
}

HourPlan PlanHour(const HourRequest& request) {
  HourPlan plan;
  plan.request = request;
  RequireExposure(request.exposure);
  RequireOneLight(request);
  plan.view = PlanView(request, request.to.has_value(), WordsOf(request));
  constexpr double kSecondsPerMegapixel = 0.6;
  plan.view.stages.push_back({"relight",
                              "light of both hours and their ratio",
                              0.3 + kSecondsPerMegapixel * plan.view.megapixels});
  plan.notes = plan.view.notes;
  plan.target = PlanTarget(request, plan.view, plan.notes);

  // Where to
  plan.output = request.output.value_or(
      fs::is_directory(request.source)
          ? request.source / "out" / DefaultOutputName(plan)
          : plan.view.photo.parent_path() / DefaultOutputName(plan));
  if (!request.over &&
      (plan.output.extension() == ".jpg" || plan.output.extension() == ".jpeg")) {
    plan.request.whole = true;
  }
  CheckOutputs(plan);
  return plan;
}

}  // namespace relight
