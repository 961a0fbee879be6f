// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_folder.h"

#include "relight/base/error.h"

namespace relight {
namespace fs = std::filesystem;

fs::path MakeFolderOf(const fs::path& capture, const fs::path& name) {
  const fs::path folder = capture / name;
  const bool leads_nowhere = fs::is_symlink(folder) && !fs::exists(folder);
  const fs::path real = fs::weakly_canonical(
      leads_nowhere ? folder.parent_path() / fs::read_symlink(folder) : folder);
  const fs::path inside = real.lexically_relative(fs::weakly_canonical(capture));
  if (inside.empty() || *inside.begin() == "..") {
    throw InputError(folder.string() + ": is a link that leads out of the capture, to " +
                     real.string() + "; put a folder in its place");
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
