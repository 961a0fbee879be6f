// SPDX-License-Identifier: Apache-2.0
#include "relight/base/write_file.h"

#include "relight/base/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

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
  throw InputError(file.string() + ": " + what + ": " + std::strerror(error) + remedy);
}

// A name beside `file` that no other run uses; it keeps the extension, for image
// libraries choose the format by it.
fs::path TemporaryFor(const fs::path& file) {
  static std::atomic<int> count = 0;
  return file.parent_path() /
         ("." + file.stem().string() + ".part-" + std::to_string(getpid()) + "-" +
          std::to_string(count++) + file.extension().string());
}

struct RemoveUnlessKept {
  fs::path path;
  bool kept = false;
  ~RemoveUnlessKept() {
    std::error_code ignored;
    if (!kept) fs::remove(path, ignored);
  }
};

}  // namespace

void WriteFileWhole(const fs::path& file,
                    const std::function<void(const fs::path& temporary)>& write) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code status;
  if (!fs::is_directory(folder, status)) {
    throw InputError(file.string() + ": the folder " + folder.string() +
                     " does not exist; make it first, or choose another with -o");
  }
  if (fs::is_directory(file, status)) {
    throw InputError(file.string() + ": is a folder; give the name of a file with -o");
  }
  RemoveUnlessKept temporary{TemporaryFor(file)};

  // Ask before the work whether a file can be made here at all
  const int probe =
      open(temporary.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (probe < 0) Fail(file, "cannot be written", errno);
  close(probe);
  write(temporary.path);

  // On the disk before it takes the name
  const int written = open(temporary.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (written < 0) Fail(file, "cannot be written", errno);
  const int flushed = fsync(written) == 0 ? 0 : errno;
  close(written);
  if (flushed != 0) Fail(file, "cannot be written", flushed);
  if (rename(temporary.path.c_str(), file.c_str()) != 0)
    Fail(file, "cannot be written", errno);
  temporary.kept = true;
}

void WriteTextWhole(const fs::path& file, std::string_view text) {
  WriteFileWhole(file, [&](const fs::path& temporary) {
    const int out = open(temporary.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (out < 0) Fail(file, "cannot be written", errno);
    std::size_t at = 0;
    while (at < text.size()) {
      const ssize_t n = ::write(out, text.data() + at, text.size() - at);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) {
        const int error = errno;
        close(out);
        Fail(file, "cannot be written", error);
      }
      at += static_cast<std::size_t>(n);
    }
    if (close(out) != 0) Fail(file, "cannot be written", errno);
  });
}

std::string ReadText(const fs::path& file, std::size_t limit_bytes) {
  std::error_code status;
  if (fs::is_directory(file, status)) {
    throw InputError(file.string() + ": is a folder, not a file");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be read: " + std::strerror(errno));
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
