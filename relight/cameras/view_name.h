// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of views, and of the files in a capture that belong to them. Text files of a
// capture may come from anywhere, so that no name in them may lead out of the capture.

#include <filesystem>
#include <string>
#include <string_view>

namespace relight {

// The view's name of a photo or matte: the file's name without folders and extension.
std::string ViewNameOf(const std::filesystem::path& file);

// Throws InputError naming `source` (file and line) unless `path` is relative, has no
// "..", no control characters and is not empty.
void RequireInsideCapture(std::string_view path, std::string_view source);

}  // namespace relight
