// SPDX-License-Identifier: Apache-2.0
#pragma once

// CIE 1931 XYZ and linear Rec.709 (white D65), both ways, nothing clamped.
//
//   [IEC61966] docs/bibliography.md#iec61966   primaries and white of sRGB
//
// Channels are photometric: (1, 1, 1) has the luminance Y = 1, so cd/m2 stay cd/m2 and
// lux stay lux. A colour outside of Rec.709 has a negative channel; as both ways are
// linear, nothing is lost until someone clamps.

#include <Eigen/Core>

namespace relight {

Eigen::Array3d Rec709FromXyz(const Eigen::Array3d& xyz);
Eigen::Array3d XyzFromRec709(const Eigen::Array3d& rgb);

}  // namespace relight
