// SPDX-License-Identifier: Apache-2.0
#pragma once

// A view ready to be relit to any hour: its pixels, its tree, its camera. Makes the
// stages that are not up to date.

#include "relight/base/progress.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/capture/view_plan.h"
#include "relight/photo/photo.h"
#include "relight/sky/sky_turbidity.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// Called at the start of each stage; the Progress it answers is that stage's.
using StageStart = std::function<Progress(const PlannedStage& stage)>;

struct PreparedView {
  Photo photo;
  CutOut cut;
  Camera camera;  // Of the photo's size.
  Tree tree;
  std::string ground_fault;      // Why no shadow can be cast on the ground; mostly empty.
  std::size_t volume_views = 1;  // That the volume is made from.
  // What the sky of the photos says of the air; unset when nobody asks for it.
  std::optional<TurbidityEstimate> air;
  std::vector<std::string> notes;
  Progress progress;  // What is left of the stage after the volume's light.
};

// The stage that follows the volume's light is begun, and up to 0.3 of it done. A picture
// in memory that is the view's own photo, but for its rounding to 8 bits or another
// decoder, stands for it, with the colours that are kept in the capture. Throws
// InputError, Cancelled.
PreparedView PrepareView(const ViewPlan& plan, const StageStart& start = {});

// The same view at a size of at most `longest_px`, by means over areas: for a quick look.
// Colours are weighted by the alpha they belong to. A view that is no larger is answered
// as it is.
PreparedView Smaller(const PreparedView& view, int longest_px);

}  // namespace relight
