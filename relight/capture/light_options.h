// SPDX-License-Identifier: Apache-2.0
#pragma once

// How light is modelled: the choices of `relight hour` that change the picture.

#include "relight/base/field.h"
#include "relight/base/field_text.h"
#include "relight/photo/read_photo.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/sky/daylight.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

enum class Method {
  kDefault,     // Ours: turbidity by the photos' sky, light blurred by half a voxel.
  kCabral2011,  // The paper as a whole, the baseline (docs/method.md).
};
inline constexpr EnumWord<Method> kMethodWords[] = {{"default", Method::kDefault},
                                                    {"cabral2011", Method::kCabral2011}};
inline std::span<const EnumWord<Method>> EnumWords(Method) { return kMethodWords; }

inline constexpr EnumWord<Tone> kToneWords[] = {{"srgb", Tone::kSrgb},
                                                {"camera", Tone::kCamera}};
inline std::span<const EnumWord<Tone>> EnumWords(Tone) { return kToneWords; }

struct LightOptions {
  Method method = Method::kDefault;
  std::string sky = "auto";    // As ParseSky reads it; of the wanted hour.
  std::string input_sky = {};  // Of the photo; left out: see InputSkyOf.
  double cloud = 0.0;          // Share of the wanted hour's sky; clear skies only.
  std::optional<double> turbidity = {};  // Left out: by the photos' sky, else 3.
  bool sunset_correction = false;        // [Cabral11 §7.1]'s exponents; cabral2011 only.
  std::optional<double> ground_albedo = {};         // Of an atmosphere.
  std::optional<double> panorama_heading_deg = {};  // Of panoramas, as daylight.h has it.
  std::optional<double> panorama_scale = {};
};

template <class Visitor>
void Describe(LightOptions& o, Visitor&& field) {
  field(o.method,
        FieldInfo{"method", "", "how light is modelled: default or cabral2011"});
  field(o.sky,
        FieldInfo{"sky",
                  "",
                  "wanted: auto, preetham, atmosphere, overcast, cie:1 to cie:15, or "
                  "panorama:FILE, a lat-long .exr or .hdr"});
  field(o.input_sky,
        FieldInfo{"input-sky",
                  "",
                  "of the photo; left out, as --sky if that is clear, else auto"});
  field(o.cloud,
        FieldInfo{"cloud", "", "share of the wanted sky under clouds", Between(0, 1)});
  field(o.turbidity,
        FieldInfo{"turbidity",
                  "",
                  "haze of the air: 2 clear, 6 hazy; left out, by the photos",
                  Between(1.7, 10)});
  field(
      o.sunset_correction,
      FieldInfo{
          "sunset-correction", "", "a low sun fades faster [Cabral11, 7.1]; cabral2011"});
  field(o.ground_albedo,
        FieldInfo{"ground-albedo",
                  "",
                  "light that the ground reflects, into the sky atmosphere and with "
                  "--bounce into the tree; left out, 0.2",
                  Between(0, 1)});
  field(o.panorama_heading_deg,
        FieldInfo{"panorama-heading",
                  "deg",
                  "azimuth of a panorama's middle from true north; left out, as its sun "
                  "tells",
                  Between(-360, 360)});
  field(o.panorama_scale,
        FieldInfo{"panorama-scale",
                  "cd/m2",
                  "luminance of a panorama's value of 1; left out, the level of the day",
                  Above(0)});
}

// A sky by its word. `model` unset: auto.
struct SkyChoice {
  std::optional<SkyModel> model;
  int cie_type = kCieOvercast;
  std::filesystem::path panorama = {};
  bool IsClear() const { return model != SkyModel::kCie && model != SkyModel::kPanorama; }
};

// Throws OptionError that names the `option` and what it may be.
SkyChoice ParseSky(const std::string& text, const char* option);

// A run's light, sky by sky. Where both are auto, or auto and a clear one, they are one
// model.
struct RunLight {
  DaylightOptions input, target;
  bool one_sky = true;             // They are the same: a same hour changes nothing.
  std::vector<std::string> notes;  // What was chosen, and what a user should know of it.
};

// `lowest_sun_rad` of the input and all targets: at 0 or below `auto` is atmosphere,
// else preetham. Panoramas are read. Throws OptionError for what does not go together (a
// turbidity or a sky with cabral2011, clouds over an overcast sky), InputError as
// ReadPanorama does. `with_bounce`: the ground's albedo is used whatever the sky.
RunLight LightOfRun(const LightOptions& options,
                    double lowest_sun_rad,
                    bool with_bounce = false);

// "preetham", "cie:3", "atmosphere under 0.4 of clouds", "panorama:noon.hdr".
std::string SkyInWords(const DaylightOptions& sky);

// The elevation [deg] that the sun must be above at the photo's and at a wanted hour.
double LowestInputSun(const LightOptions& options);
double LowestTargetSun(const LightOptions& options);

}  // namespace relight
