// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/photo_heading.h"

#include "relight/photo/true_heading.h"

namespace relight {

std::optional<PhotoHeading> HeadingFromExif(const PhotoFacts& facts,
                                            const std::optional<Place>& place,
                                            const std::optional<Instant>& utc) {
  if (!facts.heading_deg) return std::nullopt;
  if (!facts.heading_is_magnetic) return PhotoHeading{*facts.heading_deg, {}};
  if (!place) return std::nullopt;
  const Instant at =
      utc.value_or(Instant(std::chrono::sys_days(std::chrono::year(2020) / 1 / 1)));
  const TrueHeading heading = TrueFromMagnetic(*facts.heading_deg, *place, at);
  return PhotoHeading{
      heading.heading_deg,
      "the compass heading in EXIF is magnetic; corrected by " +
          std::to_string(heading.declination.declination_deg).substr(0, 5) +
          " deg with " + heading.declination.model};
}

}  // namespace relight
