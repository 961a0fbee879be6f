// SPDX-License-Identifier: Apache-2.0
#pragma once

// One photo relit to another hour: what `relight hour` and the plug-in run. Makes the
// stages that are not up to date, and writes.

#include "relight/capture/hour_plan.h"
#include "relight/capture/light_options.h"
#include "relight/capture/prepared_view.h"
#include "relight/photo/write_photo.h"
#include "relight/ratio/light_fit.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

struct HourResult {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> notes;  // What a user should know of the result.
  RunLight light;                  // Of both hours.
  std::optional<LightFit> fit;     // With --fit-light.
  double mean_ratio = 0.0;         // Luminance, inside the matte.
  double weak_share = 0.0;         // Of the matte: rays that meet no volume.
  double exposure_ev = 0.0;        // Applied.
  std::int64_t clipped_in = 0;     // Pixels of the tree at the photo's limit.
  std::int64_t clipped_out = 0;    // Cut by the output's format.
};

// Throws InputError, Cancelled; then no output is written.
HourResult RunHour(const HourPlan& plan, const StageStart& start = {});

}  // namespace relight
