// SPDX-License-Identifier: Apache-2.0
#include "relight/base/data_folder.h"

#include "relight/base/error.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace relight {
namespace {

namespace fs = std::filesystem;

TEST(DataFolder, TheEnvironmentIsAskedAloneTheErrorSaysWhere) {
  const fs::path folder = fs::path(testing::TempDir()) / "relight_data_folder_test";
  fs::create_directories(folder / "magnetic");
  setenv("RELIGHT_DATA", folder.c_str(), 1);
  EXPECT_EQ(DataPath("magnetic"), folder / "magnetic");
  fs::remove_all(folder);
  std::string words;
  try {
    DataPath("magnetic");
  } catch (const InputError& e) {
    words = e.what();
  }
  unsetenv("RELIGHT_DATA");
  EXPECT_NE(words.find(folder.string()), std::string::npos) << words;
  EXPECT_NE(words.find("RELIGHT_DATA"), std::string::npos);
}

TEST(DataFolder, AProgramOfTheBuildTreeFindsTheSourcesOwn) {
  unsetenv("RELIGHT_DATA");
  EXPECT_TRUE(fs::exists(DataPath("magnetic") / "wmm2025.wmm"));
  EXPECT_THROW(DataPath("no-such-data"), InputError);
}

}  // namespace
}  // namespace relight
