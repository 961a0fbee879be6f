// SPDX-License-Identifier: Apache-2.0
#pragma once

// From the numbers in a file to scene-linear Rec.709. Private to this folder.

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// What the file itself says of its numbers.
struct FileColorHints {
  std::string file_name;         // For the file rules of a config.
  bool scene_linear = false;     // Float samples; for RAW, developed to linear Rec.709.
  bool developed_raw = false;    // By us, so no rule of a config applies.
  std::string icc_profile = {};  // The embedded one; empty without one.
  std::string icc_description = {};         // Of it, or of the colours that a HEIC names.
  std::vector<double> chromaticities = {};  // Of an EXR: xy of R, G, B, white; or empty.
};

struct ColorTransform {
  // In place, on packed RGB; may be called from several threads at once. Empty: nothing
  // to do.
  std::function<void(float* rgb, std::size_t pixels)> apply = {};
  bool mixes_channels = false;  // A matrix is in it: no table per channel can do it.
  std::vector<std::string> notes = {};
};

// `chosen_space`, when given, wins over the rules of the config and over the hints.
// Throws OptionError for a space that the config has not, InputError for a broken config.
ColorTransform SceneLinearFromFile(const FileColorHints& hints,
                                   const std::optional<std::string>& chosen_space);

}  // namespace relight
