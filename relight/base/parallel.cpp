// SPDX-License-Identifier: Apache-2.0
#include "relight/base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <mutex>

namespace relight {

void ParallelRanges(int count,
                    int grain,
                    const std::function<void(int begin, int end)>& body,
                    const Progress& progress) {
  if (count <= 0) return;
  const int step = std::max(grain, 1);
  const int pieces = (count - 1) / step + 1;
  std::mutex reporting;
  int done = 0;
  tbb::parallel_for(0, pieces, [&](int piece) {
    const int begin = piece * step;
    body(begin, begin + std::min(step, count - begin));
    const std::lock_guard lock(reporting);
    progress.Report(static_cast<double>(++done) / pieces);
  });
}

void SetThreadCount(int threads) {
  static std::unique_ptr<tbb::global_control> limit;
  limit.reset();
  if (threads > 0) {
    limit = std::make_unique<tbb::global_control>(
        tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  }
}

}  // namespace relight
