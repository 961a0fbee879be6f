// SPDX-License-Identifier: Apache-2.0
#pragma once

// Matte and foreground colours of one view, from the first of: a matte that the user
// names, the photo's own alpha, mattes/VIEW, a trimap in trimaps/VIEW (closed-form
// matting; kept in mattes/). A matte that somebody edited since relight made it is used
// as it is.

#include "relight/base/progress.h"
#include "relight/capture/capture.h"
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

// Foreground colours of `photo` under `alpha` (a photo with an alpha of its own has
// them).
cv::Mat3f ForegroundOf(const Photo& photo,
                       const cv::Mat1f& alpha,
                       const Progress& progress);

// A matte from a trimap file. Throws InputError when the sizes differ.
cv::Mat1f MatteFromTrimap(const Photo& photo,
                          const std::filesystem::path& trimap,
                          const Progress& progress);

// A matte file for a photo of `size`. Throws InputError when its size is another.
cv::Mat1f ReadMatteFor(const std::filesystem::path& file,
                       cv::Size size,
                       const std::filesystem::path& photo);

enum class MatteNeed { kNone, kMatte, kMissing };

// Whether mattes/VIEW has to be made, is there, or cannot be made (no trimap, no alpha).
MatteNeed NeedOf(const Capture& capture,
                 const ViewEntry& view,
                 const StageRecords& records,
                 const ReadPhotoOptions& options,
                 bool force);

// Makes mattes/VIEW.png from its trimap where that is not up to date, with the foreground
// colours in cache/foreground/VIEW.exr. True when it did.
bool MakeMatte(const Capture& capture,
               const ViewEntry& view,
               StageRecords& records,
               const ReadPhotoOptions& options,
               bool force,
               const Progress& progress);

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
