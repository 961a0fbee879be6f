// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photographs to scene-linear Rec.709.
//
// Formats, told by the first bytes of a file and not by its name: JPEG, PNG and TIFF of 8
// or 16 bits, HEIC, RAW (developed with the camera's white balance, linear), and OpenEXR
// and float TIFF (scene-linear). The picture is turned upright as its EXIF orientation
// says. Grey becomes RGB.
//
// Colour: by the config that the environment variable OCIO names, with that config's
// rules for files; without one, as the embedded profile says (icc_profile.h), else sRGB
// for integer samples and linear Rec.709 for floats and RAW. The notes of the photo say
// what was taken when it is none of these, or when its profile cannot be read.
//
// Alpha: an EXR is premultiplied on disk, a PNG straight, a TIFF either and says so.
// Where a premultiplied alpha is 0 the colour is lost, and black here.

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/photo/photo.h"

#include <filesystem>
#include <string>

namespace relight {

// How a display-encoded picture came from linear light (relight/photo/color.h).
enum class Tone {
  kSrgb,    // By the sRGB curve alone: rendered, or developed without a look.
  kCamera,  // By a camera: the S-curve (P1) on top, which is undone, approximately.
};

struct ReadPhotoOptions {
  Tone tone = Tone::kSrgb;  // No effect on scene-linear files.
  std::string color_space =
      {};  // A name of the colour config; empty: what the file says.
};

template <class Visitor>
void Describe(ReadPhotoOptions& o, Visitor&& field) {
  field(o.tone, {"tone", "", "how the photo was made from linear light: srgb or camera"});
  field(o.color_space,
        {"color-space", "", "colour space of the photo; empty: as it says"});
}

// Throws InputError when the file is missing, no picture, cut off or damaged (never a
// picture with a part missing), CMYK, without R, G, B or Y, empty, or of more than 1e9
// pixels; OptionError for a colour space that does not exist; Cancelled. NaN and infinite
// pixels become black and are counted. The result does not depend on threads.
Photo ReadPhoto(const std::filesystem::path& path,
                const ReadPhotoOptions& options = {},
                const Progress& progress = {});

}  // namespace relight
