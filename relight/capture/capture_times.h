// SPDX-License-Identifier: Apache-2.0
#pragma once

// When and where the photos of a capture were taken, and what makes them unlike photos of
// one tree in one light: hours or days between them, a clock that GPS contradicts, a
// place apart from the others', a camera that looks elsewhere. All of it is doubt, not
// error; what a photo does not say is not doubted.

#include "relight/capture/capture.h"
#include "relight/photo/capture_time.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

struct ViewTime {
  std::string view;
  std::optional<LocalTime> time;
  std::optional<Place> place;  // The photo's own.
  std::vector<std::string> doubts = {};
};

// In the capture's order. A photo that is gone or cannot be read has neither.
std::vector<ViewTime> ViewTimesOf(const Capture& capture,
                                  const std::optional<std::string>& zone_text = {});

// Photos more than an hour apart on the day of most of them, with the sun's way from the
// first to the last: as the camera of `heading_rad` sees it, else by the compass. Photos
// of another day.
std::vector<std::string> DoubtsOfTimes(std::span<const ViewTime> times,
                                       const std::optional<Place>& place,
                                       std::optional<double> heading_rad = {});

// Photos taken farther from the median place than 30 m (three errors of GPS) and thrice
// the median distance from it. Nothing of fewer than three places.
std::vector<std::string> DoubtsOfPlaces(std::span<const ViewTime> times);

// All of these, and cameras that look elsewhere (relight/cameras/another_tree.h). For the
// words of light: the heading of the view that is relit.
std::vector<std::string> DoubtsOfCapture(const Capture& capture,
                                         const std::optional<std::string>& zone_text = {},
                                         std::optional<double> heading_rad = {});

}  // namespace relight
