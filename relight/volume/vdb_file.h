// SPDX-License-Identifier: Apache-2.0
#pragma once

// Grids on disk as OpenVDB, so that Blender, Houdini and others open them. The same grids
// give the same bytes (OpenVDB's random file id is replaced by a hash of the content).

#include "relight/volume/extinction_grid.h"

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

using Metadata = std::map<std::string, std::string>;

// One FloatGrid "extinction" [1/m], background 0, voxel size cell_m, with the number of
// cells and `metadata` as strings. Throws InputError when it cannot be written.
void WriteVolume(const std::filesystem::path& file,
                 const ExtinctionGrid& grid,
                 const Metadata& metadata = {});

// Throws InputError naming the file and the remedy: not VDB, cut off or damaged, no
// "extinction" of floats, voxels not cubes along the axes of the world, more than 1024
// along a side, a value negative or not finite. Damage is found in the files written
// here, by their hash, and a missing end in those of other programs.
ExtinctionGrid ReadVolume(const std::filesystem::path& file);

// What the file's writer noted besides; empty when nothing.
Metadata ReadMetadata(const std::filesystem::path& file);

// Which way is up in the world of another program's file.
enum class UpAxis { kZ, kY };

struct VdbImport {
  std::string grid = {};     // Empty: "extinction", else "density", else the only one.
  double scale_per_m = 1.0;  // Extinction [1/m] of a density of 1.
  double unit_m = 1.0;       // Metres of a unit of the file's world.
  UpAxis up = UpAxis::kZ;    // kY: x stays east, y is up, -z is north.
  std::optional<int> cells = {};  // Along the longest side; left out: as in the file.
};

// A tree from another program: any grid of floats or doubles, however its voxels lie, on
// cubes along the axes of the world. Where voxels are the same cubes, values stay as they
// are; else each is a mean over points not farther apart than the file's own voxels.
// Negative densities are an error, as are values that are not finite, a grid without
// any, and more than 512 voxels along a side of the file when `cells` is left out. Throws
// InputError naming the file and the remedy, with the names of its grids.
ExtinctionGrid ImportVdb(const std::filesystem::path& file, const VdbImport& options);

// Values of the non-empty voxels only, one FloatGrid a channel named NAME_0, NAME_1, …
// values[channel][voxel], voxels in the order of FindOccupied(grid).
void WriteChannels(const std::filesystem::path& file,
                   const ExtinctionGrid& grid,
                   const std::string& name,
                   std::span<const std::vector<float>> values);
std::vector<std::vector<float>> ReadChannels(const std::filesystem::path& file,
                                             const ExtinctionGrid& grid,
                                             const std::string& name,
                                             int channels);

}  // namespace relight
