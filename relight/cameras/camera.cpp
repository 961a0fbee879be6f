// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/camera.h"

namespace relight {
namespace {

// (C1), and its derivative with respect to x, y.
Eigen::Vector2d Distort(const Lens& lens,
                        const Eigen::Vector2d& p,
                        Eigen::Matrix2d* derivative) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + lens.k2 * r2);
  if (derivative != nullptr) {
    const double slope = 2 * lens.k1 + 4 * lens.k2 * r2;  // d radial / d(r^2/2)
    (*derivative)(0, 0) = radial + x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x;
    (*derivative)(0, 1) = x * y * slope + 2 * lens.p1 * x + 2 * lens.p2 * y;
    (*derivative)(1, 0) = x * y * slope + 2 * lens.p2 * y + 2 * lens.p1 * x;
    (*derivative)(1, 1) = radial + y * y * slope + 2 * lens.p2 * x + 6 * lens.p1 * y;
  }
  return {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
          y * radial + 2 * lens.p2 * x * y + lens.p1 * (r2 + 2 * y * y)};
}

// Inverse of (C1) by Newton's method from the distorted point itself.
Eigen::Vector2d Undistort(const Lens& lens, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int step = 0; step < 50; ++step) {
    Eigen::Matrix2d derivative;
    const Eigen::Vector2d error = Distort(lens, p, &derivative) - distorted;
    if (error.squaredNorm() < 1e-24 || std::abs(derivative.determinant()) < 1e-9) break;
    p -= derivative.inverse() * error;
  }
  return p;
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
  Eigen::Vector2d p = point.hnormalized();
  if (!lens.IsPinhole()) p = Distort(lens, p, nullptr);
  return p.cwiseProduct(focal_px) + center_px;
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

}  // namespace relight
