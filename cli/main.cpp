// SPDX-License-Identifier: Apache-2.0

// relight: verbs, exit codes, one catch. 0 done, 1 input cannot be used, 2 wrong usage,
// 130 stopped.

#include "cli/verbs.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/base/version.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <vector>

namespace {

constexpr int kBadInput = 1, kBadUsage = 2, kStopped = 130;

int Main(std::vector<std::string> words) {
  using namespace relight::cli;
  CLI::App program("Relights photographs of trees to another hour of the day", "relight");
  program.set_version_flag("--version", std::string("relight ") + relight::Version());
  program.require_subcommand(1);
  program.fallthrough();
  program.get_formatter()->column_width(34);
  program.footer(
      "relight DIR|PHOTO --to WHEN is short for relight hour. \"relight VERB --help\" "
      "tells "
      "more.\nExit codes: 0 done, 1 input cannot be used, 2 wrong usage, 130 stopped.");
  ConsoleOptions console;
  program.add_flag("-q,--quiet", console.quiet, "say nothing but errors");
  program.add_option("--threads", console.threads, "threads to use; 0: one a core [0]")
      ->type_name("N")
      ->check(CLI::Range(0, 1024).description(""));

  const std::vector<Verb> verbs = {AddHour(program, console),
                                   AddDay(program, console),
                                   AddInit(program, console),
                                   AddCameras(program, console),
                                   AddMatte(program, console),
                                   AddVolume(program, console),
                                   AddSky(program, console),
                                   AddInfo(program, console),
                                   AddEvaluate(program, console),
                                   AddClean(program, console),
                                   AddGimp(program, console),
                                   AddMan(program),
                                   AddCompletion(program)};

  if (words.empty()) {
    fmt::print(stderr,
               "relight: say what to relight and to which hour: relight DIR|PHOTO --to "
               "17:00; see relight --help\n");
    return kBadUsage;
  }

  // A first word, after the program's own flags, that is no verb is what `hour` works on
  auto first = words.begin();
  while (first != words.end() && first->starts_with("-")) {
    first += *first == "--threads" && first + 1 != words.end() ? 2 : 1;
  }
  const bool has_verb = first == words.end() ||
                        std::any_of(verbs.begin(), verbs.end(), [&](const Verb& verb) {
                          return verb.app->get_name() == *first;
                        });
  if (!has_verb && first->find_first_of("./") == std::string::npos &&
      !std::filesystem::exists(*first)) {
    std::string names;
    for (const Verb& verb : verbs) {
      if (verb.app->get_group().empty()) continue;
      names += (names.empty() ? "" : ", ") + verb.app->get_name();
    }
    fmt::print(stderr,
               "relight: \"{}\" is neither a verb ({}) nor a photo or folder that is "
               "there; see relight --help\n",
               *first,
               names);
    return kBadUsage;
  }
  if (!has_verb) words.insert(first, "hour");
  std::reverse(words.begin(), words.end());  // As CLI11 takes them
  try {
    program.parse(words);
  } catch (const CLI::Success& wanted) {
    program.exit(wanted);  // Help, version
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr,
               "relight: {}; see relight{} --help\n",
               error.what(),
               program.get_subcommands().empty()
                   ? ""
                   : " " + program.get_subcommands().front()->get_name());
    return kBadUsage;
  }
  relight::SetThreadCount(console.threads);
  for (const Verb& verb : verbs) {
    if (verb.app->parsed()) return verb.run();
  }
  return kBadUsage;
}

}  // namespace

int main(int argc, char** argv) {
  relight::cli::ListenForStop();
  try {
    const int code = Main(std::vector<std::string>(argv + 1, argv + argc));
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      fmt::print(
          stderr,
          "relight: standard output cannot be written: {}; free some space or send "
          "it elsewhere\n",
          std::generic_category().message(errno));
      return kBadInput;
    }
    return code;
  } catch (const relight::Cancelled&) {
    fmt::print(stderr, "relight: stopped; nothing half-written is left\n");
    return kStopped;
  } catch (const relight::OptionError& error) {
    fmt::print(stderr, "relight: {}\n", error.what());
    return kBadUsage;
  } catch (const relight::Error& error) {
    fmt::print(stderr, "relight: {}\n", error.what());
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr,
               "relight: {}: {}; check the path, and what you may read and write there\n",
               error.path1().string(),
               error.code().message());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    fmt::print(
        stderr,
        "relight: not enough memory for pictures of this size; close other programs or "
        "make the photo smaller\n");
    return kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr,
               "relight: {} (this is an error of relight; please report it)\n",
               error.what());
    return kBadInput;
  }
}
