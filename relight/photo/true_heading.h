// SPDX-License-Identifier: Apache-2.0
#pragma once

// Magnetic to true north.
//
//   [WMM] World Magnetic Model, NOAA/NCEI and BGS, one model for five years; evaluated by
//         GeographicLib::MagneticModel
//
//   true heading = magnetic heading + declination D                      (P2)
//
// D is positive where the needle points east of true north. Models 2010 to 2025 are
// shipped (relight/photo/magnetic); a time that no model covers is answered by the
// nearest, and said. The field itself is known to some 0.5 deg; near the magnetic poles D
// means little, and that is said too.

#include "relight/base/instant.h"

#include <string>
#include <vector>

namespace relight {

struct Declination {
  double declination_deg = 0.0;         // East positive.
  std::string model = {};               // "wmm2010".
  std::vector<std::string> notes = {};  // One sentence each.
};

// `year` is decimal: 2011.5 is July 2011. Throws InputError when the model's files are
// not there.
Declination MagneticDeclination(const Place& place, double year);

struct TrueHeading {
  double heading_deg = 0.0;  // Clockwise from true north, [0, 360).
  Declination declination = {};
};

TrueHeading TrueFromMagnetic(double magnetic_heading_deg,
                             const Place& place,
                             Instant utc);

// 2011-07-02T12:00Z is 2011.5.
double DecimalYear(Instant utc);

}  // namespace relight
