// SPDX-License-Identifier: Apache-2.0
#pragma once

// Extinction of a tree from its alpha mattes: by regularised least squares
// (tomography.h), or by the papers' projections (projected_opacity.h); and what a volume
// shows to a camera.

#include "relight/base/field.h"
#include "relight/base/field_text.h"
#include "relight/base/progress.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"
#include "relight/volume/tomography.h"

#include <optional>
#include <span>
#include <vector>

namespace relight {

enum class VolumeMethod { kTomography, kReche2004 };
inline constexpr EnumWord<VolumeMethod> kVolumeMethodWords[] = {
    {"tomography", VolumeMethod::kTomography}, {"reche2004", VolumeMethod::kReche2004}};
inline std::span<const EnumWord<VolumeMethod>> EnumWords(VolumeMethod) {
  return kVolumeMethodWords;
}

struct OpacityOptions {
  VolumeMethod method = VolumeMethod::kTomography;
  int cells = 100;                       // Along the box's longest side.
  std::optional<int> iterations = {};    // Left out: 16, or 8 of reche2004.
  double smoothness = 1.0;               // Tomography only.
  double leaf_spread = 0.0;              // Tomography only: c of (V3).
  double alpha_max = 0.995;              // Reche2004 only, as is
  double cutoff = 0.94;                  // this (projected_opacity.h).
  std::optional<int> kth_smallest = {};  // k - 1 bad mattes may call tree empty;
                                         // unset: as AgreementOf chooses.
  double scale = 1.0;    // s of [Cabral11 §7.1]: multiplies the extinction.
  bool densify = false;  // [Cabral11 §7.1], densification.h.
};

template <class Visitor>
void Describe(OpacityOptions& o, Visitor&& field) {
  field(o.method,
        FieldInfo{"volume-method",
                  "",
                  "how the volume is found: tomography, or reche2004 as in the papers"});
  field(o.cells,
        FieldInfo{"cells", "", "voxels along the box's longest side", Between(8, 512)});
  field(o.iterations,
        FieldInfo{"iterations",
                  "",
                  "passes over all mattes: 16, or 8 of reche2004",
                  Between(1, 1000)});
  field(o.smoothness,
        FieldInfo{"smoothness",
                  "",
                  "weight of the prior, over that which the mattes' noise asks for; "
                  "tomography",
                  Between(0, 100)});
  field(o.leaf_spread,
        FieldInfo{"leaf-spread",
                  "",
                  "c: mattes weigh 1 / (alpha (1 - alpha) + c), for half-open crowns "
                  "spread most; 0: all alike; tomography",
                  Between(0, 10)});
  field(o.alpha_max,
        FieldInfo{"alpha-max",
                  "",
                  "mattes are clipped at this opacity; reche2004",
                  Between(0.5, 0.9999)});
  field(o.cutoff,
        FieldInfo{"cutoff",
                  "",
                  "transparency of a voxel above which it is emptied; reche2004",
                  Between(0.5, 1)});
  field(o.kth_smallest,
        FieldInfo{"kth-smallest",
                  "",
                  "start from the k-th smallest opacity over the views; 3 forgives 2 bad "
                  "mattes. Left out: 1, or 3 where bad mattes take away much of the tree",
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
  // Of tomography:
  std::size_t hidden_voxels = 0;  // That no photo sees, filled from their surroundings.
  std::vector<ViewWeight> views = {};  // How each matte fits the others, and counts.
  std::vector<double> objective = {};  // After each pass.
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

// Root mean square of the volume's opacity less the matte's, both averaged over squares
// of `footprint_m` at the tree, within alpha > 0.02 grown by 3 pixels: with a view that
// the volume was not made from, how well it tells what it has not seen.
double MatteRmse(const ExtinctionGrid& grid,
                 const MatteView& view,
                 double footprint_m = 0.10);

}  // namespace relight
