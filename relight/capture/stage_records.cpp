// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/stage_records.h"

#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/capture/capture_folder.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace relight {
namespace fs = std::filesystem;

StageRecords::StageRecords(const fs::path& folder) : folder_(folder) {
  const fs::path file = folder / "cache" / "stages.json";
  if (!fs::exists(file)) return;
  const auto json = nlohmann::json::parse(
      ReadText(file, 50'000'000), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return;
  for (const auto& [stage, entry] : json.items()) {
    if (!entry.is_object() || !entry.contains("key") || !entry.contains("files"))
      continue;
    if (!entry["key"].is_string() || !entry["files"].is_object()) continue;
    Record record{entry["key"].get<std::string>(), {}};
    for (const auto& [path, hash] : entry["files"].items()) {
      if (hash.is_string()) record.hash_of_file[path] = hash.get<std::string>();
    }
    records_[stage] = record;
  }
}

StageRecords::State StageRecords::StateOf(const std::string& stage,
                                          const std::string& key) const {
  const auto found = records_.find(stage);
  if (found == records_.end()) return State::kMissing;
  bool edited = false;
  for (const auto& [path, hash] : found->second.hash_of_file) {
    const fs::path file = folder_ / path;
    if (!fs::is_regular_file(file)) return State::kMissing;
    edited = edited || HashOfFile(file) != hash;
  }
  if (edited) return State::kEdited;
  return found->second.key == key ? State::kUpToDate : State::kStale;
}

bool StageRecords::IsOurs(const fs::path& file) const {
  const std::string path = file.generic_string();
  return std::any_of(records_.begin(), records_.end(), [&](const auto& entry) {
    const auto found = entry.second.hash_of_file.find(path);
    return found != entry.second.hash_of_file.end() &&
           HashOfFile(folder_ / file) == found->second;
  });
}

void StageRecords::Remember(const std::string& stage,
                            const std::string& key,
                            const std::vector<fs::path>& files) {
  Record record{key, {}};
  for (const fs::path& file : files) {
    record.hash_of_file[file.generic_string()] = HashOfFile(folder_ / file);
  }
  records_[stage] = record;
  nlohmann::json json;
  for (const auto& [name, entry] : records_) {
    json[name] = {{"key", entry.key}, {"files", entry.hash_of_file}};
  }
  WriteTextWhole(MakeFolderOf(folder_, "cache") / "stages.json", json.dump(1) + "\n");
}

StageKey& StageKey::Add(const std::string& part) {
  text_ += "\n" + std::to_string(part.size()) + ":" + part;
  return *this;
}

StageKey& StageKey::AddFile(const fs::path& file) { return Add(HashOfFile(file)); }

std::string StageKey::Hash() const { return HashOfText(text_); }

}  // namespace relight
