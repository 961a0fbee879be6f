// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/view_name.h"

#include "relight/base/error.h"

#include <algorithm>

namespace relight {

std::string ViewNameOf(const std::filesystem::path& file) { return file.stem().string(); }

void RequireInsideCapture(std::string_view path, std::string_view source) {
  const std::filesystem::path parsed(path);
  const bool leads_out = parsed.is_absolute() ||
                         std::any_of(parsed.begin(), parsed.end(), [](const auto& part) {
                           return part == "..";
                         });
  const bool has_control = std::any_of(path.begin(), path.end(), [](char c) {
    return static_cast<unsigned char>(c) < 32 || c == 127 || c == '\\';
  });
  if (path.empty() || parsed.filename().empty() || leads_out || has_control) {
    throw InputError(
        std::string(source) + ": the name \"" + std::string(path) +
        "\" is refused: names are relative to the capture folder, without \"..\" "
        "and not absolute; rename it");
  }
}

}  // namespace relight
