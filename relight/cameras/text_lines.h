// SPDX-License-Identifier: Apache-2.0
#pragma once

// A text file of one of the camera formats, line by line, that knows where it is.

#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <filesystem>
#include <sstream>
#include <string>

namespace relight {

class TextLines {
 public:
  // `remedy` ends each message: how such a file is made again.
  TextLines(const std::filesystem::path& file, std::string remedy)
      : file_(file), remedy_(std::move(remedy)), text_(ReadText(file, kLimitBytes)) {}

  // The next line that is no comment (#…), without its line end; blank lines count only
  // when asked for.
  bool Next(std::string& line, bool blank_too = false) {
    while (std::getline(text_, line)) {
      ++number_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const std::size_t first = line.find_first_not_of(" \t");
      if (first == std::string::npos && !blank_too) continue;
      if (first != std::string::npos && line[first] == '#') continue;
      return true;
    }
    return false;
  }

  std::string Where() const { return file_.string() + ":" + std::to_string(number_); }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(Where() + ": " + what + "; " + remedy_);
  }

 private:
  static constexpr std::size_t kLimitBytes = 500'000'000;
  std::filesystem::path file_;
  std::string remedy_;
  std::istringstream text_;
  int number_ = 0;
};

}  // namespace relight
