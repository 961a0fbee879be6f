// SPDX-License-Identifier: Apache-2.0
#include "relight/base/write_file.h"

#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/field.h"
#include "relight/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace relight {
namespace {
namespace fs = std::filesystem;

class WriteFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("relight-write-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t Files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(WriteFile, ReplacesWholeAndLeavesNothingElse) {
  WriteTextWhole(folder_ / "a.txt", "one");
  WriteTextWhole(folder_ / "a.txt", "two");
  EXPECT_EQ(ReadText(folder_ / "a.txt"), "two");
  EXPECT_EQ(Files(), 1u);
}

TEST_F(WriteFile, AWriterThatThrowsLeavesTheOldFile) {
  WriteTextWhole(folder_ / "a.txt", "old");
  EXPECT_THROW(WriteFileWhole(folder_ / "a.txt",
                              [](const fs::path& temporary) {
                                WriteTextWhole(temporary, "half");
                                throw InputError("broke off");
                              }),
               InputError);
  EXPECT_EQ(ReadText(folder_ / "a.txt"), "old");
  EXPECT_EQ(Files(), 1u);
}

TEST_F(WriteFile, MissingFolderIsNamedWithTheRemedy) {
  try {
    WriteTextWhole(folder_ / "none" / "a.txt", "x");
    FAIL() << "wrote into a folder that does not exist";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("does not exist; make it"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(WriteFile, HashesKnowContentNotName) {
  WriteTextWhole(folder_ / "a", "same");
  WriteTextWhole(folder_ / "b", "same");
  EXPECT_EQ(HashOfFile(folder_ / "a"), HashOfFile(folder_ / "b"));
  EXPECT_EQ(HashOfFile(folder_ / "a"), HashOfText("same"));
  EXPECT_NE(HashOfText("same"), HashOfText("Same"));
  EXPECT_EQ(HashOfText("").size(), 32u);
}

struct TwoFields {
  double size_m = 1.0;
  int sweeps = 3;
};
template <class Visitor>
void Describe(TwoFields& o, Visitor&& field) {
  field(o.size_m, FieldInfo{"size", "m", "edge", Above(0)});
  field(o.sweeps, FieldInfo{"sweeps", "", "passes", Between(1, 9)});
}

TEST(Field, OutOfRangeNamesTheFieldTheLimitAndTheValue) {
  CheckFields(TwoFields{});
  try {
    CheckFields(TwoFields{.size_m = -0.1});
    FAIL() << "took a negative size";
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(), "size must be > 0 m, got -0.1");
  }
  EXPECT_THROW(CheckFields(TwoFields{.size_m = std::nan("")}), OptionError);
  EXPECT_THROW(CheckFields(TwoFields{.sweeps = 10}), OptionError);
}

TEST(ParallelRanges, CoversEachIndexOnceWhateverTheThreads) {
  for (const int threads : {1, 2, 0}) {
    SetThreadCount(threads);
    std::vector<std::atomic<int>> seen(1000);
    double last = 0;
    ParallelRanges(
        1000,
        7,
        [&](int begin, int end) {
          for (int i = begin; i < end; ++i) ++seen[static_cast<std::size_t>(i)];
        },
        [&](double done) {
          EXPECT_GE(done, last);
          last = done;
          return true;
        });
    for (const auto& count : seen) EXPECT_EQ(count, 1);
    EXPECT_EQ(last, 1.0);
  }
  SetThreadCount(0);
}

TEST(ParallelRanges, StopsWhenProgressAnswersNo) {
  EXPECT_THROW(ParallelRanges(
                   1000, 1, [](int, int) {}, [](double done) { return done < 0.5; }),
               Cancelled);
}

}  // namespace
}  // namespace relight
