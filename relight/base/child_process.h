// SPDX-License-Identifier: Apache-2.0
#pragma once

// Another program, started without a shell: words reach it as they are.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace relight {

// The program of this name on PATH; nothing when there is none.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

// A running program that is fed through its standard input. It has a process group of its
// own, so that Ctrl-C is ours to act on, and is killed when this object goes before
// Finish.
class ChildProcess {
 public:
  // kLines: both its outputs are read with NextLine.
  enum class Output { kDropped, kWithMessages, kLines };

  // `arguments` without the program's own name; `output`: what becomes of its standard
  // output. Throws InputError when it cannot start.
  ChildProcess(const std::filesystem::path& program,
               const std::vector<std::string>& arguments,
               Output output = Output::kDropped);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // False when the program reads no more, mostly because it has ended.
  bool Write(std::string_view bytes);

  // Of Output::kLines: the next line that it printed, without its end. Empty when none
  // has come within `patience`; nothing when no more will come.
  std::optional<std::string> NextLine(std::chrono::milliseconds patience);

  // Ends the input and waits. What it printed on standard error, at most some lines, is
  // in `messages`. True when it ended well.
  bool Finish(std::string* messages);

 private:
  pid_t process_ = -1;
  int input_ = -1;     // Our end of its standard input.
  int messages_ = -1;  // A file in memory.
  int lines_ = -1;     // Our end of its outputs.
  std::string unread_ = {};
};

}  // namespace relight
