// SPDX-License-Identifier: Apache-2.0
#pragma once

// The verbs of the program, one file each. Each adds its subcommand to the program; what
// it answers runs the verb after parsing, and returns the exit code.

#include "cli/console.h"

#include <CLI/CLI.hpp>

#include <functional>

namespace relight::cli {

using Run = std::function<int()>;

struct Verb {
  CLI::App* app = nullptr;
  Run run;
};

Verb AddInit(CLI::App& program, const ConsoleOptions& console);
Verb AddCameras(CLI::App& program, const ConsoleOptions& console);
Verb AddMatte(CLI::App& program, const ConsoleOptions& console);
Verb AddVolume(CLI::App& program, const ConsoleOptions& console);
Verb AddHour(CLI::App& program, const ConsoleOptions& console);
Verb AddDay(CLI::App& program, const ConsoleOptions& console);
Verb AddSky(CLI::App& program, const ConsoleOptions& console);
Verb AddEvaluate(CLI::App& program, const ConsoleOptions& console);
Verb AddInfo(CLI::App& program, const ConsoleOptions& console);
Verb AddClean(CLI::App& program, const ConsoleOptions& console);
Verb AddGimp(CLI::App& program, const ConsoleOptions& console);

// Hidden: `relight man`, `relight completion bash|zsh|fish`, made from the program's
// flags.
Verb AddMan(CLI::App& program);
Verb AddCompletion(CLI::App& program);

}  // namespace relight::cli
