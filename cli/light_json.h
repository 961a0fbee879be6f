// SPDX-License-Identifier: Apache-2.0
#pragma once

// A light of a run as --json prints it.

#include "relight/base/angles.h"
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

}  // namespace relight::cli
