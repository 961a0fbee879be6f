// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/light_options.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace relight {
namespace {

// What the photo's sky is when the user does not say.
SkyChoice InputSkyOf(const LightOptions& options) {
  if (!options.input_sky.empty()) return ParseSky(options.input_sky, "input-sky");
  const SkyChoice wanted = ParseSky(options.sky, "sky");
  return wanted.IsClear() ? wanted : SkyChoice();
}

double LowestSun(const SkyChoice& choice) {
  return LowestSunOf(choice.model.value_or(SkyModel::kAtmosphere));
}

// Two skies may be one file.
std::shared_ptr<const Panorama> PanoramaOf(const SkyChoice& choice,
                                           const std::shared_ptr<const Panorama>& other) {
  if (choice.model != SkyModel::kPanorama) return nullptr;
  if (other && other->file == choice.panorama) return other;
  return std::make_shared<const Panorama>(ReadPanorama(choice.panorama));
}

bool Same(const DaylightOptions& a, const DaylightOptions& b) {
  return a.model == b.model && a.cloud == b.cloud &&
         (a.model != SkyModel::kCie || a.cie_type == b.cie_type) &&
         (a.model != SkyModel::kPanorama || a.panorama->hash == b.panorama->hash);
}

}  // namespace

SkyChoice ParseSky(const std::string& text, const char* option) {
  const std::string_view view = text;
  if (view == "auto") return {};
  if (view == "preetham") return {.model = SkyModel::kPreetham};
  if (view == "atmosphere") return {.model = SkyModel::kAtmosphere};
  if (view == "overcast") return {.model = SkyModel::kCie};
  if (view.starts_with("cie:")) {
    const std::string_view number = view.substr(4);
    int type = 0;
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), type);
    if (error == std::errc() && end == number.data() + number.size() && type >= 1 &&
        type <= 15) {
      return {.model = SkyModel::kCie, .cie_type = type};
    }
  }
  constexpr std::string_view kPanorama = "panorama:";
  if (view.starts_with(kPanorama) && view.size() > kPanorama.size()) {
    return {.model = SkyModel::kPanorama, .panorama = text.substr(kPanorama.size())};
  }
  throw OptionError(std::string(option) +
                    " must be auto, preetham, atmosphere, overcast, cie:1 to cie:15 or "
                    "panorama:FILE, got \"" +
                    text + "\"");
}

std::string SkyInWords(const DaylightOptions& sky) {
  std::string words = sky.model == SkyModel::kPreetham     ? "preetham"
                      : sky.model == SkyModel::kCabral2011 ? "cabral2011"
                      : sky.model == SkyModel::kAtmosphere ? "atmosphere"
                      : sky.model == SkyModel::kPanorama
                          ? "panorama:" + sky.panorama->file.filename().string()
                          : "cie:" + std::to_string(sky.cie_type);
  if (sky.cloud > 0) words += " under " + FieldText(sky.cloud) + " of clouds";
  return words;
}

double LowestInputSun(const LightOptions& options) {
  if (options.method == Method::kCabral2011) return LowestSunOf(SkyModel::kCabral2011);
  return LowestSun(InputSkyOf(options));
}

double LowestTargetSun(const LightOptions& options) {
  if (options.method == Method::kCabral2011) return LowestSunOf(SkyModel::kCabral2011);
  return LowestSun(ParseSky(options.sky, "sky"));
}

