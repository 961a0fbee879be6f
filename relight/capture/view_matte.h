// SPDX-License-Identifier: Apache-2.0
#pragma once

// Mattes and foreground colours of a capture's views. A view's matte is the first of:
// mattes/VIEW that the user put there or edited, the photo's own alpha, one made from
// trimaps/VIEW, one made with scribbles/VIEW (a picture of strokes), one made against the
// sky alone. What is made is kept in mattes/, and what is to be known of it (made from
// what, how sure) in cache/mattes/VIEW.json. The first view with scribbles teaches the
// colours of tree and background to the views that have neither trimap nor scribbles.

#include "relight/base/progress.h"
#include "relight/capture/capture.h"
#include "relight/capture/photo_matte.h"
#include "relight/capture/stage_records.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

struct CutOut {
  cv::Mat3f
      foreground;  // Colours of the tree, linear, straight; defined where alpha = 0 too.
  cv::Mat1f alpha;
  std::string matte_source;  // In words: "mattes/view_00.png", "the photo's alpha".
};

// A matte file for a photo of `size`. Throws InputError when its size is another.
cv::Mat1f ReadMatteFor(const std::filesystem::path& file,
                       cv::Size size,
                       const std::filesystem::path& photo);

// What is known of a matte in mattes/.
struct MatteReport {
  std::string view, file;   // File below the capture; empty: the photo's alpha.
  std::string made_from;    // "" for one that relight did not make.
  double confidence = 1.0;  // As PhotoMatte has them.
  std::vector<std::string> doubts;
};

class CaptureMattes {
 public:
  // Keeps references.
  CaptureMattes(const Capture& capture,
                StageRecords& records,
                const CaptureOptions& options);

  // Whether mattes/VIEW has to be made.
  bool IsStale(const ViewEntry& view, bool force) const;

  // What it is to be made from, as far as it is in the folder.
  MatteGuide GuideOf(const ViewEntry& view) const;

  // Makes mattes/VIEW.png where it has to be, with the foreground colours in
  // cache/foreground/VIEW.exr. True when it did.
  bool Make(const ViewEntry& view, bool force, const Progress& progress);

  MatteReport ReportOf(const ViewEntry& view) const;

 private:
  std::string KeyOf(const ViewEntry& view) const;
  const ViewEntry* Teacher(const ViewEntry& view) const;
  const ColorModels* ModelsFor(const ViewEntry& view);

  const Capture& capture_;
  StageRecords& records_;
  const CaptureOptions& options_;
  std::optional<ColorModels> models_;  // Of the first view with scribbles, once needed.
};

// The matte of a view as the volume needs it. Throws InputError when there is none.
cv::Mat1f MatteOf(const Capture& capture, const ViewEntry& view);

// Matte and colours of a view; colours are taken from the cache or made and kept there.
CutOut CutOutOf(const Capture& capture,
                const ViewEntry& view,
                const Photo& photo,
                StageRecords& records,
                const ReadPhotoOptions& options,
                const Progress& progress);

}  // namespace relight
