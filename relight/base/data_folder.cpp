// SPDX-License-Identifier: Apache-2.0
#include "relight/base/data_folder.h"

#include "relight/base/error.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace relight {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> FoldersToLookIn() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the environment is not written
  if (const char* given = std::getenv("RELIGHT_DATA");
      given != nullptr && *given != '\0') {
    return {given};
  }
  std::vector<fs::path> folders;
  std::error_code status;
  const fs::path executable = fs::read_symlink("/proc/self/exe", status);
  if (!status) {
    folders.push_back(executable.parent_path().parent_path() / "share" / "relight");
  }
  folders.emplace_back(RELIGHT_INSTALLED_DATA_DIR);

  // Every stage keeps its own data in its source folder
  std::vector<fs::path> stages;
  for (const auto& entry : fs::directory_iterator(RELIGHT_STAGES_SOURCE_DIR, status)) {
    if (entry.is_directory(status)) stages.push_back(entry.path());
  }
  std::sort(stages.begin(), stages.end());
  folders.insert(folders.end(), stages.begin(), stages.end());
  return folders;
}

}  // namespace

fs::path DataPath(const fs::path& name) {
  std::string looked_in;
  for (const fs::path& folder : FoldersToLookIn()) {
    std::error_code status;
    if (fs::exists(folder / name, status)) return folder / name;
    looked_in += (looked_in.empty() ? "" : ", ") + folder.string();
  }
  throw InputError(name.string() + ": not found among the program's data (looked in " +
                   looked_in +
                   "); install relight again, or set RELIGHT_DATA to the folder that "
                   "holds it");
}

}  // namespace relight
