// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/point_bounds.h"

#include "relight/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace relight {
namespace {

constexpr float kTree = 0.5f;
constexpr std::size_t kFewestPoints = 200;
constexpr std::ptrdiff_t kFewestViews = 2;
constexpr double kOnto = 0.5;      // Cosine: within 60 degrees of the side's normal
constexpr double kAcross = 0.5;    // Cosine: within 30 degrees across it
constexpr double kOutside = 0.01;  // Points beyond are strays
constexpr double kMargin = 0.15;   // Of the points' longest extent
constexpr double kCovers = 0.6;    // Of the matte's width and height
constexpr double kMostLost = 0.002;

constexpr std::array<std::array<const char*, 2>, 3> kSides = {
    {{"west", "east"}, {"south", "north"}, {"bottom", "top"}}};

// Nothing outside of the frame, and behind the camera.
std::optional<float> AlphaAt(const MatteView& view, const Eigen::Vector3d& point) {
  const auto pixel = view.camera.Project(point);
  if (!pixel) return std::nullopt;
  const double x = std::floor(pixel->x()), y = std::floor(pixel->y());
  if (!(x >= 0 && y >= 0 && x < view.alpha.cols && y < view.alpha.rows)) {
    return std::nullopt;
  }
  return view.alpha(static_cast<int>(y), static_cast<int>(x));
}

// The value that a share of them is below.
double Quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double Spread(const std::vector<double>& values) {
  return Quantile(values, 1 - kOutside) - Quantile(values, kOutside);
}

// Whether the points are all over the view's matte, and not on its trunk alone.
bool CoverMatte(const MatteView& view, std::span<const Eigen::Vector3d> points) {
  std::vector<double> x, y, tree_x, tree_y;
  for (const Eigen::Vector3d& point : points) {
    if (!AlphaAt(view, point)) continue;
    const Eigen::Vector2d pixel = *view.camera.Project(point);
    x.push_back(pixel.x());
    y.push_back(pixel.y());
  }
  for (int row = 0; row < view.alpha.rows; ++row) {
    for (int column = 0; column < view.alpha.cols; ++column) {
      if (view.alpha(row, column) <= kTree) continue;
      tree_x.push_back(column);
      tree_y.push_back(row);
    }
  }
  if (x.size() < kFewestPoints / 2 || tree_x.empty()) return false;
  return Spread(x) > kCovers * Spread(tree_x) && Spread(y) > kCovers * Spread(tree_y);
}

// Share of the view's tree whose rays miss the box.
double LostOf(const MatteView& view, const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d eye = view.camera.PositionInWorld();
  std::size_t tree = 0, lost = 0;
  for (int row = 0; row < view.alpha.rows; ++row) {
    for (int column = 0; column < view.alpha.cols; ++column) {
      if (view.alpha(row, column) <= kTree) continue;
      ++tree;
      const Eigen::Array3d ray =
          view.camera.RayInWorld({column + 0.5, row + 0.5}).array();
      const Eigen::Array3d a = (box.min() - eye).array() / ray,
                           b = (box.max() - eye).array() / ray;
      const double in = a.min(b).maxCoeff(), out = a.max(b).minCoeff();
      lost += !(out >= std::max(in, 0.0));
    }
  }
  return tree > 0 ? static_cast<double>(lost) / static_cast<double>(tree) : 0;
}

}  // namespace

std::vector<Eigen::Vector3d> PointsOfTree(std::span<const MatteView> views,
                                          std::span<const Eigen::Vector3d> points) {
  std::vector<Eigen::Vector3d> of_tree;
  for (const Eigen::Vector3d& point : points) {
    int seen = 0, inside = 0;
    for (const MatteView& view : views) {
      const auto alpha = AlphaAt(view, point);
      seen += alpha.has_value();
      inside += alpha && *alpha > kTree;
    }
    if (inside >= 2 && seen - inside <= seen / 10) of_tree.push_back(point);
  }
  return of_tree;
}

Eigen::Vector3d MiddleOf(std::span<const Eigen::Vector3d> points) {
  Require(!points.empty(), "a middle is of one point or more");
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& point : points) values.push_back(point[axis]);
    middle[axis] = Quantile(std::move(values), 0.5);
  }
  return middle;
}

CutBox CutToPoints(const Eigen::AlignedBox3d& hull,
                   std::span<const Eigen::Vector3d> points_of_tree,
                   std::span<const MatteView> views,
                   const Progress& progress) {
  CutBox cut{hull};
  if (points_of_tree.size() < kFewestPoints) return cut;
  const Eigen::Vector3d middle = MiddleOf(points_of_tree);
  std::vector<Eigen::Vector3d> eyes;  // Of the views whose matte the points cover
  std::vector<double> lost;
  for (const MatteView& view : views) {
    progress.Report(0.5 * static_cast<double>(lost.size()) /
                    static_cast<double>(views.size()));
    lost.push_back(LostOf(view, hull));
    if (CoverMatte(view, points_of_tree)) eyes.push_back(view.camera.PositionInWorld());
  }

  // All but the strays, along each axis
  Eigen::AlignedBox3d of_points;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& point : points_of_tree) values.push_back(point[axis]);
    of_points.min()[axis] = Quantile(values, kOutside);
    of_points.max()[axis] = Quantile(values, 1 - kOutside);
  }
  const double margin_m = kMargin * of_points.sizes().maxCoeff();

  for (int side = 0; side < 6; ++side) {
    progress.Report(0.5 + side / 12.0);
    const int axis = side / 2;
    const bool is_high = side % 2 == 1;
    const auto cosine = [&](const Eigen::Vector3d& eye) {
      const double of_axis = (eye - middle).normalized()[axis];
      return is_high ? of_axis : -of_axis;
    };
    const bool is_open = std::all_of(views.begin(), views.end(), [&](const auto& view) {
      return std::abs(cosine(view.camera.PositionInWorld())) > kAcross;
    });
    const auto onto = std::count_if(
        eyes.begin(), eyes.end(), [&](const auto& eye) { return cosine(eye) > kOnto; });
    if (!is_open || onto < kFewestViews) continue;
    CutBox tried = cut;
    double& limit = is_high ? tried.bounds.max()[axis] : tried.bounds.min()[axis];
    const double of_side =
        is_high ? of_points.max()[axis] + margin_m : of_points.min()[axis] - margin_m;
    if (is_high ? of_side >= limit : of_side <= limit) continue;
    limit = of_side;
    bool holds_trees = !tried.bounds.isEmpty();
    for (std::size_t v = 0; v < views.size() && holds_trees; ++v) {
      holds_trees = LostOf(views[v], tried.bounds) - lost[v] <= kMostLost;
    }
    if (!holds_trees) continue;
    cut.bounds = tried.bounds;
    cut.sides.emplace_back(kSides[static_cast<std::size_t>(axis)][is_high ? 1 : 0]);
  }
  progress.Report(1);
  return cut;
}

}  // namespace relight
