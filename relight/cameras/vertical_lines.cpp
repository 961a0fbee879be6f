// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/vertical_lines.h"

#include "relight/base/angles.h"
#include "relight/cameras/photo_orientation.h"

#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace relight {
namespace {

constexpr int kLongest_px = 1600;         // Finer than this, bark and noise make lines.
constexpr double kSteepest_deg = 20;      // From upright, of lines that may vote.
constexpr double kShortest = 0.04;        // Of the photo's height.
constexpr std::size_t kMostVoters = 160;  // The longest; every pair of them is tried.
constexpr double kAgree_deg = 0.5;
constexpr int kFewestLines = 8;
constexpr double kLeastShare = 0.5;
constexpr double kLeastSpread = 0.25;    // Of the width, between the outer eighths.
constexpr double kLineNoise_deg = 0.15;  // No segment is taken to be better than this.
constexpr double kWorstError_deg = 1.0;

struct Line {
  Eigen::Vector3d plane;  // Unit normal m.
  double length_px = 0;
  double x_px = 0;  // Of its middle.
};

std::vector<Line> NearlyUpright(const cv::Mat1b& grey,
                                double focal_px,
                                const Eigen::Vector2d& center_px) {
  std::vector<cv::Vec4f> segments;
  cv::createLineSegmentDetector()->detect(grey, segments);
  std::vector<Line> lines;
  for (const cv::Vec4f& s : segments) {
    const Eigen::Vector2d a(s[0], s[1]), b(s[2], s[3]), along = b - a;
    const double from_upright = std::atan2(std::abs(along.x()), std::abs(along.y()));
    if (along.norm() < kShortest * grey.rows || from_upright > RadFromDeg(kSteepest_deg))
      continue;
    const Eigen::Vector3d ray_a = ((a - center_px) / focal_px).homogeneous();
    const Eigen::Vector3d ray_b = ((b - center_px) / focal_px).homogeneous();
    lines.push_back({ray_a.cross(ray_b).normalized(), along.norm(), (a.x() + b.x()) / 2});
  }
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) {
    return a.length_px > b.length_px;
  });
  return lines;
}

bool Agrees(const Line& line, const Eigen::Vector3d& up) {
  return std::abs(line.plane.dot(up)) < std::sin(RadFromDeg(kAgree_deg));
}

bool IsPlausible(const Eigen::Vector3d& up) {
  return std::abs(PitchOf(up)) < RadFromDeg(35) && std::abs(RollOf(up)) < RadFromDeg(15);
}

double LengthThatAgrees(const std::vector<Line>& lines, const Eigen::Vector3d& up) {
  double length_px = 0;
  for (const Line& line : lines) length_px += Agrees(line, up) ? line.length_px : 0;
  return length_px;
}

Eigen::Vector3d Upwards(const Eigen::Vector3d& up) {
  return up.y() < 0 ? up : Eigen::Vector3d(-up);
}

// The pair of lines whose meeting point most length agrees with.
Eigen::Vector3d BestPair(const std::vector<Line>& lines) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most_px = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t j = i + 1; j < lines.size(); ++j) {
      const Eigen::Vector3d meet = lines[i].plane.cross(lines[j].plane);
      if (meet.norm() < std::sin(RadFromDeg(1))) continue;  // One line in two pieces
      const Eigen::Vector3d up = Upwards(meet.normalized());
      if (!IsPlausible(up)) continue;
      const double length_px = LengthThatAgrees(lines, up);
      if (length_px > most_px) {
        most_px = length_px;
        best = up;
      }
    }
  }
  return best;
}

}  // namespace

std::optional<UprightLines> FindUprightLines(const cv::Mat1b& grey,
                                             double focal_px,
                                             const Eigen::Vector2d& center_px) {
  // At a size where lines are lines
  const double scale =
      std::min(1.0, static_cast<double>(kLongest_px) / std::max(grey.cols, grey.rows));
  cv::Mat1b small = grey;
  if (scale < 1) cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  const std::vector<Line> lines =
      NearlyUpright(small, focal_px * scale, center_px * scale);
  if (lines.size() < kFewestLines) return std::nullopt;

  // Vote
  const std::vector<Line> voters(
      lines.begin(),
      lines.begin() + static_cast<std::ptrdiff_t>(std::min(lines.size(), kMostVoters)));
  Eigen::Vector3d up = BestPair(voters);
  if (up.isZero()) return std::nullopt;

  // (C5) over the lines that agree, which may change as n does
  UprightLines found;
  std::vector<double> middles_px;
  for (int pass = 0; pass < 5; ++pass) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    double weight = 0, squares = 0, all_px = 0;
    middles_px.clear();
    for (const Line& line : lines) {
      all_px += line.length_px;
      if (!Agrees(line, up)) continue;
      normal += line.length_px * line.plane * line.plane.transpose();
      weight += line.length_px;
      squares += line.length_px * std::pow(line.plane.dot(up), 2);
      middles_px.push_back(line.x_px);
    }
    found.lines = static_cast<int>(middles_px.size());
    if (found.lines < kFewestLines) return std::nullopt;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal / weight);
    up = Upwards(solver.eigenvectors().col(0));

    // Two directions of n are free; the worse known one rules
    const double noise_rad =
        std::max(std::sqrt(squares / weight), RadFromDeg(kLineNoise_deg));
    found.error_deg =
        DegFromRad(noise_rad / std::sqrt(solver.eigenvalues()[1] * found.lines));
    found.share = weight / all_px;
  }
  found.up_in_camera = up;

  // Unsure is nothing
  std::sort(middles_px.begin(), middles_px.end());
  const std::size_t eighth = middles_px.size() / 8;
  const double spread_px =
      middles_px[middles_px.size() - 1 - eighth] - middles_px[eighth];
  if (found.share < kLeastShare || spread_px < kLeastSpread * small.cols ||
      !(found.error_deg <= kWorstError_deg) || !IsPlausible(up)) {
    return std::nullopt;
  }
  return found;
}

}  // namespace relight
