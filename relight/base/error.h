// SPDX-License-Identifier: Apache-2.0
#pragma once

// Four kinds of failure. The library never ends the process: what a user can mend
// is an exception whose text names the thing, the value and the remedy.

#include <stdexcept>
#include <string>

namespace relight {

class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A field of an options struct is out of its range.
class OptionError : public Error {
 public:
  using Error::Error;
};

// A file, photo or folder that cannot be used, or cannot be written.
class InputError : public Error {
 public:
  using Error::Error;
};

// The user pressed Stop or Ctrl-C.
class Cancelled : public Error {
 public:
  Cancelled() : Error("stopped") {}
};

// A promise inside the program; broken, it is a bug of ours: std::logic_error.
inline void Require(bool holds,
                    const char* promise,
                    const char* file = __builtin_FILE(),
                    int line = __builtin_LINE()) {
  if (!holds) {
    throw std::logic_error(std::string(file) + ":" + std::to_string(line) +
                           ": broken promise: " + promise);
  }
}

}  // namespace relight
