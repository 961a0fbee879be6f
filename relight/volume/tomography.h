// SPDX-License-Identifier: Apache-2.0
#pragma once

// Extinction of a tree from its alpha mattes, by regularised least squares on the mattes
// themselves. With s_i = sigma_i cell_m the optical depth of a voxel along its edge and
// l_pi the exact length of ray p in it, in edges:
//
//   minimise  sum_v w_v sum_p a_v q_p (1 - exp(-sum_i l_pi s_i) - alpha_p)^2
//             + smoothness kappa r^2 TV(s),   s >= 0                       (V3)
//   TV(s) = sum_i sqrt(|grad s|_i^2 + epsilon^2)      forward differences
//
// A ray stands for a square of about 2/3 of a voxel at the tree, over which the matte is
// averaged, and weighs a_v, its area over that of a voxel's face. r^2 is the mean squared
// residual where there is tree, so that the weight of the prior follows the noise of
// mattes and cameras (the maximum a posteriori of a fixed prior). w_v takes a matte back
// that does not fit the others. A matte of 1 is one-sided: beyond saturation its gradient
// vanishes. Leaves at random spread alpha by alpha (1 - alpha) over a footprint: with c
// above 0, q_p = (0.12 + c) / (alpha_p (1 - alpha_p) + c), else 1. Voxels that no ray
// reaches, for all is opaque before them, hold what the prior continues from their
// surroundings.
//
// Solved coarse to fine: at each resolution by projected gradient steps with separable
// quadratic surrogates [Erdogan99] and Nesterov's momentum, restarted where it leads
// uphill [ODonoghue15] (docs/bibliography.md).

#include "relight/base/progress.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace relight {

struct TomographyOptions {
  int cells = 100;           // Along the box's longest side.
  int passes = 16;           // At the finest resolution; twice as many at coarser ones.
  double smoothness = 1.0;   // Of the prior's weight.
  double leaf_spread = 0.0;  // c of q_p.
  int kth_smallest = 1;      // What the k-th smallest footprint calls empty stays so.
};

struct ViewWeight {
  std::string view = {};
  double residual_rms = 0.0;  // Of the rays where matte or volume is above 0.02.
  double weight = 1.0;        // w_v.
};

struct Tomography {
  ExtinctionGrid grid;
  std::vector<ViewWeight> views;
  std::vector<double> objective;  // (V3) after each pass, all resolutions after another.
  std::size_t hidden_voxels = 0;  // That no photo sees: filled from their surroundings.
  std::uint64_t crossings = 0;    // Of a ray and a voxel, in all passes.
};

// Memory grows with the voxels that the mattes leave. The same bytes for any number of
// threads. Throws InputError when nothing is left of the tree,
// Cancelled; and as FootprintOpacity.
Tomography EstimateTomography(std::span<const MatteView> views,
                              const Eigen::AlignedBox3d& bounds_in_world,
                              const TomographyOptions& options = {},
                              const Progress& progress = {});

}  // namespace relight
