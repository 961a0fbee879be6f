// SPDX-License-Identifier: Apache-2.0
#pragma once

// A light of a run as --json prints it.

#include "relight/base/angles.h"
#include "relight/capture/light_options.h"
#include "relight/capture/view_plan.h"

#include <nlohmann/json.hpp>

namespace relight::cli {

inline nlohmann::json LightJson(const HourLight& light) {
  nlohmann::json json = {{"azimuth_deg", DegFromRad(light.sun.azimuth_rad)},
                         {"elevation_deg", DegFromRad(light.sun.elevation_rad)},
                         {"words", light.words}};
  if (light.time) json["time"] = FormatLocal(*light.time);
  return json;
}

// The skies that a run took, and its turbidity: of the option, of the photos, or usual.
inline nlohmann::json SkiesJson(const RunLight& light, const LightOptions& options) {
  const bool cabral2011 = options.method == Method::kCabral2011;
  const char* from = cabral2011               ? "method"
                     : options.turbidity      ? "option"
                     : light.target.turbidity ? "photos"
                                              : "usual";
  return {
      {"input", SkyInWords(light.input)},
      {"target", SkyInWords(light.target)},
      {"turbidity", cabral2011 ? 4.2 : light.target.turbidity.value_or(kUsualTurbidity)},
      {"turbidity_from", from}};
}

}  // namespace relight::cli
