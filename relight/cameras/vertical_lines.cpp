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
constexpr double kAgree_deg = 0.3;
constexpr int kFewestLines = 8;
constexpr double kLeastShare = 0.5;
constexpr double kLeastSpread = 0.25;    // Of the width, between the outer eighths.
constexpr double kLeastError_deg = 0.1;  // What an unknown lens leaves at best.
constexpr double kWorstError_deg = 1.0;

// k1 of a lens whose corners are seen nearer to the middle by a share `bend`, about.
constexpr double kMostBend = 0.14, kBendStep = 0.02;
constexpr double kClearlyBetter = 1.1;

struct Line {
  Eigen::Vector3d plane;  // Unit normal m.
  double length_px = 0;
  double x_px = 0, y_px = 0;  // Of its middle.
};

std::vector<cv::Vec4f> NearlyUpright(const cv::Mat1b& grey) {
  std::vector<cv::Vec4f> segments;
  cv::createLineSegmentDetector()->detect(grey, segments);
  std::erase_if(segments, [&](const cv::Vec4f& s) {
    const double x = std::abs(s[2] - s[0]), y = std::abs(s[3] - s[1]);
    return std::hypot(x, y) < kShortest * grey.rows ||
           std::atan2(x, y) > RadFromDeg(kSteepest_deg);
  });
  return segments;
}

// Longest first.
std::vector<Line> LinesThrough(const Camera& camera,
                               const std::vector<cv::Vec4f>& segments) {
  std::vector<Line> lines;
  for (const cv::Vec4f& s : segments) {
    const Eigen::Vector2d a(s[0], s[1]), b(s[2], s[3]);
    const Eigen::Vector3d plane = camera.RayInWorld(a).cross(camera.RayInWorld(b));
    lines.push_back(
        {plane.normalized(), (b - a).norm(), (a.x() + b.x()) / 2, (a.y() + b.y()) / 2});
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
struct Vote {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  double length_px = 0;
};

Vote BestPair(const std::vector<Line>& lines) {
  const std::size_t voters = std::min(lines.size(), kMostVoters);
  Vote best;
  for (std::size_t i = 0; i < voters; ++i) {
    for (std::size_t j = i + 1; j < voters; ++j) {
      const Eigen::Vector3d meet = lines[i].plane.cross(lines[j].plane);
      if (meet.norm() < std::sin(RadFromDeg(1))) continue;  // One line in two pieces
      const Eigen::Vector3d up = Upwards(meet.normalized());
      if (!IsPlausible(up)) continue;
      const double length_px = LengthThatAgrees(lines, up);
      if (length_px > best.length_px) best = {up, length_px};
    }
  }
  return best;
}

// (C5)
Eigen::Vector3d MeetingPoint(const std::vector<Line>& lines) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const Line& line : lines)
    normal += line.length_px * line.plane * line.plane.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal);
  return Upwards(solver.eigenvectors().col(0));
}

std::vector<double> Sorted(const std::vector<Line>& lines, double Line::*of) {
  std::vector<double> values;
  for (const Line& line : lines) values.push_back(line.*of);
  std::sort(values.begin(), values.end());
  return values;
}

// How much n depends on a quarter of the photo's lines: jackknife over the four parts
// left and right, above and below. A lens that bends lines bends each part's its own way,
// which the lines' own scatter does not show.
double ErrorByQuarters(const std::vector<Line>& lines, const Eigen::Vector3d& up) {
  const double middle_x = Sorted(lines, &Line::x_px)[lines.size() / 2];
  const double middle_y = Sorted(lines, &Line::y_px)[lines.size() / 2];
  double squares = 0;
  for (int part = 0; part < 4; ++part) {
    std::vector<Line> others;
    for (const Line& line : lines) {
      const int of = (line.x_px < middle_x ? 0 : 1) + (line.y_px < middle_y ? 0 : 2);
      if (of != part) others.push_back(line);
    }
    if (others.size() >= 2)
      squares += std::pow(AngleBetween(MeetingPoint(others), up), 2);
  }
  return std::max(DegFromRad(std::sqrt(0.75 * squares)), kLeastError_deg);
}

}  // namespace

std::optional<UprightLines> FindUprightLines(const cv::Mat1b& grey,
                                             const Camera& camera) {
  // At a size where lines are lines
  const double scale =
      std::min(1.0, static_cast<double>(kLongest_px) / std::max(grey.cols, grey.rows));
  cv::Mat1b small = grey;
  if (scale < 1) cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  const std::vector<cv::Vec4f> segments = NearlyUpright(small);
  if (segments.size() < kFewestLines) return std::nullopt;

  // Vote, through lenses that bend more and more; none first
  Camera lens;
  lens.focal_px = camera.focal_px * scale;
  lens.center_px = camera.center_px * scale;
  const double corner2 =
      lens.center_px.cwiseQuotient(lens.focal_px).squaredNorm();  // r^2 of (C1)
  std::vector<Line> lines = LinesThrough(lens, segments);
  Vote best = BestPair(lines);
  best.length_px *= kClearlyBetter;
  Lens best_lens;
  for (double bend = -2 * kBendStep; bend < kMostBend; bend += kBendStep) {
    lens.lens.k1 = -bend / corner2;
    std::vector<Line> bent = LinesThrough(lens, segments);
    const Vote vote = BestPair(bent);
    if (vote.length_px <= best.length_px) continue;
    best = vote;
    best_lens = lens.lens;
    lines = std::move(bent);
  }
  Eigen::Vector3d up = best.up;
  if (up.isZero()) return std::nullopt;

  // (C5) over the lines that agree, which may change as n does
  UprightLines found;
  found.lens = best_lens;
  std::vector<Line> agreeing;
  for (int pass = 0; pass < 5; ++pass) {
    agreeing.clear();
    double all_px = 0, agreed_px = 0;
    for (const Line& line : lines) {
      all_px += line.length_px;
      if (!Agrees(line, up)) continue;
      agreeing.push_back(line);
      agreed_px += line.length_px;
    }
    if (agreeing.size() < kFewestLines) return std::nullopt;
    up = MeetingPoint(agreeing);
    found.share = agreed_px / all_px;
  }
  found.up_in_camera = up;
  found.lines = static_cast<int>(agreeing.size());
  found.error_deg = ErrorByQuarters(agreeing, up);

  // Unsure is nothing
  const std::vector<double> middles_px = Sorted(agreeing, &Line::x_px);
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
