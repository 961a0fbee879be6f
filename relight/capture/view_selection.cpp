// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/view_selection.h"

#include "relight/base/angles.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace relight {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

// Indices into `azimuths`, which ascend: from `start` on, each the next that is
// `step_rad` or more from the one before, and the last as far from the first; at most
// `wanted`.
std::vector<std::size_t> StepsFrom(std::size_t start,
                                   const std::vector<double>& azimuths,
                                   double step_rad,
                                   std::size_t wanted) {
  std::vector<std::size_t> taken = {start};
  double last = 0;  // Azimuth from the start's.
  for (std::size_t i = 1; i < azimuths.size() && taken.size() < wanted; ++i) {
    const std::size_t at = (start + i) % azimuths.size();
    double from_start = azimuths[at] - azimuths[start];
    if (at < start) from_start += kTurn_rad;
    if (from_start - last < step_rad) continue;
    if (kTurn_rad - from_start < step_rad) break;
    taken.push_back(at);
    last = from_start;
  }
  return taken;
}

}  // namespace

std::map<std::string, Camera> EvenlySpreadViews(
    const std::map<std::string, Camera>& cameras, const ViewSelectionOptions& options) {
  CheckFields(options);
  const auto wanted = static_cast<std::size_t>(options.most_views);
  if (cameras.size() <= wanted) return cameras;

  // Around the tree, from the first by name
  std::vector<std::pair<double, std::string>> views;
  const double first = AzimuthOf(cameras.begin()->second.PositionInWorld());
  for (const auto& [name, camera] : cameras) {
    const double from_first = AzimuthOf(camera.PositionInWorld()) - first;
    views.emplace_back(from_first < 0 ? from_first + kTurn_rad : from_first, name);
  }
  std::sort(views.begin(), views.end());
  std::vector<double> azimuths;
  for (const auto& view : views) azimuths.push_back(view.first);

  // The largest step that leaves as many as wanted, by halving
  const auto with_step = [&](double step_rad) {
    for (std::size_t start = 0; start < azimuths.size(); ++start) {
      std::vector<std::size_t> taken = StepsFrom(start, azimuths, step_rad, wanted);
      if (taken.size() == wanted) return taken;
    }
    return std::vector<std::size_t>();
  };
  double possible = 0, too_large = kTurn_rad;
  for (int i = 0; i < 30; ++i) {
    const double step_rad = (possible + too_large) / 2;
    (with_step(step_rad).empty() ? too_large : possible) = step_rad;
  }
  std::map<std::string, Camera> chosen;
  for (const std::size_t i : with_step(possible))
    chosen.insert(*cameras.find(views[i].second));
  return chosen;
}

}  // namespace relight
