// SPDX-License-Identifier: Apache-2.0
#pragma once

// A volume from one matte alone: a stand-in for the reconstruction, and said to be.
//
// The cross-section of each row of the matte is an ellipse around the row's middle at the
// tree's distance: half as wide as the row, r, and of half the depth d that the crown's
// shape gives it. Along the chord that a pixel's ray cuts from it, extinction is constant
// and gives the matte back:
//
//   sigma = -ln(1 - alpha) / (2 d sqrt(1 - x^2 / r^2) / cos t)            (V2)
//
// with x the pixel's distance from the row's middle [m] and t the angle between the ray
// and the level direction ahead. Rows lie on the upright plane through the tree's axis,
// so that the tree stands upright before a tilted camera too; the rows of a rolled camera
// are taken as level all the same.
//
// With k the depth ratio, R half the crown's largest width, and u from 0 at the crown's
// base to 1 at its top, d = k r for kAuto, and k R times sqrt(1 - (2u - 1)^2) for kRound,
// 1 - u for kCone, u for kVase, 1 for kColumnar. The crown's base is where rows, from the
// foot up, are first wider than a third of the widest; below is the trunk, d = r.

#include "relight/base/field.h"
#include "relight/base/field_text.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"

#include <span>

namespace relight {

enum class Crown { kAuto, kRound, kCone, kVase, kColumnar };
inline constexpr EnumWord<Crown> kCrownWords[] = {{"auto", Crown::kAuto},
                                                  {"round", Crown::kRound},
                                                  {"cone", Crown::kCone},
                                                  {"vase", Crown::kVase},
                                                  {"columnar", Crown::kColumnar}};
inline std::span<const EnumWord<Crown>> EnumWords(Crown) { return kCrownWords; }

// What only a volume from a silhouette has to be told.
struct CrownOptions {
  Crown crown = Crown::kAuto;
  double depth_ratio = 1.0;
};

template <class Visitor>
void Describe(CrownOptions& o, Visitor&& field) {
  field(o.crown,
        FieldInfo{"crown",
                  "",
                  "one photo alone: how deep the crown is at each height: auto (as deep "
                  "as it is wide there), round, cone, vase or columnar"});
  field(o.depth_ratio,
        FieldInfo{"depth-ratio",
                  "",
                  "one photo alone: the crown's depth over its width",
                  Between(0.1, 10)});
}

struct SilhouetteOptions {
  int cells = 100;             // Along the box's longest side.
  double alpha_max = 0.995;    // Mattes are clipped here.
  double outline_alpha = 0.1;  // A row reaches from the first to the last pixel above it.
  double scale = 1.0;          // Multiplies the extinction.
  CrownOptions shape = {};
};

// `tree_distance_m`: from the camera to the tree's axis along the ground, straight ahead.
// Throws InputError when the matte holds no tree.
ExtinctionGrid SilhouetteVolume(const MatteView& view,
                                double tree_distance_m,
                                const SilhouetteOptions& options = {});

}  // namespace relight
