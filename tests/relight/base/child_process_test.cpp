// SPDX-License-Identifier: Apache-2.0
#include "relight/base/child_process.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>

namespace relight {
namespace {
namespace fs = std::filesystem;

fs::path Program(const char* name) {
  const auto found = FindProgram(name);
  EXPECT_TRUE(found) << name;
  return found.value_or("/nowhere");
}

TEST(ChildProcess, IsFoundOnPath) {
  EXPECT_TRUE(Program("sh").is_absolute());
  EXPECT_FALSE(FindProgram("no-program-of-this-name"));
}

TEST(ChildProcess, ReadsWhatIsWrittenAndItsWordsAreNotAShells) {
  const fs::path file =
      fs::temp_directory_path() / ("relight child " + std::to_string(getpid()));
  {
    ChildProcess tee(Program("tee"), {file.string(), "--", "/dev/null"});
    EXPECT_TRUE(tee.Write("one "));
    EXPECT_TRUE(tee.Write(std::string(1 << 20, 'x')));  // More than a pipe holds
    EXPECT_TRUE(tee.Finish(nullptr));
  }
  EXPECT_EQ(ReadText(file).size(), 4u + (1 << 20));
  fs::remove(file);
}

TEST(ChildProcess, SaysWhyItFailed) {
  ChildProcess ls(Program("ls"), {"/no folder $(of) this; name"});
  std::string messages;
  EXPECT_FALSE(ls.Finish(&messages));
  EXPECT_NE(messages.find("/no folder $(of) this; name"), std::string::npos) << messages;
}

TEST(ChildProcess, ThatReadsNoMoreIsNoticed) {
  ChildProcess program(Program("true"), {});
  bool reads = true;
  for (int i = 0; i < 1000 && reads; ++i)
    reads = program.Write(std::string(1 << 16, 'x'));
  EXPECT_FALSE(reads);
}

TEST(ChildProcess, GoesWithItsObject) {
  const auto start = std::chrono::steady_clock::now();
  { ChildProcess sleep(Program("sleep"), {"600"}); }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  EXPECT_THROW(ChildProcess("/nowhere/program", {}), InputError);
}

TEST(RemoveLeftovers, TakesThoseOfDeadProcessesAlone) {
  const fs::path folder =
      fs::temp_directory_path() / ("relight-left-" + std::to_string(getpid()));
  fs::create_directories(folder);
  // A process number beyond what Linux gives (2^22) is nobody's
  const fs::path dead = folder / ".frame.part-99999999-0.png";
  const fs::path ours = TemporaryFor(folder / "frame.png");
  const fs::path other = folder / ".frame.part-of-somebody.png";
  for (const fs::path& file : {dead, ours, other}) WriteTextWhole(file, "x");
  RemoveLeftovers(folder);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(ours));
  EXPECT_TRUE(fs::exists(other));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace relight
