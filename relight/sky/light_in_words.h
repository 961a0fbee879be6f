// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the sun stands, as one says it to a photographer.

#include <string>

namespace relight {

// `azimuth_from_heading_rad`: the sun's azimuth less the camera's heading, of any turn: 0
// straight ahead, pi/2 from the right, pi from behind.

// "sun behind you on the left, 62° high, shadow falls away to the right";
// "sun overhead, 84° high, shadow under the tree" from 80° on.
std::string LightInWords(double azimuth_from_heading_rad, double elevation_rad);

// The same in short: "from the right, 14°", "from behind on the left, 62°".
std::string LightInFewWords(double azimuth_from_heading_rad, double elevation_rad);

// Without a camera, by the compass: "from the south-west, 62°".
std::string LightFromCompass(double azimuth_rad, double elevation_rad);

}  // namespace relight
