// SPDX-License-Identifier: Apache-2.0
#include "relight/base/child_process.h"

#include "relight/base/error.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace relight {
namespace fs = std::filesystem;

std::optional<fs::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): not written
  std::string_view rest = path != nullptr ? path : "/usr/bin:/bin";
  while (true) {
    const std::size_t colon = rest.find(':');
    const fs::path file = fs::path(rest.substr(0, colon)) / name;
    std::error_code ignored;
    if (file.is_absolute() && fs::is_regular_file(file, ignored) &&
        access(file.c_str(), X_OK) == 0) {
      return file;
    }
    if (colon == std::string_view::npos) return {};
    rest.remove_prefix(colon + 1);
  }
}

ChildProcess::ChildProcess(const fs::path& program,
                           const std::vector<std::string>& arguments,
                           Output output) {
  // A socket, for writing to one that nobody reads raises no signal when asked not to
  int ends[2] = {-1, -1};
  messages_ = memfd_create("messages", MFD_CLOEXEC);
  if (messages_ < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    if (messages_ >= 0) close(messages_);
    throw InputError(program.string() + ": cannot be started: too many open files");
  }
  input_ = ends[0];
  int out[2] = {-1, -1};
  if (output == Output::kLines && pipe2(out, O_CLOEXEC) != 0) {
    close(ends[0]);
    close(ends[1]);
    close(messages_);
    throw InputError(program.string() + ": cannot be started: too many open files");
  }
  lines_ = out[0];
  const std::string own_name = program.string();
  std::vector<char*> words = {const_cast<char*>(own_name.c_str())};
  for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
  words.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
  if (output == Output::kWithMessages) {
    posix_spawn_file_actions_adddup2(&files, messages_, STDOUT_FILENO);
  } else if (output == Output::kLines) {
    posix_spawn_file_actions_adddup2(&files, out[1], STDOUT_FILENO);
  } else {
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  }
  posix_spawn_file_actions_adddup2(
      &files, output == Output::kLines ? out[1] : messages_, STDERR_FILENO);
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP);
  const int error =
      posix_spawn(&process_, own_name.c_str(), &files, &how, words.data(), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&files);
  close(ends[1]);
  if (out[1] >= 0) close(out[1]);
  if (error != 0) {
    close(input_);
    close(messages_);
    if (lines_ >= 0) close(lines_);
    throw InputError(own_name +
                     ": cannot be started: " + std::generic_category().message(error));
  }
}

ChildProcess::~ChildProcess() {
  if (input_ >= 0) close(input_);
  if (messages_ >= 0) close(messages_);
  if (lines_ >= 0) close(lines_);
  if (process_ > 0) {
    kill(process_, SIGKILL);
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
}

bool ChildProcess::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

std::optional<std::string> ChildProcess::NextLine(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  for (;;) {
    const std::size_t end = unread_.find_first_of("\n\r");
    if (end != std::string::npos) {
      std::string line = unread_.substr(0, end);
      unread_.erase(0, end + 1);
      return line;
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        until - std::chrono::steady_clock::now());
    pollfd ready{lines_, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::max<long>(0, left.count())));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) return "";
    char text[4096];
    const ssize_t size = read(lines_, text, sizeof text);
    if (size < 0 && errno == EINTR) continue;
    if (size > 0) {
      unread_.append(text, static_cast<std::size_t>(size));
      continue;
    }
    if (unread_.empty()) return {};
    return std::exchange(unread_, {});
  }
}

bool ChildProcess::Finish(std::string* messages) {
  close(input_);
  input_ = -1;
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  char text[4096];
  const ssize_t size = pread(messages_, text, sizeof text, 0);
  if (messages != nullptr)
    messages->assign(text, static_cast<std::size_t>(size > 0 ? size : 0));
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace relight
