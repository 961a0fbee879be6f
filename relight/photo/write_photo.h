// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scene-linear photos to files, by extension:
//
//   .exr         half, linear, premultiplied as OpenEXR wants it
//   .png .tif    16 bit, sRGB, straight alpha (.tif flagged as unassociated)
//   .jpg         8 bit, sRGB, no alpha
//
// Every file carries its provenance (Software and ImageDescription), by which
// ReadPhotoFacts knows it again as a result of relight. Written whole or not at all.

#include "relight/base/field.h"
#include "relight/photo/photo.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace relight {

struct Provenance {
  std::string software;  // "relight 0.1.0": begins with "relight ".
  std::string json;      // Options, versions, sun, hashes; at most 30000 bytes.
};

struct WritePhotoOptions {
  int quality = 95;  // Of a JPEG.
};

template <class Visitor>
void Describe(WritePhotoOptions& o, Visitor&& field) {
  field(o.quality, {"quality", "", "quality of a JPEG", Between(1, 100)});
}

struct WriteSummary {
  // Pixels with a channel above what the format can hold: 1 in a display format, 65504 in
  // an EXR. They are cut there.
  std::int64_t clipped_pixels = 0;
  // Pixels with a channel below 0, a colour outside sRGB; they are cut in display
  // formats.
  std::int64_t negative_pixels = 0;
  std::int64_t non_finite_pixels = 0;  // NaN or infinite; written black.
};

// Fully transparent pixels count in none of these. Throws OptionError for an unknown
// extension or an alpha for .jpg, InputError when the file cannot be written whole.
// `confidence`, of the photo's size where it is given, is one more channel of an .exr, of
// that name; the other formats have no place for it.
WriteSummary WritePhoto(const std::filesystem::path& path,
                        const Photo& photo,
                        const Provenance& provenance,
                        const WritePhotoOptions& options = {},
                        const cv::Mat1f& confidence = {});

// ".exr, .jpg, …", for messages and help.
std::vector<std::string> WritableExtensions();

}  // namespace relight
