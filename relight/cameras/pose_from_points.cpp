// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/pose_from_points.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

namespace relight {
namespace {

constexpr double kFlat = 0.01;       // Less spread than this across: a line, or a plane.
constexpr double kFarOff = 0.01;     // A residual worth a word, of the photo's diagonal.
constexpr double kClickedTo_px = 1;  // No click is taken to be better than this.

double Diagonal(const Camera& camera) {
  return std::hypot(camera.width_px, camera.height_px);
}

std::string PointName(std::size_t index) { return "point " + std::to_string(index + 1); }

// How far points spread along their three principal directions, largest first.
template <int kDim>
Eigen::Matrix<double, kDim, 1> Spread(const Eigen::Matrix<double, kDim, -1>& points) {
  const auto centred = (points.colwise() - points.rowwise().mean()).eval();
  return Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues().head(kDim) /
         std::sqrt(static_cast<double>(points.cols()));
}

// Throws InputError for sets that fix no pose; answers whether they lie on one plane.
bool RequireSpread(std::span<const GroundPoint> points, const Camera& camera) {
  const std::string more =
      "; give four points or more that are corners of an area, near and far, left and "
      "right";
  if (points.size() < 4) {
    throw InputError("--point: " + std::to_string(points.size()) +
                     " given, and a pose needs four or more" + more);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool one_place = (points[i].position - points[j].position).norm() < 0.01;
      const bool one_pixel = (points[i].pixel - points[j].pixel).norm() < 0.5;
      if (!one_place && !one_pixel) continue;
      throw InputError("--point: " + PointName(j) + " and " + PointName(i) + " are one " +
                       (one_place ? "place" : "pixel") + more);
    }
  }
  Eigen::Matrix3Xd places(3, points.size());
  Eigen::Matrix2Xd pixels(2, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    places.col(static_cast<Eigen::Index>(i)) = points[i].position;
    pixels.col(static_cast<Eigen::Index>(i)) = points[i].pixel;
  }
  const Eigen::Vector3d in_world = Spread<3>(places);
  const Eigen::Vector2d in_photo = Spread<2>(pixels);
  if (in_world[1] < kFlat * in_world[0])
    throw InputError("--point: all places lie on one line" + more);
  if (in_photo[1] < 0.002 * Diagonal(camera))
    throw InputError("--point: all pixels lie on one line" + more);
  return in_world[2] < kFlat * in_world[1];
}

// OpenCV's names for what we have.
struct Correspondence {
  std::vector<cv::Point3d> places;
  std::vector<cv::Point2d> pixels;
};

Correspondence Corresponding(std::span<const GroundPoint> points,
                             const Eigen::Vector3d& middle) {
  Correspondence result;
  for (const GroundPoint& point : points) {
    const Eigen::Vector3d p = point.position - middle;
    result.places.emplace_back(p.x(), p.y(), p.z());
    result.pixels.emplace_back(point.pixel.x(), point.pixel.y());
  }
  return result;
}

Eigen::Isometry3d IsometryOf(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat matrix;
  cv::Rodrigues(rotation, matrix);
  Eigen::Matrix3d r;
  Eigen::Vector3d t;
  cv::cv2eigen(matrix, r);
  cv::cv2eigen(translation, t);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = r;
  pose.translation() = t;
  return pose;
}

struct Fit {
  Camera camera;
  std::vector<double> residual_px;
  double rms_px = std::numeric_limits<double>::infinity();
};

std::optional<Fit> Measure(std::span<const GroundPoint> points, const Camera& camera) {
  Fit fit{camera, {}, 0};
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const GroundPoint& point : points) {
    const auto seen = camera.Project(point.position);
    if (!seen) return std::nullopt;
    fit.residual_px.push_back((*seen - point.pixel).norm());
    fit.rms_px += std::pow(fit.residual_px.back(), 2);
    lowest_m = std::min(lowest_m, point.position.z());
  }
  if (!(camera.PositionInWorld().z() > lowest_m)) return std::nullopt;
  fit.rms_px = std::sqrt(fit.rms_px / static_cast<double>(points.size()));
  return fit;
}

// (C6) for one focal length; nothing when no answer sees all points from above.
std::optional<Fit> BestPose(std::span<const GroundPoint> points,
                            Camera camera,
                            double focal_px,
                            bool planar) {
  camera.focal_px = {focal_px, focal_px};
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const GroundPoint& point : points)
    middle += point.position / static_cast<double>(points.size());
  const Correspondence at = Corresponding(points, middle);
  const cv::Matx33d intrinsics(
      focal_px, 0, camera.center_px.x(), 0, focal_px, camera.center_px.y(), 0, 0, 1);

  std::vector<cv::Mat> rotations, translations;
  for (const auto method : {cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_IPPE}) {
    if (method == cv::SOLVEPNP_IPPE && !planar) continue;
    std::vector<cv::Mat> turned, moved;
    try {
      cv::solvePnPGeneric(
          at.places, at.pixels, intrinsics, cv::noArray(), turned, moved, false, method);
    } catch (const cv::Exception&) {
      continue;  // This start has none: the other may
    }
    rotations.insert(rotations.end(), turned.begin(), turned.end());
    translations.insert(translations.end(), moved.begin(), moved.end());
  }
  std::optional<Fit> best;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::solvePnPRefineLM(at.places,
                         at.pixels,
                         intrinsics,
                         cv::noArray(),
                         rotations[i],
                         translations[i],
                         {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-12});
    camera.camera_from_world =
        IsometryOf(rotations[i], translations[i]) * Eigen::Translation3d(-middle);
    if (!camera.camera_from_world.matrix().allFinite()) continue;
    const auto fit = Measure(points, camera);
    if (fit && (!best || fit->rms_px < best->rms_px)) best = fit;
  }
  return best;
}