RunLight LightOfRun(const LightOptions& options,
                    double lowest_sun_rad,
                    bool with_bounce) {
  CheckFields(options);
  const SkyChoice wanted = ParseSky(options.sky, "sky"), input = InputSkyOf(options);
  RunLight light;
  if (options.method == Method::kCabral2011) {
    if (options.turbidity && *options.turbidity != 4.2) {
      throw OptionError(
          "cabral2011 has turbidity 4.2; leave --turbidity out, or the method");
    }
    if (wanted.model || input.model || options.cloud > 0 || options.ground_albedo ||
        options.panorama_heading_deg || options.panorama_scale) {
      throw OptionError(
          "cabral2011 has a sky of its own; leave --sky, --input-sky, --cloud, "
          "--ground-albedo and the panorama's options out, or the method");
    }
    light.input = light.target = {.model = SkyModel::kCabral2011,
                                  .turbidity = options.turbidity,
                                  .sunset_correction = options.sunset_correction};
    return light;
  }
  if (options.sunset_correction) {
    throw OptionError("sunset-correction belongs to --method cabral2011");
  }
  if (options.cloud > 0 && !wanted.IsClear()) {
    throw OptionError("--cloud covers a clear sky; leave it out with --sky " +
                      options.sky);
  }
  const auto has = [&](SkyModel model) {
    return wanted.model == model || input.model == model;
  };
  if (!has(SkyModel::kPanorama) &&
      (options.panorama_heading_deg || options.panorama_scale)) {
    throw OptionError(
        "--panorama-heading and --panorama-scale belong to a panorama; leave them out, "
        "or give one as --sky panorama:FILE");
  }
  const bool may_be_atmosphere =
      has(SkyModel::kAtmosphere) ||
      ((wanted.IsClear() && !wanted.model) || (input.IsClear() && !input.model));
  if (options.ground_albedo && !may_be_atmosphere && !with_bounce) {
    throw OptionError(
        "--ground-albedo belongs to the sky atmosphere and to --bounce; leave it out, or "
        "give --sky atmosphere");
  }
  // One clear model for all that leave it open
  const bool low = lowest_sun_rad <= 0;  // No other clear sky has a twilight
  SkyModel clear = low ? SkyModel::kAtmosphere : SkyModel::kPreetham;
  bool chosen = wanted.IsClear() || input.IsClear();
  for (const SkyChoice& choice : {input, wanted}) {
    if (!choice.IsClear() || !choice.model) continue;
    clear = *choice.model;
    chosen = false;
  }
  const auto options_of = [&](const SkyChoice& choice, double cloud) {
    DaylightOptions sky{.model = choice.model.value_or(clear),
                        .turbidity = options.turbidity,
                        .cie_type = choice.cie_type,
                        .cloud = cloud};
    if (sky.model == SkyModel::kAtmosphere) sky.ground_albedo = options.ground_albedo;
    if (sky.model == SkyModel::kPanorama) {
      sky.panorama = PanoramaOf(choice, light.input.panorama);
      sky.panorama_heading_deg = options.panorama_heading_deg;
      sky.panorama_scale = options.panorama_scale;
    }
    return sky;
  };
  light.input = options_of(input, 0.0);
  light.target = options_of(wanted, options.cloud);
  light.one_sky = Same(light.input, light.target);
  if (chosen && low) {
    light.notes.push_back(
        "the sun is below the horizon at an hour: the sky is the model atmosphere for "
        "all, "
        "and the ratio is the simulation's alone");
  }
  if (options.ground_albedo && !with_bounce &&
      light.input.model != SkyModel::kAtmosphere &&
      light.target.model != SkyModel::kAtmosphere) {
    light.notes.push_back("--ground-albedo is not used: the sky is " +
                          SkyInWords(light.target) +
                          ", and only atmosphere knows the ground (--sky atmosphere)");
  }
  // Skies of one level: docs/skies.md
  const auto kind = [](const DaylightOptions& of) {
    const bool absolute =
        of.model == SkyModel::kPanorama && (of.panorama_scale || of.panorama->absolute);
    return of.model == SkyModel::kAtmosphere ? 1 : absolute ? 2 : 0;
  };
  if (kind(light.input) != kind(light.target)) {
    light.notes.push_back(
        "the skies of photo and wanted hour are not of one level: brightness may be far "
        "off, and --exposure mends it (docs/skies.md has the pairs that go together)");
  } else if (!light.one_sky) {
    light.notes.push_back(
        "the weather changes: the wanted hour's sky is another than the "
        "photo's");
  }
  return light;
}

}  // namespace relight
