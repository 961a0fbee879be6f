// SPDX-License-Identifier: Apache-2.0
#pragma once

// What each stage of a capture depended on, and what it made: cache/stages.json. A stage
// is up to date when the hash of its inputs and options is as recorded and its files are
// there with the content it made. Files are known by content, never by time.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace relight {

class StageRecords {
 public:
  // Records of the capture in `folder`; a file that cannot be read counts as empty, so
  // that the stages run again.
  explicit StageRecords(const std::filesystem::path& folder);

  enum class State {
    kMissing,  // Never made, or a file is gone.
    kStale,    // Made from other inputs or options.
    kEdited,   // Up to date, but somebody changed a file since.
    kUpToDate,
  };
  State StateOf(const std::string& stage, const std::string& key) const;

  // Whether `file` (below the folder) is as some stage made it.
  bool IsOurs(const std::filesystem::path& file) const;

  // Remembers what `stage` made, hashing `files`, and writes the records.
  void Remember(const std::string& stage,
                const std::string& key,
                const std::vector<std::filesystem::path>& files);

 private:
  struct Record {
    std::string key;
    std::map<std::string, std::string> hash_of_file;  // Path below the folder.
  };
  std::filesystem::path folder_;
  std::map<std::string, Record> records_;
};

// One text for what a stage depends on; the order of the parts counts.
class StageKey {
 public:
  explicit StageKey(std::string stage_and_version)
      : text_(std::move(stage_and_version)) {}
  StageKey& Add(const std::string& part);
  StageKey& AddFile(const std::filesystem::path& file);
  std::string Hash() const;

 private:
  std::string text_;
};

}  // namespace relight