// Standard error of the position for pixels that are off by `noise_px`: by small turns
// and moves of the camera, numerically.
double PositionError(std::span<const GroundPoint> points,
                     const Camera& camera,
                     double noise_px) {
  constexpr double kStep = 1e-6;
  const double reach_m = (camera.camera_from_world * points[0].position).norm();
  Eigen::MatrixXd jacobian(2 * points.size(), 6);
  for (int k = 0; k < 6; ++k) {
    Camera moved = camera;
    if (k < 3) {
      moved.camera_from_world.translation()[k] += kStep * reach_m;
    } else {
      // About itself, so that a turn is no move
      moved.camera_from_world.linear() =
          Eigen::AngleAxisd(kStep, Eigen::Vector3d::Unit(k - 3)) *
          camera.camera_from_world.linear();
      moved.camera_from_world.translation() =
          -(moved.camera_from_world.linear() * camera.PositionInWorld());
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto before = camera.Project(points[i].position);
      const auto after = moved.Project(points[i].position);
      if (!before || !after) return std::numeric_limits<double>::infinity();
      jacobian.block<2, 1>(static_cast<Eigen::Index>(2 * i), k) =
          (*after - *before) / kStep;
    }
  }
  const Eigen::Matrix<double, 6, 6> covariance =
      (jacobian.transpose() * jacobian).inverse();
  return noise_px * reach_m * std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

// The focal length of the smallest residual, when the points tell it: a tenth more or
// less must fit clearly worse.
std::optional<Fit> BestFocal(std::span<const GroundPoint> points, const Camera& camera) {
  const auto fit_at = [&](double log_focal) {
    return BestPose(points, camera, std::exp(log_focal), false);
  };
  const auto rms_at = [&](double log_focal) {
    const auto fit = fit_at(log_focal);
    return fit ? fit->rms_px : std::numeric_limits<double>::infinity();
  };

  // Look everywhere, then narrow by thirds
  const double low = std::log(0.5 * Diagonal(camera)), range = std::log(8.0);
  constexpr int kSteps = 40;
  int best = 0;
  double best_rms = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const double rms = rms_at(low + range * i / kSteps);
    if (rms < best_rms) {
      best_rms = rms;
      best = i;
    }
  }
  if (best == 0 || best == kSteps) return std::nullopt;
  double a = low + range * (best - 1) / kSteps, b = low + range * (best + 1) / kSteps;
  for (int i = 0; i < 40; ++i) {
    const double third = (b - a) / 3;
    if (rms_at(a + third) < rms_at(b - third)) {
      b -= third;
    } else {
      a += third;
    }
  }
  const double at = (a + b) / 2;
  const auto fit = fit_at(at);
  if (!fit) return std::nullopt;
  const double clear_px = 1.5 * std::max(fit->rms_px, kClickedTo_px);
  if (rms_at(at + 0.1) < clear_px || rms_at(at - 0.1) < clear_px) return std::nullopt;
  return fit;
}

}  // namespace

Eigen::Vector3d EnuFromPlace(const Place& place, double height_m, const Place& origin) {
  const GeographicLib::LocalCartesian local(origin.latitude_deg, origin.longitude_deg, 0);
  Eigen::Vector3d p;
  local.Forward(place.latitude_deg, place.longitude_deg, 0, p.x(), p.y(), p.z());
  p.z() = height_m;  // Level ground, not the Earth's bulge
  return p;
}

Place PlaceFromEnu(const Eigen::Vector3d& position, const Place& origin) {
  const GeographicLib::LocalCartesian local(origin.latitude_deg, origin.longitude_deg, 0);
  Place place;
  double height_m = 0;
  local.Reverse(
      position.x(), position.y(), 0, place.latitude_deg, place.longitude_deg, height_m);
  place.altitude_m = origin.altitude_m;
  return place;
}

PoseFromPoints FindPose(std::span<const GroundPoint> points,
                        const Camera& camera,
                        bool find_focal) {
  const bool planar = RequireSpread(points, camera);
  std::optional<Fit> fit;
  bool focal_found = false;
  if (find_focal && !planar && points.size() >= 6) {
    fit = BestFocal(points, camera);
    focal_found = fit.has_value();
  }
  if (!fit) fit = BestPose(points, camera, camera.focal_px.x(), planar);
  if (!fit) {
    throw InputError(
        "--point: no camera above the ground sees all points so; look for pixels and "
        "places that were exchanged, and latitude before longitude");
  }

  PoseFromPoints pose{fit->camera, fit->residual_px, fit->rms_px, 0, focal_found, {}};
  pose.position_error_m =
      PositionError(points, pose.camera, std::max(pose.rms_px, kClickedTo_px));
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const GroundPoint& point : points) {
    nearest_m =
        std::min(nearest_m, (point.position - pose.camera.PositionInWorld()).norm());
  }
  if (!(pose.position_error_m < nearest_m)) {
    std::ostringstream text;
    text.precision(2);
    text << "--point: these points fix the camera's place to " << pose.position_error_m
         << " m only; add some that are nearer, or further apart";
    throw InputError(text.str());
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (pose.residual_px[i] <= kFarOff * Diagonal(camera)) continue;
    std::ostringstream text;
    text.precision(3);
    text << PointName(i) << " is " << pose.residual_px[i]
         << " px from where the camera found sees it: look at its pixel, its place and "
            "its height again"
         << (points.size() == 4
                 ? " (or another's: of four points, one wrong one bends all)"
                 : "");
    pose.notes.push_back(text.str());
  }
  return pose;
}

}  // namespace relight
