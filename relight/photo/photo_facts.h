// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a photo says of itself: when, where and which way (EXIF), and whether it is a
// result of relight.

#include "relight/base/instant.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// Date and time on the clocks of some place, without saying which.
using WallClock = std::chrono::local_time<std::chrono::milliseconds>;

struct PhotoFacts {
  std::string file;  // As given; for messages.
  int width = 0;     // px, upright.
  int height = 0;
  int orientation = 1;  // 1 to 8, as in EXIF: how the stored picture is turned upright.

  std::optional<WallClock> local_time;         // DateTimeOriginal, with sub-seconds.
  std::optional<std::chrono::minutes> offset;  // OffsetTimeOriginal: local minus UTC.
  std::optional<Instant> gps_time;             // GPSDateStamp and GPSTimeStamp.

  std::optional<Place> place;  // GPSLatitude, GPSLongitude, GPSAltitude.
  // GPSImgDirection, or a drone's gimbal yaw; [0, 360), clockwise from north.
  std::optional<double> heading_deg;
  bool heading_is_magnetic = false;     // Else from true north.
  std::optional<double> focal_mm;       // FocalLength.
  std::optional<double> focal_35mm_mm;  // FocalLengthIn35mmFilm.

  std::string make, model, software, description;

  bool made_by_relight = false;  // Software begins with "relight ".
  std::string provenance_json;   // What such a result says of its making; else empty.

  // Facts that were there but cannot be (month 13, latitude 95); they count as absent.
  std::vector<std::string> notes;
};

// Throws InputError as ReadPhoto does; pixels are not read. Malformed EXIF is no error.
PhotoFacts ReadPhotoFacts(const std::filesystem::path& path);

}  // namespace relight
