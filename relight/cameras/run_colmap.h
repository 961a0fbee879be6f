// SPDX-License-Identifier: Apache-2.0
#pragma once

// COLMAP, found at run time and started without a shell: photos in, cameras out. Versions
// 3.8 and later, on the processor alone. Two runs on the same photos differ by some
// hundredths of a pixel, for COLMAP's threads meet chance.

#include "relight/base/field_text.h"
#include "relight/base/progress.h"
#include "relight/cameras/calibrated_scene.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

enum class Matching {
  kAuto,        // Exhaustive up to 40 photos.
  kExhaustive,  // Each photo with each.
  kSequential,  // Each with the ten after it, as one walks around a tree.
};
inline constexpr EnumWord<Matching> kMatchingWords[] = {
    {"auto", Matching::kAuto},
    {"exhaustive", Matching::kExhaustive},
    {"sequential", Matching::kSequential}};
inline std::span<const EnumWord<Matching>> EnumWords(Matching) { return kMatchingWords; }

struct ColmapOptions {
  Matching matching = Matching::kAuto;
  int longest_px = 2000;  // Photos are searched for features at this size.
  int features = 4000;    // At most, of a photo.
};

template <class Visitor>
void Describe(ColmapOptions& o, Visitor&& field) {
  field(o.matching,
        FieldInfo{"matching",
                  "",
                  "which photos COLMAP compares: auto, exhaustive or sequential"});
  field(o.longest_px,
        FieldInfo{"longest", "px", "size at which COLMAP looks at photos", AtLeast(400)});
  field(o.features,
        FieldInfo{"features", "", "points that COLMAP keeps of a photo", AtLeast(500)});
}

// Photos with one lens: of one size, at one focal length.
struct ColmapGroup {
  std::vector<std::string> files;  // Names below ColmapJob::photos.
  PhotoSize size;
  std::optional<double> focal_px;  // As EXIF has it.
};

struct ColmapJob {
  std::filesystem::path photos;                // Upright pictures.
  std::filesystem::path work;                  // For COLMAP's own files; emptied first.
  std::optional<std::filesystem::path> masks;  // FILE.png for FILE; 0: not looked at.
  std::vector<ColmapGroup> groups;
};

struct ColmapSummary {
  CalibratedScene scene;             // The largest model.
  std::vector<std::string> missing;  // Views that are not in it.
  int models = 0;                    // Parts that did not fit together.
  bool exhaustive = false;
  std::vector<std::string> notes;
};

// The program; nothing when there is none on PATH.
std::optional<std::filesystem::path> FindColmap();

bool IsExhaustive(const ColmapOptions& options, std::size_t photos);

// About how long RunColmap takes on two cores, for what the user is told before.
double ColmapSeconds(const ColmapJob& job, const ColmapOptions& options);

// When the focal length that comes out is more than a tenth off EXIF's (a flat scene
// leaves it open), it is solved once more with EXIF's and said. Throws InputError with
// what COLMAP said and what helps: not installed, nothing registered, killed; Cancelled.
ColmapSummary RunColmap(const ColmapJob& job,
                        const ColmapOptions& options = {},
                        const Progress& progress = {});

}  // namespace relight
