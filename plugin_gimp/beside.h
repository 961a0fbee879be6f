// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work in a thread of its own, while the thread that GIMP and GTK know goes on.

#include "relight/base/progress.h"

#include <atomic>
#include <chrono>
#include <future>
#include <utility>

namespace relight::gimp {

// Calls work(progress), and `tick` with the fraction done some 25 times a second, in the
// calling thread, until the work is done; a tick that answers false stops it. Answers, or
// throws, what the work does.
template <class Work, class Tick>
auto Beside(Work&& work, Tick&& tick) {
  std::atomic<double> done = 0;
  std::atomic<bool> stop = false;
  auto result = std::async(std::launch::async, [&] {
    return work(Progress([&](double fraction) {
      done = fraction;
      return !stop;
    }));
  });
  while (result.wait_for(std::chrono::milliseconds(40)) != std::future_status::ready) {
    if (!tick(done.load())) stop = true;
  }
  return result.get();
}

}  // namespace relight::gimp
