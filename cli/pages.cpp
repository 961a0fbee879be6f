// SPDX-License-Identifier: Apache-2.0

// The man page and the shells' completions, made from the flags themselves.

#include "cli/verbs.h"
#include "relight/base/version.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace relight::cli {
namespace {

// Verbs that are shown: hidden ones have an empty group.
std::vector<const CLI::App*> VerbsOf(const CLI::App& program) {
  return program.get_subcommands(
      [](const CLI::App* app) { return !app->get_group().empty(); });
}

std::vector<std::string> FlagsOf(const CLI::App& app) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    for (const std::string& name : option->get_snames()) flags.push_back("-" + name);
  }
  return flags;
}

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// Text as roff takes it.
std::string Roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
  }
  return escaped.starts_with('.') || escaped.starts_with('\'') ? "\\&" + escaped
                                                               : escaped;
}

void PrintOptions(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    std::string names;
    for (const std::string& name : option->get_snames()) names += "-" + name + ", ";
    for (const std::string& name : option->get_lnames()) names += "--" + name + ", ";
    if (names.empty()) {
      names = option->get_type_name();
    } else {
      names.resize(names.size() - 2);
      if (option->get_items_expected_max() > 0) names += " " + option->get_type_name();
    }
    fmt::print(".TP\n.B {}\n{}\n", Roff(names), Roff(option->get_description()));
  }
}

int PrintMan(const CLI::App& program) {
  fmt::print(".TH RELIGHT 1 \"\" \"relight {}\"\n.SH NAME\nrelight \\- {}\n",
             Version(),
             Roff(program.get_description()));
  fmt::print(".SH SYNOPSIS\n");
  for (const CLI::App* verb : VerbsOf(program)) {
    fmt::print(".B relight {}\n[options]\n.br\n", Roff(verb->get_name()));
  }
  fmt::print(".SH DESCRIPTION\n{}\n.SH OPTIONS\n", Roff(program.get_footer()));
  PrintOptions(program);
  for (const CLI::App* verb : VerbsOf(program)) {
    fmt::print(
        ".SH relight {}\n{}\n", Roff(verb->get_name()), Roff(verb->get_description()));
    PrintOptions(*verb);
  }
  fmt::print(
      ".SH EXIT STATUS\n0 done, 1 input cannot be used, 2 wrong usage, 130 stopped.\n"
      ".SH ENVIRONMENT\n.TP\n.B OCIO\nan OpenColorIO configuration for the photos' "
      "colours\n"
      ".TP\n.B RELIGHT_DATA\nthe folder of the program's own data\n");
  return 0;
}

void PrintBash(const CLI::App& program) {
  fmt::print(
      "_relight() {{\n  local cur=${{COMP_WORDS[COMP_CWORD]}} words=\n"
      "  case ${{COMP_WORDS[1]}} in\n");
  std::vector<std::string> names;
  for (const CLI::App* verb : VerbsOf(program)) {
    names.push_back(verb->get_name());
    fmt::print("    {}) words=\"{}\" ;;\n", verb->get_name(), Joined(FlagsOf(*verb)));
  }
  fmt::print(
      "  esac\n  if [ \"$COMP_CWORD\" = 1 ]; then words=\"{} {}\"; fi\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
      "  case $cur in -*) ;; *) COMPREPLY+=($(compgen -f -- \"$cur\")) ;; esac\n}}\n"
      "complete -o filenames -F _relight relight\n",
      Joined(names),
      Joined(FlagsOf(program)));
}

void PrintZsh(const CLI::App& program) {
  fmt::print(
      "#compdef relight\n_relight() {{\n  if (( CURRENT == 2 )); then\n"
      "    local -a verbs=(\n");
  for (const CLI::App* verb : VerbsOf(program)) {
    fmt::print("      '{}:{}'\n", verb->get_name(), verb->get_description());
  }
  fmt::print(
      "    )\n    _describe verb verbs\n    _files\n    return\n  fi\n"
      "  case $words[2] in\n");
  for (const CLI::App* verb : VerbsOf(program)) {
    fmt::print("    {}) compadd -- {} ;;\n", verb->get_name(), Joined(FlagsOf(*verb)));
  }
  fmt::print("  esac\n  _files\n}}\n_relight \"$@\"\n");
}

std::string FishQuoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return quoted + "'";
}

void PrintFish(const CLI::App& program) {
  for (const CLI::App* verb : VerbsOf(program)) {
    fmt::print("complete -c relight -n __fish_use_subcommand -a {} -d {}\n",
               verb->get_name(),
               FishQuoted(verb->get_description()));
    for (const CLI::Option* option : verb->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        fmt::print(
            "complete -c relight -n '__fish_seen_subcommand_from {}' -l {} -d {}\n",
            verb->get_name(),
            name,
            FishQuoted(option->get_description()));
      }
    }
  }
}

}  // namespace

Verb AddMan(CLI::App& program) {
  CLI::App* app = program.add_subcommand("man", "Print the man page")->group("");
  return {app, [&program] { return PrintMan(program); }};
}

Verb AddCompletion(CLI::App& program) {
  CLI::App* app =
      program.add_subcommand("completion", "Print a shell's completions")->group("");
  auto shell = std::make_shared<std::string>();
  app->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  return {app, [&program, shell] {
            if (*shell == "bash") PrintBash(program);
            if (*shell == "zsh") PrintZsh(program);
            if (*shell == "fish") PrintFish(program);
            return 0;
          }};
}

}  // namespace relight::cli
