// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a reconstruction's sparse points say of where the tree is. Mattes of few photos
// leave its depth open: their hull runs on before and behind the tree, where no point
// lies. Points are few and on the side that photos look at, so that they say nothing of
// the other side.

#include "relight/base/progress.h"
#include "relight/volume/footprint_opacity.h"

#include <Eigen/Geometry>

#include <span>
#include <string>
#include <vector>

namespace relight {

// The points that are within the matte (alpha > 0.5) of all views whose frame has them
// but one in ten, and of two at least.
std::vector<Eigen::Vector3d> PointsOfTree(std::span<const MatteView> views,
                                          std::span<const Eigen::Vector3d> points);

// The middle of PointsOfTree, in the median of each axis. Never of none.
Eigen::Vector3d MiddleOf(std::span<const Eigen::Vector3d> points);

struct CutBox {
  Eigen::AlignedBox3d bounds;
  std::vector<std::string> sides = {};  // That were cut: "south", "top".
};

// `hull` (HullBounds) with those sides moved in that reach beyond the tree's points. All
// but 1 % of the points, and 15 % of their longest extent more, stay inside. A side is
// cut only
// - where the mattes leave it open: no view looks across its axis within 30 degrees;
// - where the points can tell: of 200 points, from two views or more that look onto it
//   within 60 degrees and have points all over their matte;
// - when all of every matte's tree but 0.2 % can still be within the box.
// Throws Cancelled.
CutBox CutToPoints(const Eigen::AlignedBox3d& hull,
                   std::span<const Eigen::Vector3d> points_of_tree,
                   std::span<const MatteView> views,
                   const Progress& progress = {});

}  // namespace relight
