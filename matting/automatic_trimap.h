// SPDX-License-Identifier: Apache-2.0
#pragma once

// The trimap of a tree against sky, without a stroke on an ordinary photo.
//
//   [Rother04] docs/bibliography.md#rother04 GrabCut: colour mixtures and a graph cut
//
// Of a pixel's distance d to the colour of the sky behind it, (M9) of sky_behind.h, and
// those of its eight neighbours,
//
//   background: d < t sigma of all,   foreground: d > f D, and d > 0.6 D of all   (M10)
//
// with sigma the sky's own spread and D the tree's contrast; all else is unknown. Below
// the horizon, the lowest row that shows sky, there is ground for background, of any
// texture and with the tree's shadow on it: the tree is what GrabCut separates there and
// the leaves and twigs that no shade of the ground can be, as far as they are held from
// above.

#include "relight/base/field.h"
#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace relight {

struct AutomaticTrimapOptions {
  double sky_tolerance = 3.0;        // t of (M10), in standard deviations.
  double foreground_contrast = 0.6;  // f of (M10).
  double ground_band =
      0.007;  // Unknown to each side of the cut; of the picture's height.
};

template <class Visitor>
void Describe(AutomaticTrimapOptions& o, Visitor&& field) {
  field(o.sky_tolerance,
        FieldInfo{"trimap-sky",
                  "",
                  "spread of the sky's colours that is still sky, in standard deviations",
                  Above(0)});
  field(o.foreground_contrast,
        FieldInfo{"trimap-solid",
                  "",
                  "share of the tree's contrast to the sky that is surely tree",
                  Between(0.5, 1)});
  field(o.ground_band,
        FieldInfo{"trimap-band",
                  "",
                  "unknown band between tree and ground, of the picture's height",
                  Between(0, 0.1)});
}

// Colour mixtures, 5 Gaussians each, of what is tree and what is not [Rother04]: learned
// on one photo and good for the others of a capture.
struct ColorModels {
  cv::Mat foreground, background;  // 1 x 65 doubles as cv::grabCut has them, or empty.
  bool Empty() const { return foreground.empty() || background.empty(); }
};

struct AutomaticTrimap {
  cv::Mat1b trimap;                 // trimap.h; all unknown where nothing could be told.
  double confidence = 0.0;          // [0, 1]; below 0.5 the photo wants a stroke.
  std::vector<std::string> doubts;  // What is unsure and what helps, for the user.
  ColorModels models;               // Empty without both foreground and background.
};

// `display`: display-encoded RGB. `strokes`: empty, or labels (trimap.h) at the photo's
// size: foreground and background hold, and both together teach the colours; unknown is
// not marked.
// `like`: models of another photo of the capture that had strokes, or null; own strokes
// count more. Segments at a reduced size, decides (M10) at the photo's own.
// Throws InputError (empty picture, strokes of another size or with other labels),
// OptionError, Cancelled. The result does not depend on the threads.
AutomaticTrimap EstimateTrimap(const cv::Mat3f& display,
                               const cv::Mat1b& strokes = {},
                               const ColorModels* like = nullptr,
                               const AutomaticTrimapOptions& options = {},
                               const Progress& progress = {});

// Whether what a trimap calls background is sky for the most part, and sky is along most
// of the upper border. Throws Cancelled.
bool IsBeforeSky(const cv::Mat3f& display,
                 const cv::Mat1b& trimap,
                 const Progress& progress = {});

}  // namespace relight
