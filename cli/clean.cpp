// SPDX-License-Identifier: Apache-2.0
#include "cli/verbs.h"
#include "relight/capture/capture.h"
#include "relight/capture/tree_volume.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace relight::cli {
namespace {

int RunVerb(const std::filesystem::path& folder, const ConsoleOptions& console) {
  const std::optional<LightCache> cache = CleanLight(OpenCapture(folder));
  if (!cache) {
    Say(console, folder.string() + ": nothing to remove");
  } else if (!cache->is_ours) {
    Say(console,
        cache->file.string() +
            ": not as relight made it, and left as it is; remove it "
            "yourself when you do not need it");
  } else {
    Say(console,
        fmt::format("{}: removed, {:.1f} MB; it is made again when it is needed",
                    cache->file.string(),
                    1e-6 * static_cast<double>(cache->bytes)));
  }
  return 0;
}

}  // namespace

Verb AddClean(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app = program.add_subcommand(
      "clean", "Remove what a capture keeps for speed alone: cache/light.vdb");
  auto folder = std::make_shared<std::filesystem::path>();
  app->add_option("folder", *folder, "the capture folder")->required()->type_name("DIR");
  return {app, [folder, &console] { return RunVerb(*folder, console); }};
}

}  // namespace relight::cli
