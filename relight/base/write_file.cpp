// SPDX-License-Identifier: Apache-2.0
#include "relight/base/write_file.h"

#include "relight/base/error.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace relight {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void Fail(const fs::path& file, const std::string& what, int error) {
  std::string remedy;
  if (error == ENOSPC || error == EFBIG || error == EDQUOT) {
    remedy = "; free some space or write to another disk with -o";
  } else if (error == EACCES || error == EPERM || error == EROFS) {
    remedy = "; choose a folder you may write to with -o";
  } else if (error == ENOENT || error == ENOTDIR) {
    remedy = "; make the folder first";
  }
  throw InputError(file.string() + ": " + what + ": " +
                   std::generic_category().message(error) + remedy);
}

struct RemoveUnlessKept {
  fs::path path;
  bool kept = false;
  ~RemoveUnlessKept() {
    std::error_code ignored;
    if (!kept) fs::remove(path, ignored);
  }
};

void Flush(const fs::path& temporary, const fs::path& file) {
  const int written = open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  if (written < 0) Fail(file, "cannot be written", errno);
  const int flushed = fsync(written) == 0 ? 0 : errno;
  close(written);
  if (flushed != 0) Fail(file, "cannot be written", flushed);
}

void WriteAll(int out, std::string_view text, const fs::path& file) {
  while (!text.empty()) {
    const ssize_t n = ::write(out, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) Fail(file, "cannot be written", errno);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

struct Descriptor {
  int number = -1;
  ~Descriptor() {
    if (number >= 0) close(number);
  }
};

constexpr const char* kPart = ".part-";

}  // namespace

void RequirePlaceFor(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code status;
  if (!fs::is_directory(folder, status)) {
    throw InputError(file.string() + ": the folder " + folder.string() +
                     " does not exist; make it first, or choose another with -o");
  }
  if (fs::is_directory(file, status)) {
    throw InputError(file.string() + ": is a folder; give the name of a file with -o");
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) Fail(file, "cannot be written", errno);
}

fs::path TemporaryFor(const fs::path& file) {
  static std::atomic<int> count = 0;
  return file.parent_path() /
         ("." + file.stem().string() + kPart + std::to_string(getpid()) + "-" +
          std::to_string(count++) + file.extension().string());
}

void TakeName(const fs::path& temporary, const fs::path& file) {
  Flush(temporary, file);
  if (rename(temporary.c_str(), file.c_str()) != 0)
    Fail(file, "cannot be written", errno);
}

void RemoveLeftovers(const fs::path& folder) {
  std::vector<fs::path> left;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const std::size_t part = name.rfind(kPart);
    if (name[0] != '.' || part == std::string::npos) continue;
    const char* digits = name.c_str() + part + std::string_view(kPart).size();
    if (std::isdigit(static_cast<unsigned char>(*digits)) == 0) continue;
    const long process = std::strtol(digits, nullptr, 10);
    if (process > 0 && kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH) {
      left.push_back(entry.path());
    }
  }
  for (const fs::path& file : left) fs::remove(file, ignored);
}

void WriteFileWhole(const fs::path& file,
                    const std::function<void(const fs::path& temporary)>& write) {
  RequirePlaceFor(file);
  RemoveUnlessKept temporary{TemporaryFor(file)};

  // Ask before the work whether a file can be made here at all
  const int probe =
      open(temporary.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (probe < 0) Fail(file, "cannot be written", errno);
  close(probe);
  write(temporary.path);

  TakeName(temporary.path, file);
  temporary.kept = true;
}

void WriteTextWhole(const fs::path& file, std::string_view text) {
  RequirePlaceFor(file);

  // A file without a name, where the file system has them: whoever kills us leaves
  // nothing
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const Descriptor nameless{open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666)};
  if (nameless.number >= 0) {
    WriteAll(nameless.number, text, file);
    if (fsync(nameless.number) != 0) Fail(file, "cannot be written", errno);
    const std::string own = "/proc/self/fd/" + std::to_string(nameless.number);
    const auto named = [&](const fs::path& name) {
      return linkat(AT_FDCWD, own.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) ==
             0;
    };
    if (named(file)) return;
    RemoveUnlessKept temporary{TemporaryFor(file)};
    if (errno == EEXIST && named(temporary.path)) {
      if (rename(temporary.path.c_str(), file.c_str()) != 0)
        Fail(file, "cannot be written", errno);
      temporary.kept = true;
      return;
    }
  }

  WriteFileWhole(file, [&](const fs::path& temporary) {
    const Descriptor out{open(temporary.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC)};
    if (out.number < 0) Fail(file, "cannot be written", errno);
    WriteAll(out.number, text, file);
  });
}

std::string ReadText(const fs::path& file, std::size_t limit_bytes) {
  std::error_code status;
  if (fs::is_directory(file, status)) {
    throw InputError(file.string() + ": is a folder, not a file");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw InputError(file.string() +
                     ": cannot be read: " + std::generic_category().message(errno));
  std::string text;
  char buffer[1 << 16];
  while (in.read(buffer, sizeof buffer) || in.gcount() > 0) {
    text.append(buffer, static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit_bytes) {
      throw InputError(file.string() + ": larger than " + std::to_string(limit_bytes) +
                       " bytes, which no such file is");
    }
  }
  if (in.bad()) throw InputError(file.string() + ": cannot be read to its end");
  return text;
}

}  // namespace relight
