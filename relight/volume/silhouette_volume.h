// SPDX-License-Identifier: Apache-2.0
#pragma once

// A round volume from one matte alone: a stand-in for the reconstruction, and said to be.
//
// Each row of the matte is as deep as it is wide: its cross-section at the tree's
// distance is a circle around the row's middle. Along the chord that a pixel's ray cuts
// from it, extinction is constant and gives the matte back:
//
//   sigma = -ln(1 - alpha) / (2 sqrt(r^2 - x^2) / cos t)                  (V2)
//
// with r half the row's width [m], x the pixel's distance from its middle [m] and t the
// angle between the ray and the level direction ahead. Rows lie on the upright plane
// through the tree's axis, so that the tree stands upright before a tilted camera too;
// the rows of a rolled camera are taken as level circles all the same.

#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"

namespace relight {

struct SilhouetteOptions {
  int cells = 100;             // Along the box's longest side.
  double alpha_max = 0.995;    // Mattes are clipped here.
  double outline_alpha = 0.1;  // A row reaches from the first to the last pixel above it.
  double scale = 1.0;          // Multiplies the extinction.
};

// `tree_distance_m`: from the camera to the tree's axis along the ground, straight ahead.
// Throws InputError when the matte holds no tree.
ExtinctionGrid SilhouetteVolume(const MatteView& view,
                                double tree_distance_m,
                                const SilhouetteOptions& options = {});

}  // namespace relight
