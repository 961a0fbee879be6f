// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/another_tree.h"

#include "relight/base/angles.h"

#include <algorithm>
#include <optional>

namespace relight {
namespace {

constexpr std::size_t kFewest = 4;
constexpr std::size_t kMostForPoints = 60;  // Pairs among so many give the candidates.
constexpr double kMargin = 0.25;            // Of the picture, on each side.
constexpr double kParallel_rad = RadFromDeg(10.0);

double OffAxis(const Camera& camera, const Eigen::Vector3d& point) {
  return AngleBetween(camera.ForwardInWorld(), point - camera.PositionInWorld());
}

bool Sees(const Camera& camera, const Eigen::Vector3d& point) {
  const auto pixel = camera.Project(point);
  return pixel && std::abs(pixel->x() / camera.width_px - 0.5) <= 0.5 + kMargin &&
         std::abs(pixel->y() / camera.height_px - 0.5) <= 0.5 + kMargin;
}

// Halfway between the axes where they are nearest, in front of both cameras:
//
//   p = o + s a, q = o' + t b,   (p - q) . a = (p - q) . b = 0
std::optional<Eigen::Vector3d> MeetingPoint(const Camera& first, const Camera& second) {
  const Eigen::Vector3d a = first.ForwardInWorld(), b = second.ForwardInWorld();
  if (std::min(AngleBetween(a, b), AngleBetween(a, -b)) < kParallel_rad) return {};
  const Eigen::Vector3d o = first.PositionInWorld(), apart = second.PositionInWorld() - o;
  const double cosine = a.dot(b), sine2 = 1 - cosine * cosine;
  const double s = (apart.dot(a) - cosine * apart.dot(b)) / sine2;
  const double t = (cosine * apart.dot(a) - apart.dot(b)) / sine2;
  if (s <= 0 || t <= 0) return {};
  return o + (s * a + apart + t * b) / 2;
}

// Half of the cameras look farther than this from the direction they have in common.
double MedianFromCommonDirection(std::span<const Camera* const> cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera* camera : cameras) sum += camera->ForwardInWorld();
  std::vector<double> angles;
  for (const Camera* camera : cameras)
    angles.push_back(AngleBetween(camera->ForwardInWorld(), sum));
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

}  // namespace

std::vector<ViewOfAnotherTree> ViewsOfAnotherTree(std::span<const NamedCamera> cameras) {
  if (cameras.size() < kFewest) return {};

  // Candidates, from pairs of cameras evenly over the list
  const std::size_t count = std::min(cameras.size(), kMostForPoints);
  const auto nth = [&](std::size_t i) -> const Camera& {
    return cameras[i * cameras.size() / count].camera;
  };
  std::vector<Eigen::Vector3d> candidates;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      if (const auto point = MeetingPoint(nth(i), nth(j))) candidates.push_back(*point);
    }
  }

  // The one that most cameras see, nearest to their axes
  std::optional<Eigen::Vector3d> best;
  std::size_t best_count = 0;
  double best_sum_rad = 0;
  for (const Eigen::Vector3d& point : candidates) {
    std::size_t seen = 0;
    double sum_rad = 0;
    for (const NamedCamera& named : cameras) {
      if (!Sees(named.camera, point)) continue;
      ++seen;
      sum_rad += OffAxis(named.camera, point);
    }
    if (seen > best_count || (seen == best_count && sum_rad < best_sum_rad)) {
      best = point;
      best_count = seen;
      best_sum_rad = sum_rad;
    }
  }
  if (!best || 3 * best_count < 2 * cameras.size()) return {};

  // Whether those that see it go around it
  std::vector<const Camera*> around;
  std::vector<ViewOfAnotherTree> strange;
  for (const NamedCamera& named : cameras) {
    if (Sees(named.camera, *best)) {
      around.push_back(&named.camera);
    } else {
      strange.push_back({named.view, DegFromRad(OffAxis(named.camera, *best))});
    }
  }
  if (MedianFromCommonDirection(around) < kParallel_rad) return {};
  return strange;
}

}  // namespace relight
