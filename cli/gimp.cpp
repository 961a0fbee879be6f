// SPDX-License-Identifier: Apache-2.0

// relight gimp --check: what GIMP 2.10 will see of the plug-in, and why not.

#include "cli/console.h"
#include "cli/verbs.h"
#include "relight/base/child_process.h"
#include "relight/base/error.h"
#include "relight/base/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;

std::string Variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): not written
  return value != nullptr ? value : "";
}

bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

struct Gimp {
  fs::path program;
  std::string version;  // "2.10.34".
};

// What a program prints when asked for its version; `fine`: it ended well.
std::string Answer(const fs::path& program, bool& fine) {
  ChildProcess process(program, {"--version"}, ChildProcess::Output::kWithMessages);
  std::string text;
  fine = process.Finish(&text);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::optional<Gimp> FindGimp() {
  for (const char* name : {"gimp-2.10", "gimp-console-2.10", "gimp"}) {
    const auto program = FindProgram(name);
    if (!program) continue;
    bool fine = false;
    const std::string text = Answer(*program, fine);
    std::istringstream words(text);
    for (std::string word; words >> word;) {
      int number = 0, used = 0;
      if (std::sscanf(word.c_str(), "%d.%*d.%d%n", &number, &number, &used) == 2)
        return Gimp{*program, word.substr(0, static_cast<std::size_t>(used))};
    }
    return Gimp{*program, ""};
  }
  return {};
}

fs::path ProfileFolder() {
  if (const std::string own = Variable("GIMP2_DIRECTORY"); !own.empty()) return own;
  const std::string config = Variable("XDG_CONFIG_HOME");
  const fs::path base =
      config.empty() ? fs::path(Variable("HOME")) / ".config" : fs::path(config);
  return base / "GIMP" / "2.10";
}

// GIMP's own folder: below the prefix that its program is in.
fs::path SystemFolder(const Gimp& gimp) {
  if (const std::string own = Variable("GIMP2_PLUGINDIR"); !own.empty()) return own;
  std::error_code ignored;
  const fs::path lib =
      fs::canonical(gimp.program, ignored).parent_path().parent_path() / "lib";
  std::vector<fs::path> candidates = {lib, lib.string() + "64"};
  for (const auto& entry : fs::directory_iterator(lib, ignored))
    candidates.push_back(entry.path());
  for (const fs::path& folder : candidates) {
    if (IsFolder(folder / "gimp" / "2.0" / "plug-ins")) return folder / "gimp" / "2.0";
  }
  return lib / "gimp" / "2.0";
}

// The last (plug-in-path "…") of GIMP's settings, or its default, with names filled in.
std::vector<fs::path> PluginFolders(const Gimp& gimp) {
  const fs::path profile = ProfileFolder();
  std::string path = "${gimp_dir}/plug-ins:${gimp_plug_in_dir}/plug-ins";
  for (const fs::path& file : {fs::path("/etc/gimp/2.0/gimprc"), profile / "gimprc"}) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string name;
      if (words >> name && name == "(plug-in-path") words >> std::quoted(path);
    }
  }
  const auto fill = [&](const std::string& name, const fs::path& folder) {
    for (std::size_t at = path.find(name); at != std::string::npos; at = path.find(name))
      path.replace(at, name.size(), folder.string());
  };
  fill("${gimp_dir}", profile);
  fill("${gimp_plug_in_dir}", SystemFolder(gimp));
  fill("${HOME}", Variable("HOME"));
  std::vector<fs::path> folders;
  std::istringstream parts(path);
  for (std::string part; std::getline(parts, part, ':');) {
    if (!part.empty()) folders.emplace_back(part);
  }
  return folders;
}

struct Finding {
  std::optional<Gimp> gimp;
  std::vector<fs::path> folders;
  fs::path plugin;
  std::string version;
  std::string fault, remedy;  // Empty: GIMP will see it.
};

