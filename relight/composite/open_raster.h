// SPDX-License-Identifier: Apache-2.0
#pragma once

// A montage as an OpenRaster file (.ora, baseline 0.0.3), which GIMP, Krita and MyPaint
// open with its layers: a zip archive of
//
//   mimetype                   first, not compressed: "image/openraster"
//   stack.xml                  the layers, the top one first
//   data/tree.png              RGBA, straight       svg:src-over
//   data/shadow.png            RGB                  svg:multiply, when there is a shadow
//   data/backdrop.png          RGB                  svg:src-over, when there is a
//   backdrop mergedimage.png            all layers flat (montage.h)
//   Thumbnails/thumbnail.png   the same, at most 256 pixels wide and high
//
// Pictures are 8-bit sRGB, and carry the provenance as PNG text.

#include "relight/composite/montage.h"
#include "relight/photo/write_photo.h"

#include <filesystem>

namespace relight {

// Written whole or not at all; the same montage gives the same bytes. The counts are
// those of the tree. Throws InputError when the file cannot be written.
WriteSummary WriteOpenRaster(const std::filesystem::path& path,
                             const Montage& montage,
                             const Provenance& provenance);

}  // namespace relight
