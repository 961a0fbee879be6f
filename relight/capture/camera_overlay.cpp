// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/camera_overlay.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace relight {
namespace {

constexpr double kFar_m = 1e6;  // As good as infinity for a photo.
constexpr double kGridStep_m = 10, kGridReach_m = 80;
constexpr double kFarthestGround_m = 2000, kLongestShadow_m = 200;
constexpr double kSunRadius_rad = 0.00465;
const cv::Scalar kOutline(25, 25, 25);

cv::Scalar Ink(const cv::Vec3b& color) { return cv::Scalar(cv::Vec3d(color)); }

// Draws what is known in the world on the picture, light on a dark outline.
class Pen {
 public:
  Pen(cv::Mat3b& picture, const Camera& camera)
      : picture_(picture),
        camera_(camera),
        unit_(std::max(0.5, std::max(picture.cols, picture.rows) / 1600.0)) {}

  const Camera& camera() const { return camera_; }
  int Pixels(double of_1600) const {
    return std::max(1, static_cast<int>(std::lround(of_1600 * unit_)));
  }
  bool Holds(const Eigen::Vector2d& p, double margin_px = 0) const {
    return p.x() >= margin_px && p.y() >= margin_px &&
           p.x() <= picture_.cols - margin_px && p.y() <= picture_.rows - margin_px;
  }

  void Line(const Eigen::Vector2d& a,
            const Eigen::Vector2d& b,
            const cv::Vec3b& color,
            int width_px) {
    Lines({{a, b}}, color, width_px);
  }

  // `point_at` of 0 to 1, in the world: a straight line there is a curve behind a lens.
  using Path = std::function<Eigen::Vector3d(double)>;

  // All outlines lie below all lines, so that a dense grid does not turn black.
  void Curves(const std::vector<Path>& paths,
              const cv::Vec3b& color,
              int width_px,
              int steps = 200) {
    std::vector<Piece> pieces;
    for (const Path& point_at : paths) {
      bool follows = false;
      Eigen::Vector2d last = Eigen::Vector2d::Zero();
      for (int i = 0; i <= steps; ++i) {
        const auto seen = camera_.Project(point_at(static_cast<double>(i) / steps));
        if (seen && follows) pieces.push_back({last, *seen});
        follows = seen.has_value();
        if (seen) last = *seen;
      }
    }
    Lines(pieces, color, width_px);
  }

  void Segment(const Eigen::Vector3d& a,
               const Eigen::Vector3d& b,
               const cv::Vec3b& color,
               int width_px) {
    Curves({Straight(a, b)}, color, width_px);
  }
  static Path Straight(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return [a, b](double t) { return Eigen::Vector3d(a + t * (b - a)); };
  }

  void Disc(const Eigen::Vector2d& at, double radius_px, const cv::Vec3b& color) {
    const auto radius = static_cast<int>(std::lround(radius_px * kOne));
    cv::circle(picture_,
               Fixed(at),
               radius + 2 * kOne,
               kOutline,
               cv::FILLED,
               cv::LINE_AA,
               kShift);
    cv::circle(picture_, Fixed(at), radius, Ink(color), cv::FILLED, cv::LINE_AA, kShift);
  }

  // `at` is the middle of the text's foot; moved so that all of it is in the picture.
  void Text(const std::string& text, Eigen::Vector2d at, const cv::Vec3b& color) {
    const double scale = 0.65 * unit_;
    const int thick = Pixels(1.3);
    int below = 0;
    const cv::Size size =
        cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
    const int edge = Pixels(6);
    const cv::Point corner(
        std::clamp(static_cast<int>(at.x()) - size.width / 2,
                   edge,
                   std::max(edge, picture_.cols - size.width - edge)),
        std::clamp(static_cast<int>(at.y()),
                   size.height + edge,
                   std::max(size.height + edge, picture_.rows - below - edge)));
    for (const bool outline : {true, false}) {
      cv::putText(picture_,
                  text,
                  corner,
                  cv::FONT_HERSHEY_SIMPLEX,
                  scale,
                  outline ? kOutline : Ink(color),
                  outline ? thick + 2 * Pixels(1.5) : thick,
                  cv::LINE_AA);
    }
  }

