// SPDX-License-Identifier: Apache-2.0
#include "cli/flags.h"
#include "cli/verbs.h"
#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/version.h"
#include "relight/base/write_file.h"
#include "relight/capture/light_options.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/image_file.h"
#include "relight/photo/write_photo.h"
#include "relight/sh/sky_coefficients.h"
#include "relight/sky/daylight.h"
#include "relight/sky/sky_panorama.h"
#include "relight/sky/solar_position.h"
#include "relight/sky/sun_path.h"
#include "relight/sky/sun_times.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {

struct SkyRequest {
  std::string place, taken;
  std::optional<std::string> zone;
  std::optional<std::filesystem::path> panorama, sun_path;
  bool json = false;
  std::map<std::string, std::string> options;
};

LocalTime MomentOf(const SkyRequest& request) {
  PhotoFacts nothing_known;
  nothing_known.file = "--taken";
  return ResolveCaptureTime(nothing_known, request.zone, request.taken).time;
}

// The sky as a lat-long picture: .exr as it is, .png to look at.
void WritePanorama(const std::filesystem::path& file,
                   const Daylight& daylight,
                   const std::string& words,
                   const ConsoleOptions& console) {
  const std::string software = std::string("relight ") + Version();
  const cv::Mat3f panorama = DrawPanorama(daylight);
  const std::string extension = file.extension().string();
  if (extension == ".exr") {
    WriteLinear(file,
                {{"", panorama}},
                {{"relight:software", software},
                 {"relight:sky", words},
                 {"relight:unit", "cd/m2"},
                 {"relight:heading_deg", "0"}});
    Say(console, file.string() + ": lat-long, north in the middle, cd/m2, with its sun");
    return;
  }
  const nlohmann::json made = {{"program", software}, {"sky", words}};
  WritePhoto(file, {.pixels = ToneMappedPanorama(panorama)}, {software, made.dump()});
  Say(console,
      file.string() +
          ": lat-long, north in the middle, to look at: sRGB of 1 - exp(-L / 2 m) per "
          "channel, m the mean luminance of the sky");
}

std::vector<double> Values(const Eigen::Array3d& color) {
  return {color[0], color[1], color[2]};
}

