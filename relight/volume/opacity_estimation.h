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

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"

#include <span>

namespace relight {

struct OpacityOptions {
  int cells = 100;           // Along the box's longest side.
  int iterations = 8;        // [Reche04]: 3 to 4 suffice; 3 to 8 measured here.
  double alpha_max = 0.995;  // Mattes are clipped here: ln t_p is infinite at 1.
  double cutoff = 0.94;      // Transparency of a cell above which it is emptied.
  int kth_smallest = 1;      // Start from the k-th smallest footprint: k - 1 bad mattes.
  double scale = 1.0;        // s of [Cabral11 §7.1]: multiplies the extinction at last.
  bool densify = false;      // [Cabral11 §7.1], densification.h.
};

template <class Visitor>
void Describe(OpacityOptions& o, Visitor&& field) {
  field(o.cells,
        FieldInfo{"cells", "", "voxels along the box's longest side", Between(8, 512)});
  field(o.iterations,
        FieldInfo{"iterations", "", "passes over all mattes", Between(1, 100)});
  field(o.alpha_max,
        FieldInfo{
            "alpha-max", "", "mattes are clipped at this opacity", Between(0.5, 0.9999)});
  field(o.cutoff,
        FieldInfo{"cutoff",
                  "",
                  "transparency of a voxel above which it is emptied",
                  Between(0.5, 1)});
  field(
      o.kth_smallest,
      FieldInfo{
          "kth-smallest",
          "",
          "start from the k-th smallest opacity over the views; 3 forgives 2 bad mattes",
          Between(1, 8)});
  field(o.scale, FieldInfo{"scale", "", "multiplies the extinction", Between(0.01, 100)});
  field(o.densify,
        FieldInfo{"densify", "", "fill sparse neighbourhoods [Cabral11, 7.1]"});
}

struct OpacitySummary {
  int iterations = 0;
  double residual_rms =
      0.0;  // Of the mattes: volume's opacity - alpha, where alpha > 0.02.
  std::size_t occupied_voxels = 0;
  std::size_t densified_voxels = 0;
};

struct OpacityEstimate {
  ExtinctionGrid grid;
  OpacitySummary summary;
};

// Needs two views or more, all posed in one world. A volume that fits badly is an answer,
// not an error: read summary.residual_rms. The result does not depend on the threads.
// Throws OptionError, InputError (fewer than two views, mattes unusable, nothing left of
// the tree: the mattes contradict each other or the cameras), Cancelled.
OpacityEstimate EstimateOpacity(std::span<const MatteView> views,
                                const Eigen::AlignedBox3d& bounds_in_world,
                                const OpacityOptions& options = {},
                                const Progress& progress = {});

// Opacity 1 - exp(-optical depth) of the volume along the ray of each pixel of `camera`.
cv::Mat1f RenderOpacity(const ExtinctionGrid& grid, const Camera& camera);

}  // namespace relight
