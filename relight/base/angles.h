// SPDX-License-Identifier: Apache-2.0
#pragma once

// Degrees, radians and directions (docs/conventions.md#directions): azimuth clockwise
// from true north, elevation from the horizon, world ENU.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace relight {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double RadFromDeg(double angle_deg) { return angle_deg * kRadPerDeg; }
inline constexpr double DegFromRad(double angle_rad) { return angle_rad / kRadPerDeg; }

// Unit vector in ENU.
inline Eigen::Vector3d DirectionFromAzimuthElevation(double azimuth_rad,
                                                     double elevation_rad) {
  const double c = std::cos(elevation_rad);
  return {c * std::sin(azimuth_rad), c * std::cos(azimuth_rad), std::sin(elevation_rad)};
}

// In [0, 2 pi). `direction` needs no unit length; 0 for a vertical one.
inline double AzimuthOf(const Eigen::Vector3d& direction) {
  const double azimuth_rad = std::atan2(direction.x(), direction.y());
  return azimuth_rad < 0 ? azimuth_rad + 2 * std::numbers::pi : azimuth_rad;
}

// In [-pi/2, pi/2].
inline double ElevationOf(const Eigen::Vector3d& direction) {
  return std::atan2(direction.z(), direction.head<2>().norm());
}

// Angle between two directions, exact for nearly parallel ones too, in [0, pi].
inline double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The same angle in [-180, 180).
inline double WrapDeg180(double angle_deg) {
  return angle_deg - 360.0 * std::floor((angle_deg + 180.0) / 360.0);
}

}  // namespace relight
