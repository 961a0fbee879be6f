// SPDX-License-Identifier: Apache-2.0
#pragma once

// capture.toml: what a capture folder says of itself.
//
//   place = [40.35, -74.65, 20.0]         # latitude, longitude [deg], altitude [m]
//   zone = "America/New_York"             # or "-04:00"; for photos without their own
//   taken = "2011-07-22T13:00:00-04:00"   # for photos without their own time
//   heading = 359.25                      # [deg] one photo alone without its own
//
//   [[view]]
//   name = "view_00"                      # left out: the photo's name without extension
//   photo = "photos/view_00.jpg"
//   taken = "…"                           # this photo's own, wins over EXIF
//
//   [options]                             # as on the command line, which wins
//   turbidity = 3.0
//   cells = 100

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

struct ViewEntry {
  std::string name;
  std::filesystem::path photo;  // Relative to the capture folder.
  std::optional<std::string> taken;
};

struct OptionEntry {
  std::string text;
  std::string where;  // "maple/capture.toml:12", for messages.
};

struct CaptureFile {
  std::optional<std::string> place;  // As ParsePlace reads it.
  std::optional<std::string> zone, taken;
  std::optional<double> heading_deg;
  std::vector<ViewEntry> views;
  std::map<std::string, OptionEntry> options;
};

// Throws InputError "FILE:LINE: what; remedy" for what is no TOML, an unknown key, a
// value that cannot be read, a name or path that leads out of the folder, two views of
// one name. What [options] may hold is known to OptionsFrom (relight/capture/capture.h).
CaptureFile ReadCaptureFile(const std::filesystem::path& file);

// The text that `relight init` writes, with a comment where something is missing.
std::string CaptureFileText(const CaptureFile& capture);

// [[view]] entries of `views`, as init appends them to a file that is there.
std::string ViewsText(std::span<const ViewEntry> views);

}  // namespace relight
