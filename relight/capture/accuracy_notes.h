// SPDX-License-Identifier: Apache-2.0
#pragma once

// What makes a result less exact here, in words, each with what it cost where that could
// be measured: docs/capture.md#costs and docs/validation.md.

#include "relight/ratio/correction.h"
#include "relight/sky/sky_turbidity.h"
#include "relight/sky/solar_position.h"

#include <opencv2/core.hpp>

#include <optional>
#include <string>
#include <vector>

namespace relight {

struct AccuracyFacts {
  SolarPosition input;
  double heading_rad = 0.0;  // Of the view's camera.
  std::size_t views = 0;     // That the volume was made from.
  std::optional<TurbidityEstimate> air;
  std::optional<PhotoContrast> contrast;
};

// One sentence each, the costliest first; none when nothing is known to cost.
std::vector<std::string> AccuracyNotes(const AccuracyFacts& facts,
                                       const Correction& correction);

}  // namespace relight
