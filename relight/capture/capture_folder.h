// SPDX-License-Identifier: Apache-2.0
#pragma once

// The folders of a capture that relight writes into.

#include <filesystem>

namespace relight {

// The folder `name` (mattes, cache, out, …) of a capture, made when it is not there.
// Throws InputError when it cannot be made, or is a link that leads out of the capture:
// nothing that somebody put into a capture makes the program write elsewhere.
std::filesystem::path MakeFolderOf(const std::filesystem::path& capture,
                                   const std::filesystem::path& name);

}  // namespace relight
