// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the tree is: the box around all that no matte calls empty; and that part of a
// box of the user's own.

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/volume/footprint_opacity.h"

#include <Eigen/Geometry>

#include <optional>
#include <span>
#include <string>

namespace relight {

struct VolumeBoxOptions {
  std::string box;  // Two opposite corners; empty: as the mattes show it.
};

template <class Visitor>
void Describe(VolumeBoxOptions& o, Visitor&& field) {
  field(o.box,
        FieldInfo{"box",
                  "m",
                  "X,Y,Z,X,Y,Z: two opposite corners, east, north, up, of the box that "
                  "--cells divides; what of it the mattes call empty costs nothing. "
                  "Empty: as the mattes show the tree"});
}

struct HullOptions {
  int kth_smallest = 1;       // k - 1 mattes may miss a part (footprint_opacity.h).
  double least_alpha = 0.02;  // Footprints below are empty.
  // Of the tree, where the mattes leave it open (IsDepthOpen); unset: as they show it.
  std::optional<Eigen::Vector3d> middle = {};
};

// Whether the rays through the mattes' centres cross within 6 degrees or so, which hardly
// tells how far away the tree is. Throws InputError when a matte is empty.
bool IsDepthOpen(std::span<const MatteView> views);

// Box in the world of the voxels whose k-th smallest footprint is at least `least_alpha`,
// found coarse to fine, grown by one fine voxel. Starts from the sphere that the mattes'
// outlines leave around the point nearest to the rays through their centres, or around
// options.middle.
// Throws InputError with the remedy when a matte is empty or no voxel remains.
Eigen::AlignedBox3d HullBounds(std::span<const MatteView> views,
                               const HullOptions& options = {},
                               const Progress& progress = {});

// Whole voxels of a box, `cells` along the longest side of `bounds`.
struct VoxelBox {
  Eigen::AlignedBox3d bounds;
  int cells = 0;
};

// Of the voxels of `box`, cells_longest along its longest side, the smallest box of those
// that reach into `hull`: the same voxels, without the empty ones around them. Throws
// OptionError for an empty box, InputError when they do not meet.
VoxelBox PartWithin(const Eigen::AlignedBox3d& box,
                    int cells_longest,
                    const Eigen::AlignedBox3d& hull);

// The corners of VolumeBoxOptions::box. Throws OptionError.
Eigen::AlignedBox3d BoxFromText(const std::string& corners);

}  // namespace relight
