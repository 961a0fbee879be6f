// SPDX-License-Identifier: Apache-2.0
#pragma once

// Trimap from a mask that somebody cut by hand: its edges too hard, its holes filled.
//
// Unknown becomes what lies within `band` of the mask's edge or is neither 0 nor 1 in it,
// and what the mask calls tree though its colour may be one of those outside, with the
// band around it: with p(c | inside), p(c | outside) the histograms of the pixels away
// from the edge, where
//
//   p(c | outside) > s p(c | inside),   s = 0.1                                (M7)
//
// s is small, for inside a crown cut so the holes' colours are counted as the tree's.

#include "relight/base/field.h"
#include "relight/base/progress.h"

#include <opencv2/core.hpp>

namespace relight {

struct MaskTrimapOptions {
  double band_px = 0.0;  // 0: one part in 150 of the shorter side, at least 3 pixels.
};

template <class Visitor>
void Describe(MaskTrimapOptions& o, Visitor&& field) {
  field(o.band_px,
        FieldInfo{"refine-band",
                  "px",
                  "how far a hand-cut edge may be off; 0: as the photo's size suggests",
                  AtLeast(0)});
}

// `display`: the photo, display values in [0, 1]; `mask` in [0, 1]. Labels of trimap.h.
// Throws InputError when the sizes differ or the mask has no inside or no outside,
// Cancelled. The result does not depend on the threads.
cv::Mat1b TrimapFromMask(const cv::Mat3f& display,
                         const cv::Mat1f& mask,
                         const MaskTrimapOptions& options = {},
                         const Progress& progress = {});

}  // namespace relight
