// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/point_bounds.h"

#include "relight/base/error.h"
#include "relight/volume/visual_hull.h"
#include "tests/support/made_cameras.h"
#include "tests/support/reference_tree.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>

namespace relight {
namespace {

const Eigen::Vector3d kCenter(3, -2, 4);
constexpr double kRadius_m = 3.0, kDistance_m = 15.0;

// A ball from the south, `count` eyes a step apart: its silhouettes in closed form.
std::vector<MatteView> BallFromSouth(int count, double step_deg) {
  std::vector<MatteView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth_rad = RadFromDeg(180 + step_deg * (i - (count - 1) / 2.0));
    const Eigen::Vector3d eye =
        kCenter + kDistance_m * DirectionFromAzimuthElevation(azimuth_rad, 0);
    MatteView view{"view_" + std::to_string(i),
                   tests::LookingAt(eye, kCenter, 300, 300, 500),
                   cv::Mat1f(300, 300, 0.0f)};
    for (int row = 0; row < 300; ++row) {
      for (int column = 0; column < 300; ++column) {
        const Eigen::Vector3d ray = view.camera.RayInWorld({column + 0.5, row + 0.5});
        if ((kCenter - eye).cross(ray).norm() < kRadius_m) view.alpha(row, column) = 1.0f;
      }
    }
    views.push_back(view);
  }
  return views;
}

// Points on what the first and the last view both see of a ball of `radius_m`.
std::vector<Eigen::Vector3d> PointsOnBall(std::span<const MatteView> views,
                                          double radius_m,
                                          int count) {
  std::mt19937 random(3);
  std::vector<Eigen::Vector3d> points;
  while (static_cast<int>(points.size()) < count) {
    const Eigen::Vector3d normal = tests::RandomDirection(random);
    const Eigen::Vector3d point = kCenter + radius_m * normal;
    const auto is_seen = [&](const MatteView& view) {
      return (view.camera.PositionInWorld() - point).dot(normal) > 0;
    };
    if (is_seen(views.front()) && is_seen(views.back())) points.push_back(point);
  }
  return points;
}

const Eigen::AlignedBox3d kBall(kCenter - Eigen::Vector3d::Constant(kRadius_m),
                                kCenter + Eigen::Vector3d::Constant(kRadius_m));

TEST(PointBounds, CutWhatAHullOfFewViewsAddsBeforeTheTree) {
  const std::vector<MatteView> views = BallFromSouth(3, 15);
  const Eigen::AlignedBox3d hull = HullBounds(views);
  // From within 30 degrees its depth is open: the hull's front is far before the ball
  ASSERT_LT(hull.min().y(), kBall.min().y() - 0.3 * kRadius_m);
  const CutBox cut =
      CutToPoints(hull, PointsOfTree(views, PointsOnBall(views, kRadius_m, 400)), views);
  EXPECT_EQ(cut.sides, std::vector<std::string>{"south"});
  // No photo looks onto the other sides: they stay as the mattes have them
  EXPECT_EQ(cut.bounds.max(), hull.max());
  EXPECT_EQ(cut.bounds.min().x(), hull.min().x());
  EXPECT_EQ(cut.bounds.min().z(), hull.min().z());
  EXPECT_LT(cut.bounds.min().y(), kBall.min().y());
  // 15 % of the points' extent of nearly two radii
  EXPECT_GT(cut.bounds.min().y(), kBall.min().y() - 0.3 * kRadius_m);
}

TEST(PointBounds, CutNothingWhereTheyDoNotTell) {
  const std::vector<MatteView> views = BallFromSouth(3, 15);
  const Eigen::AlignedBox3d hull = HullBounds(views);
  const auto sides = [&](std::span<const Eigen::Vector3d> points) {
    return CutToPoints(hull, PointsOfTree(views, points), views).sides;
  };
  EXPECT_TRUE(sides({}).empty());
  // Too few
  EXPECT_TRUE(sides(PointsOnBall(views, kRadius_m, 190)).empty());
  // On a trunk alone, for leaves in the wind give none
  EXPECT_TRUE(sides(PointsOnBall(views, 0.3 * kRadius_m, 400)).empty());
  // Of one view that looks onto a side: nothing was seen twice there
  EXPECT_TRUE(
      CutToPoints(hull, PointsOnBall(views, kRadius_m, 400), std::span(views).first(1))
          .sides.empty());
  EXPECT_THROW(
      CutToPoints(hull, PointsOnBall(views, kRadius_m, 400), views, Progress([](double) {
                    return false;
                  })),
      Cancelled);
}

// A crown that gave points in its middle only: cut there, it would leave some of a matte
// from aside without a place.
TEST(PointBounds, CutNothingThatAMatteShows) {
  std::vector<MatteView> views = BallFromSouth(3, 15);
  std::vector<Eigen::Vector3d> points = PointsOnBall(views, kRadius_m, 2000);
  for (Eigen::Vector3d& point : points) {
    point.y() = kCenter.y() + 0.05 * (point.y() - kCenter.y());
  }
  const auto cut = [&] {
    return CutToPoints(HullBounds(views), PointsOfTree(views, points), views);
  };
  EXPECT_GT(cut().bounds.min().y(), kBall.min().y());  // Nothing tells that it is wrong
  MatteView aside = views.front();
  aside.name = "aside";
  aside.camera = tests::LookingAt(
      kCenter + kDistance_m * DirectionFromAzimuthElevation(RadFromDeg(130), 0),
      kCenter,
      300,
      300,
      500);
  views.push_back(aside);
  EXPECT_TRUE(cut().sides.empty());
}

TEST(PointBounds, CutNothingThatTheMattesBound) {
  std::vector<MatteView> views = BallFromSouth(3, 15);
  views.push_back(views.front());
  views.back().camera = tests::LookingAt(
      kCenter + kDistance_m * Eigen::Vector3d::UnitX(), kCenter, 300, 300, 500);
  const Eigen::AlignedBox3d loose(kBall.min() - Eigen::Vector3d::Constant(3),
                                  kBall.max() + Eigen::Vector3d::Constant(3));
  EXPECT_TRUE(
      CutToPoints(loose, PointsOnBall(views, kRadius_m, 400), views).sides.empty());
}

TEST(PointBounds, OfTheTreeAreThoseInNearlyAllMattes) {
  std::vector<MatteView> views;
  for (int i = 0; i < 20; ++i) {
    MatteView view = BallFromSouth(1, 0).front();
    const Eigen::Vector3d away = DirectionFromAzimuthElevation(RadFromDeg(18.0 * i), 0);
    view.camera = tests::LookingAt(kCenter + kDistance_m * away, kCenter, 300, 300, 500);
    views.push_back(view);
  }
  const std::vector<Eigen::Vector3d> inside = {
      kCenter, kCenter + Eigen::Vector3d(0, 0, 2.9), kCenter - Eigen::Vector3d(2, 2, 0)};
  std::vector<Eigen::Vector3d> all = inside;
  all.emplace_back(kCenter - Eigen::Vector3d(0, 0, 3.2));  // The ground below
  all.emplace_back(kCenter + Eigen::Vector3d(0, 9, 0));    // A wall behind, seen by some
  all.emplace_back(kCenter + Eigen::Vector3d(0, 0, 90));   // In no frame
  EXPECT_EQ(PointsOfTree(views, all), inside);
  views[3].alpha.setTo(0);  // Two bad mattes of twenty
  views[11].alpha.setTo(0);
  EXPECT_EQ(PointsOfTree(views, all), inside);
  views[15].alpha.setTo(0);
  EXPECT_TRUE(PointsOfTree(views, all).empty());
}

// Eyes a hand's breadth apart: where the rays cross is a matter of the mattes' pixels.
TEST(PointBounds, TellTheDepthThatTheMattesLeaveOpen) {
  std::vector<MatteView> views = BallFromSouth(2, 1);
  EXPECT_TRUE(IsDepthOpen(views));
  EXPECT_FALSE(IsDepthOpen(BallFromSouth(3, 15)));
  // One matte is wrong by six pixels of 200: the crossing is some metres off
  const cv::Mat1f whole = views[0].alpha.clone();
  views[0].alpha.setTo(0);
  whole(cv::Rect(0, 0, 294, 300)).copyTo(views[0].alpha(cv::Rect(6, 0, 294, 300)));
  const std::vector<Eigen::Vector3d> points =
      PointsOfTree(views, PointsOnBall(views, kRadius_m, 400));
  const Eigen::AlignedBox3d by_mattes = HullBounds(views),
                            by_points = HullBounds(views, {.middle = MiddleOf(points)});
  std::cout << "depth of the tree: " << kBall.min().y() << " to " << kBall.max().y()
            << " m; by mattes " << by_mattes.min().y() << " to " << by_mattes.max().y()
            << " m, by points " << by_points.min().y() << " to " << by_points.max().y()
            << " m\n";
  EXPECT_FALSE(by_mattes.contains(kCenter));
  EXPECT_LT(by_points.min().y(), kBall.min().y());
  EXPECT_GT(by_points.max().y(), kCenter.y());

  // From one place not even that
  const std::vector<MatteView> same = {views[0], views[0]};
  EXPECT_THROW(HullBounds(same), InputError);
  EXPECT_TRUE(HullBounds(same, {.middle = kCenter}).contains(kCenter));
}

// --- A rendered tree ----------------------------------------------------------------

// Places of the tree's leaves and bark, from its PLY of 29 bytes a face.
std::vector<Eigen::Vector3d> FoliageOf(const std::string& tree) {
  std::ifstream in(tests::SharedPath("data/" + tree + "/foliage.ply"), std::ios::binary);
  std::string line;
  std::size_t count = 0;
  while (std::getline(in, line) && line != "end_header") {
    if (line.starts_with("element vertex ")) count = std::stoul(line.substr(15));
  }
  std::vector<char> bytes(29 * count);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < count && in; ++i) {
    float xyz[3];
    std::memcpy(xyz, bytes.data() + 29 * i, sizeof xyz);
    points.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  return points;
}

// Some of those that two views or more see, as a reconstruction finds them.
std::vector<Eigen::Vector3d> SeenTwice(std::span<const MatteView> views,
                                       const std::vector<Eigen::Vector3d>& foliage,
                                       std::size_t most) {
  std::vector<int> seen(foliage.size(), 0);
  for (const MatteView& view : views) {
    // The nearest of each 2 x 2 pixels
    constexpr double kNear_m = 0.1;
    cv::Mat1d nearest(view.alpha.rows / 2 + 1,
                      view.alpha.cols / 2 + 1,
                      std::numeric_limits<double>::max());
    const auto at = [&](const Eigen::Vector3d& point) -> double* {
      const auto pixel = view.camera.Project(point);
      if (!pixel || !(pixel->minCoeff() >= 0 && pixel->x() < view.alpha.cols &&
                      pixel->y() < view.alpha.rows)) {
        return nullptr;
      }
      return &nearest(static_cast<int>(pixel->y() / 2), static_cast<int>(pixel->x() / 2));
    };
    const auto away_m = [&](const Eigen::Vector3d& point) {
      return (point - view.camera.PositionInWorld()).norm();
    };
    for (const Eigen::Vector3d& point : foliage) {
      if (double* d = at(point)) *d = std::min(*d, away_m(point));
    }
    for (std::size_t i = 0; i < foliage.size(); ++i) {
      const double* d = at(foliage[i]);
      seen[i] += d != nullptr && away_m(foliage[i]) < *d + kNear_m;
    }
  }
  std::vector<Eigen::Vector3d> found;
  for (std::size_t i = 0; i < foliage.size(); ++i) {
    if (seen[i] >= 2) found.push_back(foliage[i]);
  }
  std::mt19937 random(5);
  std::shuffle(found.begin(), found.end(), random);
  if (found.size() > most) found.resize(most);
  std::normal_distribution<double> error_m(0, 0.03);  // Of triangulation
  for (Eigen::Vector3d& point : found) {
    point += Eigen::Vector3d(error_m(random), error_m(random), error_m(random));
  }
  return found;
}

TEST(PointBounds, CutNoLeafOfRenderedTrees) {
  for (const std::string tree_name : {"maple", "birch"}) {
    RELIGHT_SKIP_WITHOUT_SHARED("reference/cabral2011/" + tree_name);
    RELIGHT_SKIP_WITHOUT_SHARED("data/" + tree_name + "/foliage.ply");
    const tests::ReferenceTree tree = tests::ReadReferenceTree(tree_name);
    const std::vector<Eigen::Vector3d> foliage = FoliageOf(tree_name);
    ASSERT_GT(foliage.size(), 10'000u);
    for (const std::vector<std::size_t>& chosen :
         {std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11},
          {0, 3, 6, 9},
          {0, 1, 2, 3},
          {11, 0, 1},
          {4, 5},
          {0, 1}}) {
      std::vector<MatteView> views;
      for (const std::size_t v : chosen) {
        const auto& [view, camera] = tree.cameras[v];
        views.push_back({view, camera, tests::ReadTrueMatte(tree_name, view)});
      }
      const Eigen::AlignedBox3d hull = HullBounds(views);
      for (const std::size_t most : {500u, 3000u}) {
        const std::vector<Eigen::Vector3d> points =
            PointsOfTree(views, SeenTwice(views, foliage, most));
        const CutBox cut = CutToPoints(hull, points, views);
        std::size_t lost = 0;
        for (const Eigen::Vector3d& leaf : foliage) {
          lost += hull.contains(leaf) && !cut.bounds.contains(leaf);
        }
        std::string sides;
        for (const std::string& side : cut.sides) sides += " " + side;
        std::cout << tree_name << ", " << views.size() << " views, " << points.size()
                  << " points: hull " << hull.volume() << " m3, cut to "
                  << cut.bounds.volume() << " m3 (tree's box " << tree.true_box.volume()
                  << " m3):" << (sides.empty() ? " nothing" : sides) << ", " << lost
                  << " of " << foliage.size() << " leaves lost\n";
        EXPECT_EQ(lost, 0u);
        // From within 60 degrees a hull is twice as large as the tree's box
        if (chosen.size() == 3) {
          EXPECT_LT(cut.bounds.volume(), 0.9 * hull.volume());
        }
      }
    }
  }
}

}  // namespace
}  // namespace relight
