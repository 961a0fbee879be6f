// SPDX-License-Identifier: Apache-2.0
#pragma once

// How light reaches the leaves in the default method, where it departs from [Cabral11];
// `cabral2011` has ArrivingLightOptions{}. What each is worth: docs/decisions/0008.

#include "relight/base/error.h"
#include "relight/base/field.h"
#include "relight/capture/light_options.h"
#include "relight/scattering/arriving_light.h"

#include <string>

namespace relight {

// What stands beside the tree.
struct NeighbourOptions {
  std::string occluder = {};  // A file as ReadOccluder takes it; empty: nothing.
};

template <class Visitor>
void Describe(NeighbourOptions& o, Visitor&& field) {
  field(o.occluder,
        FieldInfo{"occluder",
                  "",
                  "what casts its shadow on the tree: .obj or .vdb in metres, x east, y "
                  "north, z up from the tree's foot"});
}

inline ArrivingLightOptions OurTransport() {
  return {.sun_directions = 16, .own_shade = 0};
}

// Throws OptionError for an option that cabral2011 does not have.
inline ArrivingLightOptions TransportOf(Method method,
                                        const ArrivingLightOptions& options) {
  CheckFields(options);
  if (method != Method::kCabral2011) return options;
  if (options == OurTransport()) return {};
  throw OptionError(
      "cabral2011 has the sun's centre alone, a voxel's full own shade, and leaves that "
      "are points at random and scatter the light of sun and sky once, evenly; leave "
      "--sun-directions, --own-shade, --gap-length, --clumping, --leaf-transmission, "
      "--multiple-scattering and --bounce out, or the method");
}

}  // namespace relight
