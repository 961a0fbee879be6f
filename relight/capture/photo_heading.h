// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which way a photo's camera looked, by its own EXIF, from true north.

#include "relight/photo/photo_facts.h"

#include <optional>
#include <string>

namespace relight {

struct PhotoHeading {
  double heading_deg = 0.0;  // Clockwise from true north, [0, 360).
  std::string note;          // What was corrected; mostly empty.
};

// Nothing without a heading in EXIF, or with a magnetic one and no `place`. Without a
// time the Earth's field of 2020 is taken.
std::optional<PhotoHeading> HeadingFromExif(const PhotoFacts& facts,
                                            const std::optional<Place>& place,
                                            const std::optional<Instant>& utc);

}  // namespace relight
