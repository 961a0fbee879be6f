// SPDX-License-Identifier: Apache-2.0
#pragma once

// The matte of a photo from a trimap, in closed form.
//
//   [Levin08] docs/bibliography.md#levin08
//
// Colours of foreground and background each lie on a line in every 3 x 3 window; then
// alpha is affine in colour there, and minimises
//
//   alpha^T L alpha + lambda (alpha - alpha*)^T D (alpha - alpha*)        (M1)
//
// with D 1 on known pixels, alpha* their value (on unknown ones a guess from colours,
// color_prior.h, with a small weight: [Levin08] has none there), and L the matting
// Laplacian, matting_laplacian.h.
//
// The system holds the unknown pixels and the known ones within two pixels of them;
// further known pixels keep alpha*, whose pull reaches no further.

#include "matting/color_prior.h"
#include "matting/stencil_matrix.h"
#include "relight/base/field.h"
#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace relight {

struct MattingOptions {
  double epsilon = 1e-7;        // eps of (M2), for colours in [0, 1].
  double lambda = 100.0;        // lambda of (M1).
  double prior_weight = 0.025;  // Weight of the colour prior in D; 0: [Levin08] alone.
  double brightest = 1.0;       // Of the colour prior (M11); trees: 4.
  double relative_residual = 1e-8;
  int most_iterations = 500;
};

template <class Visitor>
void Describe(MattingOptions& o, Visitor&& field) {
  field(o.epsilon, FieldInfo{"matting-epsilon", "", "eps of [Levin08]", Above(0)});
  field(o.lambda, FieldInfo{"matting-lambda", "", "weight of the trimap", Above(0)});
  field(o.prior_weight,
        FieldInfo{"prior-weight", "", "weight of the colour prior", AtLeast(0)});
  field(o.relative_residual,
        FieldInfo{"matting-residual",
                  "",
                  "relative residual that is enough",
                  Between(1e-12, 0.1)});
  field(o.most_iterations,
        FieldInfo{"matting-iterations", "", "iterations at most", AtLeast(1)});
}

struct MatteSummary {
  std::int64_t unknown_pixels = 0;
  int iterations = 0;  // At the photo's own size.
  double relative_residual = 0.0;
};

struct MatteEstimate {
  cv::Mat1f alpha;  // [0, 1]
  MatteSummary summary;
};

// `linear`: the photo in linear light, where a half-covered pixel is half of each colour
// (docs/decisions/0002). `trimap`: trimap.h. Known pixels come back exactly as the trimap
// has them. Memory: about 130 bytes a pixel of the system, and 13 a pixel of the photo.
// Throws InputError (sizes differ, no sure foreground or background, pixels that are no
// numbers), OptionError, Cancelled. The result does not depend on the threads.
MatteEstimate EstimateMatte(const cv::Mat3f& linear,
                            const cv::Mat1b& trimap,
                            const MattingOptions& options = {},
                            const Progress& progress = {});

// The system that EstimateMatte solves, for those who solve it another way. `prior`: with
// empty images there is none. The image is at least 3 x 3.
struct MattingSystem {
  std::unique_ptr<PixelRuns> pixels;
  StencilMatrix matrix;  // L + lambda D of (M1), over pixels.
  std::vector<float> right_side;
};

MattingSystem MakeMattingSystem(const cv::Mat3f& image,
                                const cv::Mat1b& trimap,
                                const ColorPrior& prior = {},
                                const MattingOptions& options = {},
                                const Progress& progress = {});

}  // namespace relight
