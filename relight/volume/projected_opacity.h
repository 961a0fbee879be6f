// SPDX-License-Identifier: Apache-2.0
#pragma once

// Extinction of a tree from its alpha mattes, by the projections of [Reche04 §5, App. A].
//
// The transparency of a matte's pixel p is the product of those of the cells its ray
// crosses; logarithms q = ln t make it a plane, onto which all n cells are projected:
//
//   ln t_p = sum_i ln t_i                                        [Reche04, Eq. 9]
//   q'_i = q_i + (q_p - sum_k q_k) / n,   t'_i = min(exp(q'_i), 1)
//   delta_i = w_i (t'_i - t_i)                                   [Reche04, Eq. 13]
//
// with w_i the part of the pixel's pyramid inside the cell over the cell's volume (length
// of the ray in the cell x distance^2 x the pixel's area at distance 1). After all pixels
// of all mattes each cell moves by sum(delta) / sum(w), and is emptied for good where t
// exceeds the cutoff. (That t' stays <= 1 is not in the paper: a cell cannot shine.
// Without it the volumes are thinner and fit the mattes worse.) Cells start from their
// footprints (footprint_opacity.h). What is stored is extinction, (V1).

#include "relight/base/progress.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"

#include <span>

namespace relight {

struct ProjectedOpacityOptions {
  int cells = 100;           // Along the box's longest side.
  int iterations = 8;        // [Reche04]: 3 to 4 suffice; 3 to 8 measured here.
  double alpha_max = 0.995;  // Mattes are clipped here: ln t_p is infinite at 1.
  double cutoff = 0.94;      // Transparency of a cell above which it is emptied.
  int kth_smallest = 1;      // Start from the k-th smallest footprint: k - 1 bad mattes.
};

// Throws InputError when nothing is left of the tree, Cancelled; and as FootprintOpacity.
ExtinctionGrid ProjectedOpacity(std::span<const MatteView> views,
                                const Eigen::AlignedBox3d& bounds_in_world,
                                const ProjectedOpacityOptions& options = {},
                                const Progress& progress = {});

}  // namespace relight
