// SPDX-License-Identifier: Apache-2.0
#pragma once

// A page that shows frames under a slider: one HTML file that holds its pictures, needs
// no network and runs from a folder.

#include <string>
#include <vector>

namespace relight {

struct PageFrame {
  std::string name;   // "2011-07-22_1730".
  std::string label;  // "22 July 2011, 17:30".
  std::string light;  // "from the right, 37°".
  double sun_from_heading_rad =
      0.0;  // 0 straight ahead of the camera, pi/2 on its right.
  double sun_elevation_rad = 0.0;
  std::string jpeg;  // Bytes.
};

std::string FramePage(const std::string& title, const std::vector<PageFrame>& frames);

}  // namespace relight
