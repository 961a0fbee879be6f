// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a HEIC file says besides its pixels: EXIF, and the colours that its numbers mean.
// Private to this folder.
//
//   ISO/IEC 14496-12 (boxes), 23008-12 (items and their properties)
//
// OpenImageIO 2.4 takes EXIF for granted to begin 10 bytes into its item, as phones write
// it, where the item's first 4 bytes say where; and it passes colour profiles over.

#include <filesystem>
#include <string>

namespace relight {

struct HeifMetadata {
  std::string exif;   // A TIFF; empty without one.
  std::string icc;    // Profile of the primary picture; empty without one.
  int primaries = 0;  // Of ITU-T H.273, of the primary picture; 0: not said.
};

// A file that is cut off, damaged or no HEIC gives what could be read of it.
HeifMetadata ReadHeifMetadata(const std::filesystem::path& path);

}  // namespace relight
