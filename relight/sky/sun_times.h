// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sunrise, noon and sunset of a day, for remedies and for the sheet of a place.
//
// Geometric: the sun's centre at elevation 0 without refraction, which is where our sky
// models end. Almanacs count the upper edge and 34' of refraction, and so have sunrise
// some 4 minutes earlier at middle latitudes.

#include "relight/base/instant.h"

#include <chrono>
#include <optional>

namespace relight {

// Within a second, save where the sun only grazes the horizon.
struct SunTimes {
  Instant noon;                    // When the sun is highest.
  std::optional<Instant> sunrise;  // None when the sun is up, or down, from the midnight
  std::optional<Instant> sunset;   // before to noon, or from noon to the midnight after.
};

// `date` is the day at the place itself: its noon is the one nearest to 12 h of local
// mean time, UTC + longitude / 15. Throws InputError as SolarPositionAt does.
SunTimes SunTimesOf(std::chrono::year_month_day date, const Place& place);

}  // namespace relight
