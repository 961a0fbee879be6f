// SPDX-License-Identifier: Apache-2.0
#pragma once

// The colours that an embedded profile gives to a picture's numbers: ICC.1:2010 (profiles
// of version 2 and 4) as far as cameras and editors use it for RGB and grey, a curve for
// each channel and a matrix. Profiles that are tables in Lab, as printers have them, are
// not read. Private to this folder.

#include <array>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

namespace relight {

struct IccProfile {
  // Number in the file, in [0, 1], to linear light in [0, 1], of R, G, B. 4096 values
  // over [0, 1], linear between them; a single value is the exponent of a power.
  std::array<std::vector<double>, 3> curves;
  // Linear Rec.709 from the linear light of the profile's own primaries, row by row.
  // White is kept: it is white in both.
  std::array<std::array<double, 3>, 3> rec709_from_rgb{};

  double Linear(int channel, double value) const;

  // Whether it is sRGB within half a step of 8 bits, as the profiles that say so are.
  bool IsSrgb() const;
};

// Nothing when the bytes are no such profile, cut off, or of colours that no light has:
// a curve that falls, primaries in one line.
std::optional<IccProfile> ReadIccProfile(std::string_view bytes);

}  // namespace relight
