// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/stage_records.h"

#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>

namespace relight {
namespace {

namespace fs = std::filesystem;
using State = StageRecords::State;

using StageRecordsTest = tests::TemporaryFolder;

TEST_F(StageRecordsTest, KnowsWhatWasMadeAndFromWhat) {
  StageRecords records(folder_);
  EXPECT_EQ(records.StateOf("volume", "k"), State::kMissing);
  Write("volume.vdb", "v1");
  records.Remember("volume", "k", {"volume.vdb"});
  for (const StageRecords& r :
       {records, StageRecords(folder_)}) {  // Now and in another run
    EXPECT_EQ(r.StateOf("volume", "k"), State::kUpToDate);
    EXPECT_EQ(r.StateOf("volume", "other"), State::kStale);
    EXPECT_EQ(r.StateOf("light", "k"), State::kMissing);
    EXPECT_TRUE(r.IsOurs("volume.vdb"));
    EXPECT_FALSE(r.IsOurs("light.vdb"));
  }
}

TEST_F(StageRecordsTest, ContentCountsAndTimeDoesNot) {
  const fs::path file = Write("volume.vdb", "v1");
  StageRecords records(folder_);
  records.Remember("volume", "k", {"volume.vdb"});
  fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::hours(1000));
  EXPECT_EQ(records.StateOf("volume", "k"), State::kUpToDate);
  Write("volume.vdb", "v2");
  EXPECT_EQ(records.StateOf("volume", "k"), State::kEdited);
  EXPECT_EQ(records.StateOf("volume", "other"), State::kEdited);  // Never thrown away
  EXPECT_FALSE(records.IsOurs("volume.vdb"));
  Write("volume.vdb", "v1");
  EXPECT_EQ(records.StateOf("volume", "k"), State::kUpToDate);
  fs::remove(file);
  EXPECT_EQ(records.StateOf("volume", "k"), State::kMissing);
}

TEST_F(StageRecordsTest, ManyStagesWithManyFiles) {
  Write("mattes/a.png", "a");
  Write("cache/a.exr", "b");
  Write("volume.vdb", "c");
  StageRecords records(folder_);
  records.Remember("matte a", "1", {"mattes/a.png", "cache/a.exr"});
  records.Remember("volume", "2", {"volume.vdb"});
  records.Remember("matte a", "3", {"mattes/a.png", "cache/a.exr"});
  EXPECT_EQ(records.StateOf("matte a", "3"), State::kUpToDate);
  EXPECT_EQ(records.StateOf("volume", "2"), State::kUpToDate);
  fs::remove(folder_ / "cache/a.exr");
  EXPECT_EQ(records.StateOf("matte a", "3"), State::kMissing);
}

TEST_F(StageRecordsTest, RecordsThatCannotBeReadAreNone) {
  Write("volume.vdb", "v");
  for (const char* text : {"",
                           "{",
                           "[1]",
                           "3",
                           R"({"volume": 1})",
                           R"({"volume": {"key": "k"}})",
                           R"({"volume": {"key": 1, "files": {}}})",
                           R"({"volume": {"key": "k", "files": []}})",
                           "\xff\xfe"}) {
    SCOPED_TRACE(text);
    Write("cache/stages.json", text);
    EXPECT_EQ(StageRecords(folder_).StateOf("volume", "k"), State::kMissing);
  }
}

TEST_F(StageRecordsTest, RecordsHashNothingThatIsNoFile) {
  Write(
      "cache/stages.json",
      R"({"volume": {"key": "k", "files": {"../../../../dev/zero": "x", "/dev/zero": "y"}}})");
  EXPECT_EQ(StageRecords(folder_).StateOf("volume", "k"), State::kMissing);
}

TEST_F(StageRecordsTest, KeysDifferInEveryPart) {
  const fs::path a = Write("a", "content"), b = Write("b", "content"),
                 c = Write("c", "Content");
  const auto key = [](const std::string& stage,
                      std::initializer_list<std::string> parts) {
    StageKey made(stage);
    for (const std::string& part : parts) made.Add(part);
    return made.Hash();
  };
  // Parts run together, in another order, empty: each its own key
  const std::set<std::string> keys = {key("s", {}),
                                      key("s", {""}),
                                      key("s", {"ab"}),
                                      key("s", {"a", "b"}),
                                      key("s", {"b", "a"}),
                                      key("t", {"ab"}),
                                      key("s", {"a\n1:b"})};
  EXPECT_EQ(keys.size(), 7u);
  EXPECT_EQ(key("s", {"a", "b"}), key("s", {"a", "b"}));
  EXPECT_EQ(StageKey("s").AddFile(a).Hash(), StageKey("s").AddFile(b).Hash());
  EXPECT_NE(StageKey("s").AddFile(a).Hash(), StageKey("s").AddFile(c).Hash());
}

}  // namespace
}  // namespace relight
