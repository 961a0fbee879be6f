// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace relight {
namespace {

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d derivative;  // By x, y.
};

// (C1).
Distorted DistortBrown(const Lens& lens, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double above = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double below = 1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6));
  const double q = above / below;
  const double above_slope = lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3);
  const double below_slope = lens.k4 + r2 * (2 * lens.k5 + r2 * 3 * lens.k6);
  const double slope = 2 * (above_slope - q * below_slope) / below;  // dq / d(r^2/2)
  const double p1 = lens.p1, p2 = lens.p2;
  Distorted d;
  d.point = {x * q + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * q + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
  d.derivative(0, 0) = q + x * x * slope + 2 * p1 * y + 6 * p2 * x;
  d.derivative(0, 1) = x * y * slope + 2 * p1 * x + 2 * p2 * y;
  d.derivative(1, 0) = x * y * slope + 2 * p2 * y + 2 * p1 * x;
  d.derivative(1, 1) = q + y * y * slope + 2 * p2 * x + 6 * p1 * y;
  return d;
}

// Angle on the picture and its derivative for the angle t from the axis, of (C2).
std::pair<double, double> FisheyeAngle(const Lens& lens, double t) {
  const double t2 = t * t;
  const double q = 1 + t2 * (lens.k1 + t2 * (lens.k2 + t2 * (lens.k3 + t2 * lens.k4)));
  const double slope =
      1 + t2 * (3 * lens.k1 + t2 * (5 * lens.k2 + t2 * (7 * lens.k3 + t2 * 9 * lens.k4)));
  return {t * q, slope};
}

// (C1) or (C2); nothing where the formula folds back.
std::optional<Eigen::Vector2d> Distort(const Lens& lens, const Eigen::Vector2d& p) {
  if (lens.model == LensModel::kFisheye) {
    const double r = p.norm();
    const auto [angle, slope] = FisheyeAngle(lens, std::atan(r));
    if (slope <= 0 || angle < 0) return std::nullopt;
    return r > 0 ? Eigen::Vector2d(p * (angle / r)) : p;
  }
  const Distorted d = DistortBrown(lens, p);
  if (!(d.derivative.determinant() > 0) || !(d.derivative.trace() > 0))
    return std::nullopt;
  return d.point;
}

// Inverse of (C1) by Newton's method from the distorted point itself.
Eigen::Vector2d UndistortBrown(const Lens& lens, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int step = 0; step < 50; ++step) {
    const Distorted d = DistortBrown(lens, p);
    const Eigen::Vector2d error = d.point - distorted;
    if (error.squaredNorm() < 1e-24 || std::abs(d.derivative.determinant()) < 1e-9) break;
    p -= d.derivative.inverse() * error;
  }
  return p;
}

// Inverse of (C2); what lies at a right angle to the axis or beyond is put just before.
Eigen::Vector2d UndistortFisheye(const Lens& lens, const Eigen::Vector2d& distorted) {
  constexpr double kWidest = 0.4999 * std::numbers::pi;
  const double seen = distorted.norm();
  if (seen == 0) return distorted;
  double t = std::min(seen, kWidest);
  for (int step = 0; step < 50; ++step) {
    const auto [angle, slope] = FisheyeAngle(lens, t);
    if (std::abs(angle - seen) < 1e-13 || slope <= 1e-9) break;
    t = std::clamp(t - (angle - seen) / slope, 0.0, kWidest);
  }
  return distorted * (std::tan(t) / seen);
}

Eigen::Vector2d Undistort(const Lens& lens, const Eigen::Vector2d& distorted) {
  return lens.model == LensModel::kFisheye ? UndistortFisheye(lens, distorted)
                                           : UndistortBrown(lens, distorted);
}

}  // namespace

Eigen::Vector3d Camera::PositionInWorld() const {
  return -(camera_from_world.linear().transpose() * camera_from_world.translation());
}

Eigen::Vector3d Camera::ForwardInWorld() const {
  return camera_from_world.linear().row(2).transpose();
}

Eigen::Vector3d Camera::RayInWorld(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d p = (pixel - center_px).cwiseQuotient(focal_px);
  if (!lens.IsPinhole()) p = Undistort(lens, p);
  // Each pixel of a photo comes here: the rotation's rows, no transforms in between
  const Eigen::Matrix4d& m = camera_from_world.matrix();
  const Eigen::Vector3d ray(p.x() * m(0, 0) + p.y() * m(1, 0) + m(2, 0),
                            p.x() * m(0, 1) + p.y() * m(1, 1) + m(2, 1),
                            p.x() * m(0, 2) + p.y() * m(1, 2) + m(2, 2));
  return ray / ray.norm();
}

std::optional<Eigen::Vector2d> Camera::Project(
    const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = camera_from_world * point_in_world;
  if (point.z() <= 1e-9) return std::nullopt;
  const Eigen::Vector2d p = point.hnormalized();
  const std::optional<Eigen::Vector2d> seen = lens.IsPinhole() ? p : Distort(lens, p);
  if (!seen) return std::nullopt;
  return seen->cwiseProduct(focal_px) + center_px;
}

Camera Camera::Resized(int width, int height) const {
  Camera resized = *this;
  const Eigen::Vector2d scale(static_cast<double>(width) / width_px,
                              static_cast<double>(height) / height_px);
  resized.width_px = width;
  resized.height_px = height;
  resized.focal_px = focal_px.cwiseProduct(scale);
  resized.center_px = center_px.cwiseProduct(scale);
  return resized;
}

Camera Camera::Upright(int orientation) const {
  // Quarter turns clockwise: x' = H - y, y' = x for one
  const int turns = orientation == 6   ? 1
                    : orientation == 3 ? 2
                    : orientation == 8 ? 3
                                       : 0;
  Camera upright = *this;
  for (int turn = 0; turn < turns; ++turn) {
    const Camera before = upright;
    Eigen::Matrix3d by;
    by << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    upright.camera_from_world.linear() = by * before.camera_from_world.linear();
    upright.camera_from_world.translation() = by * before.camera_from_world.translation();
    std::swap(upright.width_px, upright.height_px);
    upright.focal_px = {before.focal_px.y(), before.focal_px.x()};
    upright.center_px = {before.height_px - before.center_px.y(), before.center_px.x()};
    // (p2, p1) of (C1) is a vector of the picture, and turns with it
    if (upright.lens.model == LensModel::kBrown) {
      upright.lens.p2 = -before.lens.p1;
      upright.lens.p1 = before.lens.p2;
    }
  }
  return upright;
}

}  // namespace relight
