// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether the mattes leave room for the tree that they show. One matte that misses the
// tree, or a camera that is off, carves the hull, and what the others show has no place.
//
//   lost(k) = share of the rays of alpha > 0.9, of all mattes, that meet no voxel whose
//             k-th smallest footprint (footprint_opacity.h) is above 0.1          (V4)
//
// on 32 voxels along the box's longest side.

#include "relight/base/progress.h"
#include "relight/volume/footprint_opacity.h"

#include <Eigen/Geometry>

#include <span>

namespace relight {

// (V4), in [0, 1]. Throws as FootprintOpacity.
double LostShare(std::span<const MatteView> views,
                 const Eigen::AlignedBox3d& bounds_in_world,
                 int kth_smallest);

struct MatteAgreement {
  int kth_smallest = 1;  // To start from: 3 where that saves half of a loss above 2 %.
  double lost = 0.0;     // (V4) of the smallest,
  double left = 0.0;     // and of the chosen one.
};

// Of six views or more; fewer always start from the smallest. Throws as HullBounds with
// kth_smallest 3, whose box it looks at, and FootprintOpacity.
MatteAgreement AgreementOf(std::span<const MatteView> views,
                           const Progress& progress = {});

}  // namespace relight
