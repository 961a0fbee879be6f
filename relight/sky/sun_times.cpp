// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sun_times.h"

#include "relight/base/error.h"
#include "relight/sky/solar_position.h"

namespace relight {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

// Elevation times `sign`; the equation of time is below 17 minutes, so the highest and
// the lowest sun are within an hour of mean noon and midnight.
Instant Highest(Instant about, const Place& place, double sign) {
  Instant low = about - hours(1), high = about + hours(1);
  const auto value = [&](Instant t) {
    return sign * SolarPositionAt(t, place).elevation_rad;
  };
  while (high - low > milliseconds(500)) {
    const milliseconds third = (high - low) / 3;
    if (value(low + third) < value(high - third)) {
      low += third;
    } else {
      high -= third;
    }
  }
  return low + (high - low) / 2;
}

// When the elevation changes its sign between two instants, if it does.
std::optional<Instant> Crossing(Instant from, Instant to, const Place& place) {
  const auto is_up = [&](Instant t) {
    return SolarPositionAt(t, place).elevation_rad > 0.0;
  };
  const bool up_at_start = is_up(from);
  if (up_at_start == is_up(to)) return std::nullopt;
  while (to - from > milliseconds(1)) {
    const Instant middle = from + (to - from) / 2;
    (is_up(middle) == up_at_start ? from : to) = middle;
  }
  return to;
}

}  // namespace

SunTimes SunTimesOf(std::chrono::year_month_day date, const Place& place) {
  if (!date.ok()) throw InputError("the date is no day of the calendar; correct it");
  const auto longitude_in_time =
      milliseconds(static_cast<long long>(place.longitude_deg / 15.0 * 3.6e6));
  const Instant mean_noon =
      Instant(std::chrono::sys_days(date)) + hours(12) - longitude_in_time;

  const Instant noon = Highest(mean_noon, place, +1.0);
  const Instant midnight_before = Highest(mean_noon - hours(12), place, -1.0);
  const Instant midnight_after = Highest(mean_noon + hours(12), place, -1.0);
  return {.noon = noon,
          .sunrise = Crossing(midnight_before, noon, place),
          .sunset = Crossing(noon, midnight_after, place)};
}

}  // namespace relight
