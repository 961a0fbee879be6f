// SPDX-License-Identifier: Apache-2.0
#include "relight/base/error.h"
#include "relight/capture/stage_records.h"
#include "relight/capture/tree_volume.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

namespace fs = std::filesystem;

class LightCacheTest : public tests::TemporaryFolder {
 protected:
  Capture Here() {
    Capture capture;
    capture.folder = folder_;
    return capture;
  }
};

TEST_F(LightCacheTest, CleanRemovesWhatRelightMadeAndNothingElse) {
  EXPECT_FALSE(CleanLight(Here()));
  const fs::path light = Write("cache/light.vdb", "made");
  const fs::path others[] = {Write("volume.vdb", "v"),
                             Write("mattes/a.png", "m"),
                             Write("cache/foreground/a.exr", "f"),
                             Write("cache/notes.txt", "mine")};
  StageRecords(folder_).Remember("light", "k", {"cache/light.vdb"});
  const auto listed = LightCacheOf(Here());
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->bytes, 4u);
  EXPECT_TRUE(listed->is_ours);
  const auto removed = CleanLight(Here());
  ASSERT_TRUE(removed);
  EXPECT_TRUE(removed->is_ours);
  EXPECT_FALSE(fs::exists(light));
  for (const fs::path& other : others) EXPECT_TRUE(fs::exists(other)) << other;
  EXPECT_FALSE(CleanLight(Here()));
}

TEST_F(LightCacheTest, WhatSomebodyPutThereStays) {
  const fs::path light = Write("cache/light.vdb", "made");
  StageRecords(folder_).Remember("light", "k", {"cache/light.vdb"});
  Write("cache/light.vdb", "changed");
  const auto kept = CleanLight(Here());
  ASSERT_TRUE(kept);
  EXPECT_FALSE(kept->is_ours);
  EXPECT_EQ(Read(light), "changed");
}

// Neither a link in the place of the file nor one in that of the folder is followed.
TEST_F(LightCacheTest, DoesNotFollowLinks) {
  const fs::path mine = Write("elsewhere/light.vdb", "mine");
  Write("cache/light.vdb", "mine");
  StageRecords(folder_).Remember("light", "k", {"cache/light.vdb"});
  fs::remove(folder_ / "cache/light.vdb");
  fs::create_symlink(mine, folder_ / "cache/light.vdb");
  EXPECT_FALSE(CleanLight(Here()));
  EXPECT_TRUE(fs::exists(mine));
}

}  // namespace
}  // namespace relight
