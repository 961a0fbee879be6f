// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_folder.h"

#include "relight/base/error.h"

namespace relight {
namespace fs = std::filesystem;

fs::path MakeFolderOf(const fs::path& capture, const fs::path& name) {
  const fs::path folder = capture / name;
  const auto inside =
      fs::weakly_canonical(folder).lexically_relative(fs::weakly_canonical(capture));
  if (inside.empty() || *inside.begin() == "..") {
    throw InputError(folder.string() + ": is a link that leads out of the capture, to " +
                     fs::weakly_canonical(folder).string() +
                     "; put a folder in its place");
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(folder.string() + ": the folder cannot be made: " + error.message() +
                     "; make it yourself, or copy the capture to a place you may write");
  }
  return folder;
}

}  // namespace relight
