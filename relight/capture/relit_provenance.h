// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a result says of itself: program, options, both lights, hashes of the inputs.

#include "relight/capture/light_options.h"
#include "relight/capture/view_plan.h"
#include "relight/photo/write_photo.h"

#include <string>

namespace relight {

// What was done to the relit tree.
struct PictureKind {
  bool whole = false;
  bool keep_shadow = false;
  std::string over;  // Name of the backdrop; empty: none.
  double exposure_ev = 0.0;
  RunLight light = {};  // The skies, with the turbidity that was used.
};

struct InputHashes {
  std::string photo, volume;  // No volume file: empty.
};

// Reads the photo and the volume, once for all results of a run.
InputHashes HashInputs(const ViewPlan& view);

Provenance ProvenanceOf(const ViewPlan& view,
                        const InputHashes& hashes,
                        const HourLight& target,
                        const PictureKind& kind);

}  // namespace relight
