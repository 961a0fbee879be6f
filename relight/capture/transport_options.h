// SPDX-License-Identifier: Apache-2.0
#pragma once

// How light reaches the leaves in the default method, where it departs from [Cabral11];
// `cabral2011` has ArrivingLightOptions{}. What each is worth: docs/validation.md.

#include "relight/scattering/arriving_light.h"

namespace relight {

inline ArrivingLightOptions OurTransport() {
  return {.sun_directions = 16, .own_shade = 0};
}

}  // namespace relight