int RunVerb(const SkyRequest& request, const ConsoleOptions& console) {
  if (request.panorama && request.panorama->extension() != ".exr" &&
      request.panorama->extension() != ".png") {
    throw OptionError(request.panorama->string() +
                      ": the sky is written as .exr (light) or .png (to look at)");
  }
  const Place place = ParsePlace(request.place);
  const LocalTime time = MomentOf(request);
  LightOptions light;
  for (const auto& [name, text] : request.options) SetField(light, name, text);
  const SolarPosition sun = SolarPositionAt(time.utc, place);
  const auto day = std::chrono::floor<std::chrono::days>(WallClockOf(time));
  const SunTimes times = SunTimesOf(
      std::chrono::year_month_day(std::chrono::sys_days(day.time_since_epoch())), place);
  const auto clock = [&](const std::optional<Instant>& at) {
    return at ? FormatLocal({*at, time.offset}).substr(11, 5) : std::string("none");
  };
  const bool up = DegFromRad(sun.elevation_rad) > LowestTargetSun(light);
  nlohmann::json json = {
      {"time", FormatLocal(time)},
      {"place", {place.latitude_deg, place.longitude_deg, place.altitude_m}},
      {"sun_azimuth_deg", DegFromRad(sun.azimuth_rad)},
      {"sun_elevation_deg", DegFromRad(sun.elevation_rad)},
      {"sunrise", clock(times.sunrise)},
      {"noon", clock(times.noon)},
      {"sunset", clock(times.sunset)}};
  if (up) {
    const RunLight run = LightOfRun(light, sun.elevation_rad);
    const Daylight daylight = MakeDaylight(sun, run.target);
    json["sky"] = SkyInWords(run.target);
    json["method"] = FieldText(light.method);
    json["sun_normal_lx_rgb"] = Values(daylight.sun_irradiance);
    json["sun_horizontal_lx_rgb"] =
        Values(daylight.sun_irradiance * std::max(0.0, daylight.sun_direction.z()));
    json["sky_horizontal_lx_rgb"] = Values(HorizontalSkyIrradiance(daylight));
    for (const std::string& note : PanoramaNotes(sun, run.target)) Say(console, note);
    if (daylight.sun_direction != sun.direction.normalized()) {
      json["light_azimuth_deg"] = DegFromRad(AzimuthOf(daylight.sun_direction));
      json["light_elevation_deg"] = DegFromRad(ElevationOf(daylight.sun_direction));
    }
    if (request.panorama) {
      WritePanorama(*request.panorama, daylight, SkyInWords(run.target), console);
    }
  } else if (request.panorama) {
    throw InputError("the sun is below the horizon at " + FormatLocal(time) +
                     ", where the sky model ends; it is up from " + clock(times.sunrise) +
                     " to " + clock(times.sunset));
  }
  if (request.sun_path) {
    if (request.sun_path->extension() != ".svg") {
      throw OptionError(request.sun_path->string() + ": the diagram is written as .svg");
    }
    WriteTextWhole(*request.sun_path,
                   SunPathSvg(place,
                              std::chrono::year_month_day(
                                  std::chrono::sys_days(day.time_since_epoch())),
                              time.offset,
                              sun));
    Say(console, request.sun_path->string() + ": the sun's way, north up");
  }
  if (request.json) {
    fmt::print("{}\n", json.dump(1));
    return 0;
  }
  fmt::print("time          {}\n", FormatLocal(time));
  fmt::print(
      "sun           azimuth {:.3f} deg, elevation {:.3f} deg (true, no refraction)\n",
      DegFromRad(sun.azimuth_rad),
      DegFromRad(sun.elevation_rad));
  fmt::print(
      "day           sunrise {}, noon {}, sunset {} (centre of the sun, no refraction)\n",
      clock(times.sunrise),
      clock(times.noon),
      clock(times.sunset));
  if (!up) {
    fmt::print(
        "light         none: the sun is below the horizon, where the sky model ends\n");
    return 0;
  }
  const auto row = [&](const char* what, const char* key) {
    const auto values = json[key].get<std::vector<double>>();
    fmt::print("{:13} {:8.0f} {:8.0f} {:8.0f} lx (linear R G B)\n",
               what,
               values[0],
               values[1],
               values[2]);
  };
  fmt::print("sky           {}\n", json["sky"].get<std::string>());
  if (json.contains("light_azimuth_deg")) {
    fmt::print("its sun       azimuth {:.3f} deg, elevation {:.3f} deg\n",
               json["light_azimuth_deg"].get<double>(),
               json["light_elevation_deg"].get<double>());
  }
  row("sun, facing", "sun_normal_lx_rgb");
  row("sun, ground", "sun_horizontal_lx_rgb");
  row("sky, ground", "sky_horizontal_lx_rgb");
  return 0;
}

}  // namespace

Verb AddSky(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand("sky", "Sun and sky of a place and time");
  auto request = std::make_shared<SkyRequest>();
  app->add_option(
         "--place", request->place, "latitude and longitude, north and east positive")
      ->required()
      ->type_name("LAT,LON");
  app->add_option(
         "--taken", request->taken, "the moment: 2011-07-22T13:00, with offset or --zone")
      ->required()
      ->type_name("WHEN");
  app->add_option("--zone", request->zone, "time zone: Europe/Paris or +02:00")
      ->type_name("NAME");
  app->add_option(
         "-o,--output",
         request->panorama,
         "write the sky as a lat-long panorama, north in the middle: .exr in cd/m2 with "
         "its "
         "sun, to be read as --sky panorama:FILE; .png to look at, brightness compressed")
      ->type_name("FILE");
  app->add_option(
         "--sun-path", request->sun_path, "write the sun's way of the day as a diagram")
      ->type_name("FILE.svg");
  app->add_flag("--json", request->json, "print as JSON");
  AddFlags(*app, LightOptions(), "Light", request->options);
  return {app, [request, &console] { return RunVerb(*request, console); }};
}

}  // namespace relight::cli
