// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the independent figures and the pictures with known truth are: $RELIGHT_SHARED,
// else ../shared beside the checkout. They are not part of the repository, so a test that
// needs them skips with a clear word when they are not there.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace relight::tests {

inline std::filesystem::path SharedPath(const std::filesystem::path& below) {
  const char* given = std::getenv("RELIGHT_SHARED");
  const std::filesystem::path root =
      given != nullptr ? std::filesystem::path(given)
                       : std::filesystem::path(RELIGHT_SOURCE_DIR) / ".." / "shared";
  return root / below;
}

}  // namespace relight::tests

// First line of a test that needs shared files.
#define RELIGHT_SKIP_WITHOUT_SHARED(below)                         \
  if (!std::filesystem::exists(relight::tests::SharedPath(below))) \
  GTEST_SKIP() << relight::tests::SharedPath(below)                \
               << " is not there; set RELIGHT_SHARED to the folder that holds it"
