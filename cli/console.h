// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a person sees on stderr: one line a fact, progress with the time left on a
// terminal, plain lines in a log. Results go to stdout and are no business of this.

#include "relight/base/progress.h"
#include "relight/capture/relit_hour.h"

#include <string>
#include <vector>

namespace relight::cli {

struct ConsoleOptions {
  bool quiet = false;  // Errors only.
  int threads = 0;     // 0: all cores.
};

// From here on Ctrl-C, or a polite request to end, stops work at the next report of
// progress; a second one ends the program at once.
void ListenForStop();

// "relight: TEXT" unless quiet.
void Say(const ConsoleOptions& options, const std::string& text);
void SayAll(const ConsoleOptions& options, const std::vector<std::string>& texts);

// Progress of one stage of work, shown under its name; throws Cancelled after a stop.
Progress ShowProgress(const ConsoleOptions& options,
                      const std::string& name,
                      double expected_s = 0.0);

// Shows the stages before work begins, and answers what RunHour calls at each.
StageStart ShowStages(const ConsoleOptions& options,
                      const std::vector<PlannedStage>& stages);

}  // namespace relight::cli
