// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/tree_place.h"

#include "relight/base/angles.h"
#include "relight/cameras/level_camera.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace relight {
namespace {

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Eigen::Vector3d MeanPosition(const CalibratedScene& scene) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [view, camera] : scene.cameras) mean += camera.PositionInWorld();
  return mean / static_cast<double>(scene.cameras.size());
}

std::vector<double> AxisDistances(const CalibratedScene& scene,
                                  const Eigen::Vector3d& x) {
  std::vector<double> distances;
  for (const auto& [view, camera] : scene.cameras) {
    const Eigen::Vector3d to = x - camera.PositionInWorld();
    distances.push_back(to.cross(camera.ForwardInWorld()).norm());
  }
  return distances;
}

// (C8) by reweighting; nothing when the axes do not meet in front of the cameras.
std::optional<Eigen::Vector3d> LookedAt(const CalibratedScene& scene) {
  constexpr double kTukey = 4.685, kSigmaOfMedian = 1.4826;
  std::vector<double> weight(scene.cameras.size(), 1.0);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int round = 0; round < 20; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
      const Camera& camera = scene.cameras[i].camera;
      const Eigen::Vector3d d = camera.ForwardInWorld();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
      a += weight[i] * across;
      b += weight[i] * across * camera.PositionInWorld();
      sum += weight[i];
    }
    // Parallel axes leave their own direction open
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
    if (solver.eigenvalues()[0] < 0.003 * sum) return std::nullopt;
    x = a.ldlt().solve(b);
    const std::vector<double> off = AxisDistances(scene, x);
    const double sigma = std::max(kSigmaOfMedian * MedianOf(off), 1e-6);
    for (std::size_t i = 0; i < off.size(); ++i) {
      const double u = std::min(1.0, std::pow(off[i] / (kTukey * sigma), 2));
      weight[i] = (1 - u) * (1 - u);
    }
  }
  const auto in_front = std::count_if(
      scene.cameras.begin(), scene.cameras.end(), [&](const NamedCamera& named) {
        return (x - named.camera.PositionInWorld()).dot(named.camera.ForwardInWorld()) >
               0;
      });
  if (2 * in_front < static_cast<std::ptrdiff_t>(scene.cameras.size()))
    return std::nullopt;
  return x;
}

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // Upwards.
  double height_m = 0;                                // normal . x on it.
  int points = 0;

  double Above(const Eigen::Vector3d& point) const {
    return normal.dot(point) - height_m;
  }
};

Plane FitPlane(const std::vector<Eigen::Vector3d>& points,
               const Plane& near,
               double within_m) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> on;
  for (const Eigen::Vector3d& point : points) {
    if (std::abs(near.Above(point)) > within_m) continue;
    on.push_back(point);
    mean += point;
  }
  if (on.size() < 3) return near;
  mean /= static_cast<double>(on.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : on) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  Plane plane;
  plane.normal = solver.eigenvectors().col(0);
  if (plane.normal.z() < 0) plane.normal = -plane.normal;
  plane.height_m = plane.normal.dot(mean);
  plane.points = static_cast<int>(on.size());
  return plane;
}

// The ground near `spot`, `reach_m` around; nothing when too few points lie on a plane.
std::optional<Plane> FindGround(const CalibratedScene& scene,
                                const Eigen::Vector3d& spot,
                                double reach_m,
                                double within_m) {
  constexpr double kSteepest_rad = 15 * kRadPerDeg;
  constexpr int kTries = 2000, kLeast = 30;
  constexpr double kLeastShare = 0.08, kMostBelow = 0.06;
  std::vector<double> eyes;
  for (const auto& [view, camera] : scene.cameras) {
    eyes.push_back(camera.PositionInWorld().z());
  }
  const double eye_m = MedianOf(eyes);
  std::vector<Eigen::Vector3d> near, low;
  for (const ScenePoint& point : scene.points) {
    if (point.views == 1 || point.views == 2) continue;  // 0: not known
    if ((point.position - spot).head<2>().norm() > reach_m) continue;
    near.push_back(point.position);
    if (point.position.z() < eye_m) low.push_back(point.position);
  }
  if (static_cast<int>(low.size()) < kLeast) return std::nullopt;
  // Its own generator: the same scene gives the same ground everywhere
  std::mt19937 random(1);
  Plane best;
  for (int n = 0; n < kTries; ++n) {
    const auto pick = [&] { return low[random() % low.size()]; };
    const Eigen::Vector3d a = pick(), b = pick(), c = pick();
    Plane plane;
    plane.normal = (b - a).cross(c - a);
    if (plane.normal.norm() < 1e-9) continue;
    plane.normal.normalize();
    if (plane.normal.z() < 0) plane.normal = -plane.normal;
    if (plane.normal.z() < std::cos(kSteepest_rad)) continue;
    plane.height_m = plane.normal.dot(a);
    int below = 0;
    for (const Eigen::Vector3d& point : low) {
      const double above = plane.Above(point);
      plane.points += std::abs(above) < within_m;
      below += above < -2 * within_m;
    }
    if (below <= kMostBelow * static_cast<double>(near.size()) &&
        plane.points > best.points) {
      best = plane;
    }
  }
  if (best.points < kLeast ||
      best.points < kLeastShare * static_cast<double>(near.size())) {
    return std::nullopt;
  }
  for (int round = 0; round < 3; ++round) best = FitPlane(low, best, within_m);
  if (best.normal.z() < std::cos(kSteepest_rad)) return std::nullopt;
  return best;
}

}  // namespace

TreePlace FindTreePlace(const CalibratedScene& scene) {
  TreePlace place;
  const Eigen::Vector3d middle = MeanPosition(scene);
  const auto looked_at = LookedAt(scene);
  place.foot = looked_at.value_or(middle);
  place.is_looked_at = looked_at.has_value();
  place.axes_error_m = looked_at ? MedianOf(AxisDistances(scene, *looked_at)) : 0;

  std::vector<double> distances, eyes;
  for (const auto& [view, camera] : scene.cameras) {
    const Eigen::Vector3d eye = camera.PositionInWorld();
    distances.push_back((eye - place.foot).norm());
    eyes.push_back(eye.z());
  }
  const double distance_m = MedianOf(distances);
  constexpr double kWithin = 0.012;  // Of the distance: grass, kerbs and sparse points.
  const auto ground = FindGround(
      scene, place.foot, 1.5 * distance_m, std::max(kWithin * distance_m, 0.05));
  if (!ground) {
    place.foot.z() = MedianOf(eyes) - kEyeHeight_m;
    place.ground_error_m = 0.3;
    place.ground_from = "cameras held 1.6 m above it, which is assumed";
    return place;
  }
  const Eigen::Vector3d& n = ground->normal;
  place.foot.z() =
      (ground->height_m - n.x() * place.foot.x() - n.y() * place.foot.y()) / n.z();
  place.slope_rad = std::acos(std::min(1.0, n.z()));
  place.ground_points = ground->points;
  double squares = 0;
  int count = 0;
  for (const ScenePoint& point : scene.points) {
    const double above = ground->Above(point.position);
    if (std::abs(above) > kWithin * distance_m) continue;
    squares += above * above;
    ++count;
  }
  place.ground_error_m = count > 0 ? std::sqrt(squares / count) : 0;
  place.ground_from = std::to_string(ground->points) + " sparse points";
  return place;
}

}  // namespace relight
