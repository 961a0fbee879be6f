// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a stage depended on, as 32 hexadecimal digits: XXH3, 128 bits. A file is known by
// its content, never by its time.

#include <filesystem>
#include <string>
#include <string_view>

namespace relight {

std::string HashOfText(std::string_view text);

// Throws InputError when the file cannot be read.
std::string HashOfFile(const std::filesystem::path& file);

}  // namespace relight
