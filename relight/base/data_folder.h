// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the files are that the program reads at run time (magnetic models and the like).

#include <filesystem>

namespace relight {

// The path of `name`, a file or folder below the program's data folder, e.g. "magnetic".
// Looked for in $RELIGHT_DATA when that is set, and then nowhere else; otherwise in
// ../share/relight beside the executable, in the data folder of the install prefix and,
// for a program that runs from its build tree, in the source folder of each stage.
// Throws InputError that says where it looked.
std::filesystem::path DataPath(const std::filesystem::path& name);

}  // namespace relight