  // Two barbs at `tip` of a line that comes from `from`, both on the picture.
  void Barbs(const Eigen::Vector2d& from,
             const Eigen::Vector2d& tip,
             double length_px,
             const cv::Vec3b& color,
             int width_px) {
    if ((from - tip).norm() < 1) return;
    const Eigen::Vector2d back = (from - tip).normalized() * length_px;
    std::vector<Piece> pieces;
    for (const double turn : {-0.5, 0.5})
      pieces.push_back({tip, tip + Eigen::Rotation2Dd(turn) * back});
    Lines(pieces, color, width_px);
  }

 private:
  struct Piece {
    Eigen::Vector2d a, b;
  };
  static constexpr int kShift = 4, kOne = 1 << kShift;

  // A pixel's centre is at +0.5 here, at 0 in OpenCV's drawing.
  static cv::Point Fixed(const Eigen::Vector2d& p) {
    return {static_cast<int>(std::lround((p.x() - 0.5) * kOne)),
            static_cast<int>(std::lround((p.y() - 0.5) * kOne))};
  }

  // The part of a piece in or near the picture, for OpenCV counts in small integers.
  bool Clip(Piece& piece) const {
    const double margin = 50;
    const Eigen::Vector2d along = piece.b - piece.a;
    if (!along.allFinite()) return false;
    double from = 0, to = 1;
    const double size[2] = {static_cast<double>(picture_.cols),
                            static_cast<double>(picture_.rows)};
    for (int k = 0; k < 2; ++k) {
      const double low = -margin - piece.a[k], high = size[k] + margin - piece.a[k];
      if (along[k] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const auto [near, far] = std::minmax({low / along[k], high / along[k]});
      from = std::max(from, near);
      to = std::min(to, far);
    }
    if (from > to) return false;
    piece = {piece.a + from * along, piece.a + to * along};
    return true;
  }

  void Lines(std::vector<Piece> pieces, const cv::Vec3b& color, int width_px) {
    std::erase_if(pieces, [&](Piece& piece) { return !Clip(piece); });
    for (const bool outline : {true, false}) {
      for (const Piece& piece : pieces) {
        cv::line(picture_,
                 Fixed(piece.a),
                 Fixed(piece.b),
                 outline ? kOutline : Ink(color),
                 outline ? width_px + 2 * Pixels(1.2) : width_px,
                 cv::LINE_AA,
                 kShift);
      }
    }
  }

  cv::Mat3b& picture_;
  const Camera& camera_;
  double unit_;  // Pixels of a picture of 1600.
};

Eigen::Vector3d FarAway(const Camera& camera, double azimuth_rad) {
  return camera.PositionInWorld() +
         kFar_m * DirectionFromAzimuthElevation(azimuth_rad, 0);
}

// Lines of whole tens of metres in the world, around the camera.
void DrawGrid(Pen& pen, double ground_z_m) {
  const Eigen::Vector3d eye = pen.camera().PositionInWorld();
  const auto ten = [](double m) { return kGridStep_m * std::round(m / kGridStep_m); };
  const double east = ten(eye.x()), north = ten(eye.y());
  std::vector<Pen::Path> lines;
  for (double d = -kGridReach_m; d <= kGridReach_m; d += kGridStep_m) {
    lines.push_back(Pen::Straight({east + d, north - kGridReach_m, ground_z_m},
                                  {east + d, north + kGridReach_m, ground_z_m}));
    lines.push_back(Pen::Straight({east - kGridReach_m, north + d, ground_z_m},
                                  {east + kGridReach_m, north + d, ground_z_m}));
  }
  pen.Curves(lines, kGridColor, pen.Pixels(1), 400);
}

// A tick each 10 degrees with its azimuth, the eight winds by name.
void DrawHorizon(Pen& pen) {
  const Camera& camera = pen.camera();
  pen.Curves({[&](double t) { return FarAway(camera, 2 * std::numbers::pi * t); }},
             kHorizonColor,
             pen.Pixels(2),
             1440);
  constexpr std::array<const char*, 8> kWinds = {
      "N", "NE", "E", "SE", "S", "SW", "W", "NW"};
  for (int deg = 0; deg < 360; deg += 5) {
    const auto seen = camera.Project(FarAway(camera, RadFromDeg(deg)));
    if (!seen || !pen.Holds(*seen)) continue;
    const bool wind = deg % 45 == 0, ten = deg % 10 == 0;
    const double length = pen.Pixels(wind ? 22 : ten ? 14 : 8);
    const cv::Vec3b& color = deg == 0 ? kNorthColor : kHorizonColor;
    pen.Line(*seen, *seen - Eigen::Vector2d(0, length), color, pen.Pixels(2));
    if (wind || ten) {
      pen.Text(wind ? kWinds[static_cast<std::size_t>(deg / 45)] : std::to_string(deg),
               *seen - Eigen::Vector2d(0, length + pen.Pixels(8)),
               color);
    }
  }
}

// Flat on the ground beside the trunk's foot, so that the shadow is free.
void DrawNorth(Pen& pen, const Eigen::Vector3d& trunk_foot) {
  const Camera& camera = pen.camera();
  Eigen::Vector3d foot = trunk_foot;
  if (const auto seen = camera.Project(trunk_foot)) {
    const double aside_px =
        (seen->x() < camera.width_px / 2.0 ? 0.25 : -0.25) * camera.width_px;
    foot = GroundAt(camera, *seen + Eigen::Vector2d(aside_px, 0), trunk_foot.z())
               .value_or(trunk_foot);
  }
  const double length_m =
      0.25 * (foot - pen.camera().PositionInWorld()).head<2>().norm() + 0.5;
  const Eigen::Vector3d tip = foot + length_m * Eigen::Vector3d::UnitY();
  pen.Segment(foot, tip, kNorthColor, pen.Pixels(3));
  for (const double side : {-1.0, 1.0}) {
    pen.Segment(tip,
                tip + 0.25 * length_m * Eigen::Vector3d(0.5 * side, -1, 0),
                kNorthColor,
                pen.Pixels(3));
  }
  const auto seen = pen.camera().Project(foot + 1.15 * (tip - foot));
  if (seen && pen.Holds(*seen)) pen.Text("N", *seen, kNorthColor);
}

void DrawTrunkAndShadow(Pen& pen,
                        const Eigen::Vector3d& foot,
                        const CameraOverlayOptions& options) {
  if (options.sun_in_world) {
    if (const auto tip = ShadowTip(foot, options.trunk_height_m, *options.sun_in_world)) {
      pen.Segment(foot, *tip, kShadowColor, pen.Pixels(5));
    }
  }
  const Eigen::Vector3d top = foot + options.trunk_height_m * Eigen::Vector3d::UnitZ();
  pen.Segment(foot, top, kTrunkColor, pen.Pixels(3));
  for (int metre = 1; metre <= options.trunk_height_m; ++metre) {
    const auto seen = pen.camera().Project(foot + metre * Eigen::Vector3d::UnitZ());
    const Eigen::Vector2d half(pen.Pixels(5), 0);
    if (seen) pen.Line(*seen - half, *seen + half, kTrunkColor, pen.Pixels(2));
  }
}

void DrawSun(Pen& pen, const Eigen::Vector3d& sun) {
  const Camera& camera = pen.camera();
  const std::string words =
      "sun " + std::to_string(std::lround(DegFromRad(ElevationOf(sun)))) +
      " deg high, azimuth " + std::to_string(std::lround(DegFromRad(AzimuthOf(sun))));
  const auto seen = camera.Project(camera.PositionInWorld() + kFar_m * sun);
  if (seen && pen.Holds(*seen)) {
    pen.Disc(*seen,
             std::max<double>(pen.Pixels(9), kSunRadius_rad * camera.focal_px.x()),
             kSunColor);
    pen.Text(words, *seen + Eigen::Vector2d(0, pen.Pixels(34)), kSunColor);
    return;
  }

  // Out of the picture: an arrow from the middle towards it ends at the border
  const Eigen::Vector3d in_camera = camera.camera_from_world.linear() * sun;
  Eigen::Vector2d towards = in_camera.head<2>();
  if (towards.norm() < 1e-6) towards = {0, 1};  // Right behind
  towards.normalize();
  const Eigen::Vector2d middle(camera.width_px / 2.0, camera.height_px / 2.0);
  const double margin = pen.Pixels(14);
  const double reach =
      std::min((middle.x() - margin) / std::max(1e-9, std::abs(towards.x())),
               (middle.y() - margin) / std::max(1e-9, std::abs(towards.y())));
  const Eigen::Vector2d tip = middle + reach * towards;
  const Eigen::Vector2d tail = tip - pen.Pixels(90) * towards;
  pen.Line(tail, tip, kSunColor, pen.Pixels(4));
  pen.Barbs(tail, tip, pen.Pixels(28), kSunColor, pen.Pixels(4));
  pen.Text(words + (in_camera.z() < 0 ? ", behind" : ""),
           tail - pen.Pixels(20) * towards + Eigen::Vector2d(0, pen.Pixels(8)),
           kSunColor);
}

}  // namespace

std::optional<Eigen::Vector3d> GroundAt(const Camera& camera,
                                        const Eigen::Vector2d& pixel,
                                        double ground_z_m) {
  const Eigen::Vector3d eye = camera.PositionInWorld(), ray = camera.RayInWorld(pixel);
  const double t = (ground_z_m - eye.z()) / ray.z();
  if (!(ray.z() < 0) || !(t > 0) || t > kFarthestGround_m) return std::nullopt;
  return eye + t * ray;
}

std::optional<Eigen::Vector3d> DefaultTrunkFoot(const Camera& camera, double ground_z_m) {
  const Eigen::Vector3d eye = camera.PositionInWorld();
  if (!(eye.z() > ground_z_m)) return std::nullopt;
  const Eigen::Vector3d forward = camera.ForwardInWorld();
  Eigen::Vector3d foot = eye + 10 * DirectionFromAzimuthElevation(AzimuthOf(forward), 0);
  foot.z() = ground_z_m;
  const auto seen = camera.Project(foot);
  const bool in_picture = seen && seen->x() > 0 && seen->x() < camera.width_px &&
                          seen->y() > 0 && seen->y() < camera.height_px;
  if (in_picture) return foot;
  return GroundAt(camera, {camera.width_px / 2.0, 0.93 * camera.height_px}, ground_z_m);
}

std::optional<Eigen::Vector3d> ShadowTip(const Eigen::Vector3d& foot_in_world,
                                         double height_m,
                                         const Eigen::Vector3d& sun_in_world) {
  if (!(sun_in_world.z() > 0)) return std::nullopt;
  Eigen::Vector3d along = -sun_in_world * (height_m / sun_in_world.z());
  along.z() = 0;
  if (along.norm() > kLongestShadow_m) along *= kLongestShadow_m / along.norm();
  return foot_in_world + along;
}

cv::Mat3b CameraOverlay(const cv::Mat3b& display_rgb,
                        const Camera& camera,
                        const CameraOverlayOptions& options) {
  Require(!display_rgb.empty() && options.longest_px > 0, "a picture to draw on");
  const double scale = std::min(1.0,
                                static_cast<double>(options.longest_px) /
                                    std::max(display_rgb.cols, display_rgb.rows));
  cv::Mat3b picture;
  cv::resize(display_rgb,
             picture,
             {},
             scale,
             scale,
             scale < 1 ? cv::INTER_AREA : cv::INTER_NEAREST);
  const Camera small = camera.Resized(picture.cols, picture.rows);

  Pen pen(picture, small);
  const double ground_z_m = options.ground_z_m;
  if (small.PositionInWorld().z() > ground_z_m) DrawGrid(pen, ground_z_m);
  DrawHorizon(pen);
  const auto foot = options.trunk_foot_in_world ? options.trunk_foot_in_world
                                                : DefaultTrunkFoot(small, ground_z_m);
  if (foot) {
    DrawTrunkAndShadow(pen, *foot, options);
    DrawNorth(pen, *foot);
  }
  if (options.sun_in_world) DrawSun(pen, *options.sun_in_world);
  if (!options.caption.empty()) {
    pen.Text(options.caption,
             {picture.cols / 2.0, static_cast<double>(picture.rows)},
             {255, 255, 255});
  }
  return picture;
}

}  // namespace relight
