// SPDX-License-Identifier: Apache-2.0
#pragma once

// How light is modelled: the choices of `relight hour` that change the picture.

#include "relight/base/field.h"
#include "relight/base/field_text.h"
#include "relight/photo/read_photo.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/sky/daylight.h"

#include <optional>

namespace relight {

enum class Method {
  kDefault,     // Ours: Preetham's sky and sun at turbidity 3, light blurred by half a
                // voxel.
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
  std::optional<double> turbidity;  // Left out: 3 by default, 4.2 in cabral2011.
  bool sunset_correction = false;   // [Cabral11 §7.1]'s exponents; cabral2011 only.
};

template <class Visitor>
void Describe(LightOptions& o, Visitor&& field) {
  field(o.method,
        FieldInfo{"method", "", "how light is modelled: default or cabral2011"});
  field(o.turbidity,
        FieldInfo{"turbidity",
                  "",
                  "haze of the air: 2 clear, 3 usual, 6 hazy; default method",
                  Between(1.7, 10)});
  field(
      o.sunset_correction,
      FieldInfo{
          "sunset-correction", "", "a low sun fades faster [Cabral11, 7.1]; cabral2011"});
}

// Throws OptionError for what does not go together (a turbidity with cabral2011).
inline DaylightOptions DaylightOf(const LightOptions& options) {
  CheckFields(options);
  if (options.method == Method::kCabral2011 && options.turbidity &&
      *options.turbidity != 4.2) {
    throw OptionError(
        "cabral2011 has turbidity 4.2; leave --turbidity out, or the method");
  }
  if (options.method != Method::kCabral2011 && options.sunset_correction) {
    throw OptionError("sunset-correction belongs to --method cabral2011");
  }
  return {.model = options.method == Method::kCabral2011 ? SkyModel::kCabral2011
                                                         : SkyModel::kPreetham,
          .turbidity = options.turbidity,
          .sunset_correction = options.sunset_correction};
}

}  // namespace relight
