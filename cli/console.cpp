// SPDX-License-Identifier: Apache-2.0
#include "cli/console.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>

namespace relight::cli {
namespace {

volatile std::sig_atomic_t g_stop = 0;  // A signal handler may write nothing else

extern "C" void OnStop(int signal) {
  g_stop = 1;
  std::signal(signal, SIG_DFL);
}

std::string Seconds(double s) {
  return s < 90 ? fmt::format("{:.0f} s", std::max(s, 1.0))
                : fmt::format("{:.0f} min", s / 60);
}

// One line that is written over as work goes on.
class Line {
 public:
  Line(std::string name, double expected_s)
      : name_(std::move(name)), expected_s_(expected_s) {}
  ~Line() { Clear(); }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  void Show(double done) {
    const auto now = std::chrono::steady_clock::now();
    if (done >= 1) return Clear();
    if (now - shown_ < std::chrono::milliseconds(100)) return;
    shown_ = now;
    const double spent_s = std::chrono::duration<double>(now - start_).count();
    const double left_s =
        done > 0.02 ? spent_s * (1 - done) / done : std::max(expected_s_ - spent_s, 0.0);
    fmt::print(stderr,
               "\rrelight: {} {:3.0f} %, {} left \033[K",
               name_,
               100 * done,
               Seconds(left_s));
    std::fflush(stderr);
    visible_ = true;
  }

 private:
  void Clear() {
    if (visible_) fmt::print(stderr, "\r\033[K");
    visible_ = false;
  }
  std::string name_;
  double expected_s_;
  bool visible_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_ = {};
};

}  // namespace

void ListenForStop() {
  std::signal(SIGINT, OnStop);
  std::signal(SIGTERM, OnStop);
  std::signal(SIGXFSZ,
              SIG_IGN);  // Too large a file is an error of writing, not our death
}

void Say(const ConsoleOptions& options, const std::string& text) {
  if (!options.quiet) fmt::print(stderr, "relight: {}\n", text);
}

void SayAll(const ConsoleOptions& options, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) Say(options, text);
}

Progress ShowProgress(const ConsoleOptions& options,
                      const std::string& name,
                      double expected_s) {
  std::shared_ptr<Line> line;
  if (!options.quiet && isatty(STDERR_FILENO))
    line = std::make_shared<Line>(name, expected_s);
  return [line](double done) {
    if (line) line->Show(done);
    return g_stop == 0;
  };
}

StageStart ShowStages(const ConsoleOptions& options,
                      const std::vector<PlannedStage>& stages) {
  double total_s = 0;
  for (const PlannedStage& stage : stages) {
    total_s += stage.expected_s;
    Say(options,
        fmt::format("will run {}: {} (about {})",
                    stage.name,
                    stage.what,
                    Seconds(stage.expected_s)));
  }
  if (stages.size() > 1) Say(options, fmt::format("about {} in all", Seconds(total_s)));
  return [options](const PlannedStage& stage) {
    if (!isatty(STDERR_FILENO)) Say(options, stage.name + "…");
    return ShowProgress(options, stage.name, stage.expected_s);
  };
}

}  // namespace relight::cli
