// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a stage depended on, as 32 hexadecimal digits: XXH3, 128 bits. A file is known by
// its content, never by its time.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace relight {

// The hash of a text that comes piece by piece, and is nowhere as a whole.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;

  void Add(std::string_view piece);
  std::string Text() const;  // That of HashOfText for all pieces so far.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string HashOfText(std::string_view text);

// Throws InputError when the file cannot be read.
std::string HashOfFile(const std::filesystem::path& file);

}  // namespace relight
