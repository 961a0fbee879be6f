// SPDX-License-Identifier: Apache-2.0
#pragma once

// Output files are written whole or not at all.

#include <filesystem>
#include <functional>
#include <string_view>

namespace relight {

// Calls write(temporary) with a new path in `file`'s folder, of the same extension,
// flushes what it wrote to the disk and renames it to `file`. When anything fails the
// temporary file is removed and `file` is as it was.
// Throws InputError that names `file` and the reason (folder missing, not writable, disk
// full), and whatever `write` throws.
void WriteFileWhole(
    const std::filesystem::path& file,
    const std::function<void(const std::filesystem::path& temporary)>& write);

// The same for text or bytes at hand.
void WriteTextWhole(const std::filesystem::path& file, std::string_view text);

// Throws InputError when `file` is a folder, or its folder is missing or may not be
// written to: what can be said before the work.
void RequirePlaceFor(const std::filesystem::path& file);

// For programs that write a file themselves: a new name beside `file`, of the same
// extension; and what takes its place when it is whole. Throws InputError.
std::filesystem::path TemporaryFor(const std::filesystem::path& file);
void TakeName(const std::filesystem::path& temporary, const std::filesystem::path& file);

// Removes what runs of relight that were killed left in `folder`: temporary files of
// processes that are no more.
void RemoveLeftovers(const std::filesystem::path& folder);

// All of a file. Throws InputError when it cannot be read, or is larger than
// `limit_bytes`.
std::string ReadText(const std::filesystem::path& file,
                     std::size_t limit_bytes = std::size_t{1} << 30);

}  // namespace relight