Finding Look() {
  Finding f;
  const auto fault = [&](const std::string& what, const std::string& remedy) {
    f.fault = what;
    f.remedy = remedy;
    return f;
  };
  const char* install =
      "./bootstrap install, or ./bootstrap install --user for you alone";
  f.gimp = FindGimp();
  if (!f.gimp) {
    return fault("GIMP is not installed, or not on PATH",
                 "install GIMP 2.10: apt-get install gimp");
  }
  if (!f.gimp->version.starts_with("2.10.")) {
    return fault(f.gimp->program.string() + " is GIMP " + f.gimp->version +
                     ", and the plug-in is for 2.10",
                 "install GIMP 2.10");
  }
  f.folders = PluginFolders(*f.gimp);
  std::error_code ignored;
  for (const fs::path& folder : f.folders) {
    f.plugin = folder / "relight-tree" / "relight-tree";
    if (fs::is_regular_file(f.plugin, ignored)) break;
    f.plugin.clear();
  }
  if (f.plugin.empty()) {
    for (const fs::path& folder : f.folders) {
      if (fs::is_regular_file(folder / "relight-tree", ignored)) {
        return fault((folder / "relight-tree").string() +
                         " is not in a folder of its own, where GIMP looks",
                     "move it to " + (folder / "relight-tree" / "relight-tree").string());
      }
    }
    return fault("no folder that GIMP looks in has relight-tree/relight-tree", install);
  }
  if (access(f.plugin.c_str(), X_OK) != 0) {
    return fault(f.plugin.string() + " is not executable",
                 "chmod +x " + f.plugin.string());
  }
  bool fine = false;
  std::string answer;
  try {
    answer = Answer(f.plugin, fine);
  } catch (const InputError& error) {
    return fault(error.what(), std::string("install it again: ") + install);
  }
  const std::string known = "relight-tree ";
  if (!fine || !answer.starts_with(known)) {
    return fault(f.plugin.string() + " does not start: " + answer,
                 std::string("install what it lacks, or build it again: ") + install);
  }
  f.version = answer.substr(known.size());
  if (f.version != Version()) {
    return fault(f.plugin.string() + " is of version " + f.version +
                     ", this program of " + Version(),
                 std::string("install both again: ") + install);
  }
  return f;
}

int Check(const ConsoleOptions& console, bool as_json) {
  const Finding f = Look();
  const bool seen = f.fault.empty();
  if (as_json) {
    nlohmann::json json = {{"seen", seen}, {"folders", nlohmann::json::array()}};
    if (f.gimp)
      json["gimp"] = {{"program", f.gimp->program.string()},
                      {"version", f.gimp->version}};
    for (const fs::path& folder : f.folders)
      json["folders"].push_back(
          {{"folder", folder.string()}, {"exists", IsFolder(folder)}});
    if (!f.plugin.empty()) json["plugin"] = f.plugin.string();
    if (!f.version.empty()) json["version"] = f.version;
    if (!seen) {
      json["fault"] = f.fault;
      json["remedy"] = f.remedy;
    }
    fmt::print("{}\n", json.dump(1));
    return seen ? 0 : 1;
  }
  if (!console.quiet) {
    if (f.gimp) fmt::print("GIMP {}: {}\n", f.gimp->version, f.gimp->program.string());
    for (const fs::path& folder : f.folders) {
      fmt::print("looks for plug-ins in {}{}\n",
                 folder.string(),
                 IsFolder(folder) ? "" : " (not there)");
    }
    if (!f.plugin.empty()) fmt::print("plug-in: {} {}\n", f.plugin.string(), f.version);
  }
  if (!seen)
    throw InputError("GIMP will not see Relight Tree: " + f.fault + "; " + f.remedy);
  if (!console.quiet)
    fmt::print("GIMP will see it: Filters > Light and Shadow > Relight Tree...\n");
  return 0;
}

}  // namespace

Verb AddGimp(CLI::App& program, const ConsoleOptions& console) {
  CLI::App* app =
      program.add_subcommand("gimp", "Whether GIMP 2.10 will see the plug-in");
  auto check = std::make_shared<bool>(false);
  auto as_json = std::make_shared<bool>(false);
  app->add_flag("--check", *check, "say what GIMP will see, and why not")->required();
  app->add_flag("--json", *as_json, "print as JSON");
  return {app, [as_json, &console] { return Check(console, *as_json); }};
}

}  // namespace relight::cli
