// SPDX-License-Identifier: Apache-2.0
#pragma once

// Progress of one piece of work, and the way to stop it.

#include "relight/base/error.h"

#include <functional>
#include <utility>

namespace relight {

// A callback that is told the fraction done, in [0, 1], and answers false to stop.
// A default-made Progress reports to nobody and never stops. The callback may be
// called from any thread, but never from two at once.
class Progress {
 public:
  Progress() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a lambda is a Progress
  template <class Callback>
  requires std::is_invocable_r_v<bool, Callback, double> Progress(Callback callback)
      : callback_(std::move(callback)) {}

  // Throws Cancelled when the callback answers false.
  void Report(double done) const {
    if (callback_ && !callback_(from_ + (to_ - from_) * done)) throw Cancelled();
  }

  // The part [from, to] of this progress, for a piece of the work.
  Progress Part(double from, double to) const {
    Progress part = *this;
    part.from_ = from_ + (to_ - from_) * from;
    part.to_ = from_ + (to_ - from_) * to;
    return part;
  }

 private:
  std::function<bool(double)> callback_;
  double from_ = 0.0, to_ = 1.0;
};

}  // namespace relight
