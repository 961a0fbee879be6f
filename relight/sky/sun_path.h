// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sun's way over a place as a diagram: north up and east on the right as on a map,
// the zenith in the middle and the horizon on the rim, elevation even along the radius.

#include "relight/sky/solar_position.h"

#include <chrono>
#include <string>

namespace relight {

// An SVG of the day's way with a dot each whole hour of the clock that is `offset` ahead
// of UTC, those of both solstices of the year, and the sun of `now` where it is up. Where
// the sun does not rise its way is missing, where it does not set it goes round. Throws
// InputError as SolarPositionAt does.
std::string SunPathSvg(const Place& place,
                       std::chrono::year_month_day date,
                       std::chrono::minutes offset,
                       const SolarPosition& now);

}  // namespace relight
