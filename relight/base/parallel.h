// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parallel loops whose result does not depend on the number of threads: each call of
// `body` owns its range, and sums are made by the caller in a fixed order.

#include "relight/base/progress.h"

#include <functional>

namespace relight {

// Calls body(begin, end) over disjoint pieces of [0, count), each at most `grain` long,
// in any order and on any thread. The pieces do not depend on the number of threads.
// An exception of a body ends the loop and is thrown on. `progress` is reported from
// one thread at a time; throws Cancelled.
void ParallelRanges(int count,
                    int grain,
                    const std::function<void(int begin, int end)>& body,
                    const Progress& progress = {});

// Limits the threads that loops of this process use; 0: as many as there are cores.
void SetThreadCount(int threads);

}  // namespace relight
