// SPDX-License-Identifier: Apache-2.0
#pragma once

// Moments and places as plain values (docs/conventions.md#time). Inside the program time
// is UTC; local time with its offset exists at the door only
// (relight/photo/capture_time.h).

#include <chrono>

namespace relight {

using Instant = std::chrono::sys_time<std::chrono::milliseconds>;

// On the WGS84 ellipsoid.
struct Place {
  double latitude_deg = 0.0;   // North positive, [-90, 90].
  double longitude_deg = 0.0;  // East positive, [-180, 180].
  double altitude_m = 0.0;
};

}  // namespace relight
