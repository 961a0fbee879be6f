// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/camera_parts.h"

#include "relight/base/error.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace relight {
namespace {

constexpr double kWidestPhoto_px = 1e6;

double Polynomial(const std::array<double, 4>& k, double s) {
  return 1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])));
}
// Of r q(r^2), by r.
double Slope(const std::array<double, 4>& k, double s) {
  return 1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])));
}

// The r that the lens maps to `corner`, or where it folds back before.
double FrameRadius(const std::array<double, 4>& k, double corner) {
  const double step = corner / 200;
  double r = 0;
  for (int i = 0; i < 2000; ++i, r += step) {
    if (r * Polynomial(k, r * r) >= corner || Slope(k, r * r) <= 0) break;
  }
  return r;
}

// The quotient (1 + a1 s + a2 s^2 + a3 s^3) / (1 + b1 s + b2 s^2 + b3 s^3) nearest to
// q(s): a s - q(s) b s = q(s) - 1 is linear in a and b.
Eigen::Matrix<double, 6, 1> FittedQuotient(const std::array<double, 4>& k,
                                           double widest) {
  constexpr int kPoints = 64;
  Eigen::MatrixXd rows(kPoints, 6);
  Eigen::VectorXd values(kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const double r = (i + 1.0) / kPoints, s = r * r;  // Of the widest, for the condition
    const double q = Polynomial(k, s * widest * widest);
    rows.row(i) << s, s * s, s * s * s, -q * s, -q * s * s, -q * s * s * s;
    rows.row(i) *= r;  // An error of q moves a pixel by r times that
    values[i] = (q - 1) * r;
  }
  Eigen::Matrix<double, 6, 1> ab = rows.colPivHouseholderQr().solve(values);
  for (int i = 0; i < 6; ++i) ab[i] /= std::pow(widest, 2 * (i % 3 + 1));
  return ab;
}

bool IsExtension(std::string_view text) {
  return !text.empty() && text.size() <= 4 &&
         std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0;
         });
}

}  // namespace

std::optional<Eigen::Isometry3d> PoseFromAxes(const Eigen::Matrix3d& world_from_camera,
                                              const Eigen::Vector3d& position) {
  const double scale = std::cbrt(world_from_camera.determinant());
  if (!std::isfinite(scale) || !(scale > 1e-12) || !position.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Matrix3d rotation = world_from_camera / scale;
  const Eigen::Matrix3d off =
      rotation.transpose() * rotation - Eigen::Matrix3d::Identity();
  if (!(off.cwiseAbs().maxCoeff() < 1e-3)) return std::nullopt;
  Eigen::Isometry3d pose;
  // The nearest rotation: files round their numbers
  pose.linear() =
      Eigen::Quaterniond(rotation).normalized().toRotationMatrix().transpose();
  pose.translation() = -(pose.linear() * position);
  return pose;
}

std::optional<int> SizeFrom(double pixels) {
  if (!(pixels >= 1 && pixels <= kWidestPhoto_px)) return std::nullopt;
  return static_cast<int>(std::lround(pixels));
}

std::string ViewOfImage(std::string_view name, const PhotoSizes& photos) {
  const std::size_t folder = name.find_last_of("/\\");
  if (folder != std::string_view::npos) name.remove_prefix(folder + 1);
  if (photos.contains(std::string(name))) return std::string(name);
  const std::size_t dot = name.rfind('.');
  const bool extended =
      dot != std::string_view::npos && dot > 0 && IsExtension(name.substr(dot + 1));
  return std::string(extended ? name.substr(0, dot) : name);
}

std::optional<PhotoSize> SizeOfView(const std::string& view,
                                    const PhotoSizes& photos,
                                    UnknownPhotos unknown,
                                    const std::string& file) {
  const auto found = photos.find(view);
  if (found != photos.end() && found->second.width_px > 0 &&
      found->second.height_px > 0) {
    return found->second;
  }
  if (unknown == UnknownPhotos::kLeaveOut) return std::nullopt;
  throw InputError(file + ": does not hold the size of the photo \"" + view +
                   "\", and no photo of that name is in the capture; add it with "
                   "\"relight init\" (extensions do not count)");
}

Camera QuarterTurned(const Camera& camera) {
  Camera turned = camera;
  turned.width_px = camera.height_px;
  turned.height_px = camera.width_px;
  turned.focal_px = {camera.focal_px.y(), camera.focal_px.x()};
  turned.center_px = {camera.height_px - camera.center_px.y(), camera.center_px.x()};
  // The new x is the old -y, the new y the old x: put into (C1), p1 and p2 change places
  turned.lens.p1 = camera.lens.p2;
  turned.lens.p2 = -camera.lens.p1;
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  turned.camera_from_world = Eigen::Isometry3d(turn) * camera.camera_from_world;
  return turned;
}

double CornerRadius(const Camera& camera) {
  double widest = 0;
  for (const double u : {0.0, static_cast<double>(camera.width_px)}) {
    for (const double v : {0.0, static_cast<double>(camera.height_px)}) {
      const Eigen::Vector2d corner =
          (Eigen::Vector2d(u, v) - camera.center_px).cwiseQuotient(camera.focal_px);
      widest = std::max(widest, corner.norm());
    }
  }
  return widest;
}

bool SetRadialPolynomial(Camera& camera, const std::array<double, 4>& k) {
  Lens& lens = camera.lens;
  lens.k1 = k[0];
  lens.k2 = k[1];
  lens.k3 = k[2];
  lens.k4 = lens.k5 = lens.k6 = 0;
  if (k[3] == 0) return true;
  const double corner = CornerRadius(camera), focal_px = camera.focal_px.maxCoeff();
  if (!std::isfinite(corner) || !(corner > 0)) return false;
  const double widest = FrameRadius(k, corner);
  if (std::abs(k[3]) * std::pow(widest, 9) * focal_px < kIgnoredShift_px) return true;

  const Eigen::Matrix<double, 6, 1> ab = FittedQuotient(k, widest);
  if (!ab.allFinite()) return false;
  constexpr int kChecks = 500;
  for (int i = 1; i <= kChecks; ++i) {
    const double r = widest * i / kChecks, s = r * r;
    const double above = 1 + s * (ab[0] + s * (ab[1] + s * ab[2]));
    const double below = 1 + s * (ab[3] + s * (ab[4] + s * ab[5]));
    if (!(below > 0.05)) return false;
    const double shift_px = std::abs(above / below - Polynomial(k, s)) * r * focal_px;
    if (!(shift_px < kIgnoredShift_px)) return false;
  }
  lens.k1 = ab[0];
  lens.k2 = ab[1];
  lens.k3 = ab[2];
  lens.k4 = ab[3];
  lens.k5 = ab[4];
  lens.k6 = ab[5];
  return true;
}

}  // namespace relight
