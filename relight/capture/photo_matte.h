// SPDX-License-Identifier: Apache-2.0
#pragma once

// The matte of one photo, from whatever is known of it.

#include "matting/automatic_trimap.h"
#include "matting/closed_form_matting.h"
#include "matting/mask_trimap.h"
#include "matting/screen_trimap.h"
#include "relight/base/field.h"
#include "relight/base/field_text.h"
#include "relight/base/progress.h"
#include "relight/photo/photo.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

enum class MatteMethod {
  kClosedForm,  // [Levin08] with a colour prior (docs/decisions/0002).
  kRuzon2000,   // Clusters of colour, pixel by pixel [Reche04 §4].
};
inline constexpr EnumWord<MatteMethod> kMatteMethodWords[] = {
    {"closed-form", MatteMethod::kClosedForm}, {"ruzon2000", MatteMethod::kRuzon2000}};
inline std::span<const EnumWord<MatteMethod>> EnumWords(MatteMethod) {
  return kMatteMethodWords;
}

enum class MattePrior { kSampling, kNone };
inline constexpr EnumWord<MattePrior> kMattePriorWords[] = {
    {"sampling", MattePrior::kSampling}, {"none", MattePrior::kNone}};
inline std::span<const EnumWord<MattePrior>> EnumWords(MattePrior) {
  return kMattePriorWords;
}

enum class MatteColor { kLinear, kDisplay };
inline constexpr EnumWord<MatteColor> kMatteColorWords[] = {
    {"linear", MatteColor::kLinear}, {"display", MatteColor::kDisplay}};
inline std::span<const EnumWord<MatteColor>> EnumWords(MatteColor) {
  return kMatteColorWords;
}

struct MatteOptions {
  MatteMethod method = MatteMethod::kClosedForm;
  MattePrior prior = MattePrior::kSampling;
  MatteColor color = MatteColor::kLinear;
  double leaf_brightness = 0.0;  // F of (M11), color_prior.h.
  MattingOptions closed_form;
  AutomaticTrimapOptions automatic;
  MaskTrimapOptions mask;
};

template <class Visitor>
void Describe(MatteOptions& o, Visitor&& field) {
  field(o.method,
        FieldInfo{"matte-method", "", "how mattes are made: closed-form or ruzon2000"});
  field(
      o.prior,
      FieldInfo{"prior", "", "guess from colours in the closed form: sampling or none"});
  field(
      o.color,
      FieldInfo{"matting-color", "", "colours the closed form takes: linear or display"});
  field(o.leaf_brightness,
        FieldInfo{"leaf-brightness",
                  "",
                  "how many times brighter than leaves that are surely tree one may be; "
                  "0: 4 where the tree was found before the sky, else 1",
                  Between(0, 16)});
  Describe(o.closed_form, field);
  Describe(o.automatic, field);
  Describe(o.mask, field);
}

// What a user gives for a photo; at most one of trimap, scribbles alone, refine, screen.
// With nothing given the trimap is found, for a tree against sky.
struct MatteGuide {
  std::optional<std::filesystem::path> trimap;   // 0, 128, 255, or alpha.
  std::vector<std::filesystem::path> scribbles;  // A picture of strokes, or two masks.
  bool automatic = false;                       // What is not scribbled on is found, too.
  std::optional<std::filesystem::path> refine;  // A mask cut by hand.
  std::string screen;                           // As FindScreen takes it; empty: none.
};

// Throws OptionError when it says one thing in two ways.
void RequireOneGuide(const MatteGuide& guide);

struct PhotoMatte {
  cv::Mat1f alpha;
  std::string made_from;    // In words: "trimap.png", "the sky behind the tree".
  double confidence = 1.0;  // [0, 1], of a trimap that was found; below 0.5 look at it.
  std::vector<std::string> doubts;  // What is unsure, and what helps.
  std::optional<Screen> screen;     // Its light is to be taken off the colours.
  cv::Mat1b trimap;
};

// `file`: the photo's, for messages. `like`: colour models of another photo of the
// capture, or null. Throws InputError that names the file (sizes differ, pixels that were
// NaN or infinite, nothing known of tree or background), OptionError, Cancelled.
PhotoMatte EstimatePhotoMatte(const Photo& photo,
                              const std::filesystem::path& file,
                              const MatteGuide& guide,
                              const MatteOptions& options,
                              const ColorModels* like = nullptr,
                              const Progress& progress = {});

// Strokes of a picture, or of two masks. Throws InputError that names the file.
cv::Mat1b ReadStrokes(const std::vector<std::filesystem::path>& files, cv::Size size);

// Foreground colours of `photo` under `alpha` (a photo with an alpha of its own has
// them), without the screen's light where there was one.
cv::Mat3f ForegroundOf(const Photo& photo,
                       const cv::Mat1f& alpha,
                       const std::optional<Screen>& screen,
                       const Progress& progress);

}  // namespace relight
