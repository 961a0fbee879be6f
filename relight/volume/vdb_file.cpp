// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/vdb_file.h"

#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <sstream>
#include <utility>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr const char* kExtinction = "extinction";

void InitializeOnce() {
  static const bool done = (openvdb::initialize(), true);
  static_cast<void>(done);
}

openvdb::FloatGrid::Ptr EmptyVdb(const ExtinctionGrid& grid, const std::string& name) {
  auto vdb = openvdb::FloatGrid::create(0.0f);
  auto transform = openvdb::math::Transform::createLinearTransform(grid.cell_m);
  // OpenVDB's integer coordinates are voxel centres
  const Eigen::Vector3d center = grid.Center(0, 0, 0);
  transform->postTranslate({center.x(), center.y(), center.z()});
  vdb->setTransform(transform);
  vdb->setName(name);
  vdb->setGridClass(openvdb::GRID_FOG_VOLUME);
  vdb->insertMeta(
      "cells", openvdb::Vec3IMetadata({grid.cells.x(), grid.cells.y(), grid.cells.z()}));
  return vdb;
}

// OpenVDB puts a random id of 36 characters at a fixed place of the header: magic number
// (8 bytes), three version numbers (4 each), one flag. Ours is a hash of all other bytes,
// marked as version 8 of such ids (random ones are version 4).
constexpr std::size_t kIdAt = 8 + 3 * 4 + 1, kIdLength = 36, kVersionAt = kIdAt + 14;

bool HasId(const std::string& bytes) {
  return bytes.size() > kIdAt + kIdLength && bytes[kIdAt + 8] == '-';
}

std::string ContentId(std::string bytes) {
  bytes.replace(kIdAt, kIdLength, "00000000-0000-0000-0000-000000000000");
  std::string id = HashOfText(bytes);
  for (const std::size_t dash : {8u, 13u, 18u, 23u}) id.insert(dash, "-");
  id[kVersionAt - kIdAt] = '8';
  return id;
}

// In memory first: OpenVDB's own writer of files does not notice a disk that is full.
void WriteGrids(const fs::path& file,
                const openvdb::GridPtrVec& grids,
                const Metadata& metadata) {
  openvdb::MetaMap map;
  for (const auto& [key, value] : metadata) {
    map.insertMeta(key, openvdb::StringMetadata(value));
  }
  std::ostringstream stream;
  openvdb::io::Stream out(stream);
  out.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_ZIP);
  out.write(grids, map);
  std::string bytes = std::move(stream).str();
  Require(HasId(bytes), "OpenVDB's header is laid out as we know it");
  bytes.replace(kIdAt, kIdLength, ContentId(bytes));
  WriteTextWhole(file, bytes);
}

// OpenVDB takes a file that was cut off for one with fewer voxels, and believes any size
// in a damaged one. So our own are read only when their id is that of their bytes, and
// those of other programs from a stream that throws at its end.
constexpr const char* kMakeAgain = "make it again with \"relight volume --force\"";

openvdb::GridPtrVecPtr ReadGrids(const fs::path& file,
                                 const std::string& remedy = kMakeAgain,
                                 openvdb::MetaMap::Ptr* metadata = nullptr) {
  InitializeOnce();
  if (!fs::exists(file)) throw InputError(file.string() + ": not there");
  const std::string bytes = ReadText(file, std::size_t{1} << 33);
  if (HasId(bytes) && bytes[kVersionAt] == '8' &&
      bytes.compare(kIdAt, kIdLength, ContentId(bytes)) != 0) {
    throw InputError(file.string() + ": is cut off or damaged; " + remedy);
  }
  try {
    std::istringstream in(bytes);
    in.exceptions(std::ios::eofbit | std::ios::failbit | std::ios::badbit);
    openvdb::io::Stream stream(in, /*delayLoad=*/false);
    if (metadata != nullptr) *metadata = stream.getMetadata();
    return stream.getGrids();
  } catch (
      const std::exception& error) {  // OpenVDB's and, for broken sizes, the library's
    // Of a damaged file it can quote a gigabyte
    throw InputError(file.string() + ": cannot be read as OpenVDB: " +
                     std::string(error.what()).substr(0, 100) + "; " + remedy);
  }
}

openvdb::FloatGrid::Ptr Named(const openvdb::GridPtrVec& grids,
                              const std::string& name,
                              const fs::path& file) {
  for (const auto& grid : grids) {
    if (grid->getName() != name) continue;
    if (auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return floats;
  }
  throw InputError(file.string() + ": has no grid of floats named \"" + name + "\"; " +
                   kMakeAgain);
}

// The grid to import, as floats.
openvdb::FloatGrid::Ptr Foreign(const openvdb::GridPtrVec& grids,
                                const std::string& wanted,
                                const fs::path& file) {
  std::vector<openvdb::FloatGrid::Ptr> found;
  std::string names;
  for (const auto& grid : grids) {
    openvdb::FloatGrid::Ptr floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    if (const auto doubles = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid)) {
      floats = std::make_shared<openvdb::FloatGrid>(*doubles);
    }
    if (!floats) continue;
    found.push_back(floats);
    names += (names.empty() ? "" : ", ") + floats->getName();
  }
  if (found.empty()) {
    throw InputError(file.string() +
                     ": has no grid of floats; write the tree's density as one");
  }
  const auto named = [&](const std::string& name) -> openvdb::FloatGrid::Ptr {
    for (const auto& grid : found) {
      if (grid->getName() == name) return grid;
    }
    return nullptr;
  };
  openvdb::FloatGrid::Ptr grid = wanted.empty() ? named("extinction") : named(wanted);
  if (!grid && wanted.empty()) grid = named("density");
  if (!grid && wanted.empty() && found.size() == 1) grid = found.front();
  if (!grid) {
    throw InputError(file.string() +
                     (wanted.empty()
                          ? ": which of its grids is the tree's density, it does not say"
                          : ": has no grid of floats named \"" + wanted + "\"") +
                     "; give --grid one of " + names);
  }
  return grid;
}

}  // namespace

void WriteVolume(const fs::path& file,
                 const ExtinctionGrid& grid,
                 const Metadata& metadata) {
  InitializeOnce();
  auto vdb = EmptyVdb(grid, kExtinction);
  vdb->insertMeta("unit", openvdb::StringMetadata("1/m"));
  auto accessor = vdb->getAccessor();
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    if (grid.sigma_per_m[index] > 0) {
      accessor.setValue({x, y, z}, grid.sigma_per_m[index]);
    }
  });
  WriteGrids(file, {vdb}, metadata);
}

ExtinctionGrid ReadVolume(const fs::path& file) {
  const auto vdb = Named(*ReadGrids(file), kExtinction, file);
  const openvdb::Vec3d size = vdb->voxelSize();
  const auto fail = [&](const std::string& what) {
    throw InputError(file.string() + ": " + what + "; " + kMakeAgain);
  };
  // One step of each index is one edge along its own axis
  const openvdb::Vec3d corner = vdb->indexToWorld(openvdb::Coord(0, 0, 0));
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Coord next(0, 0, 0);
    openvdb::Vec3d edge(0, 0, 0);
    next[axis] = 1;
    edge[axis] = size.x();
    const openvdb::Vec3d off = vdb->indexToWorld(next) - corner - edge;
    if (!vdb->transform().isLinear() || !(size.x() > 0) || !(off.length() <= 1e-9)) {
      fail("the voxels are not cubes along the axes of the world");
    }
  }

  // The box: as written, else that of the active voxels
  openvdb::Coord low(0, 0, 0), cells;
  if (const auto meta = vdb->getMetadata<openvdb::Vec3IMetadata>("cells")) {
    cells = openvdb::Coord(meta->value());
  } else {
    const openvdb::CoordBBox box = vdb->evalActiveVoxelBoundingBox();
    low = box.min();
    cells = box.dim();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (cells[axis] < 1 || cells[axis] > 1024) fail("a side has not 1 to 1024 voxels");
  }
  const openvdb::Vec3d center = vdb->indexToWorld(low);
  ExtinctionGrid grid{
      NoBricks({cells.x(), cells.y(), cells.z()},
               Eigen::Vector3d(center.x(), center.y(), center.z()).array() - size.x() / 2,
               size.x()),
      {}};
  grid.sigma_per_m.reserve(vdb->tree().leafCount() * BrickVoxels::kPerBrick);
  for (auto value = vdb->cbeginValueOn(); value; ++value) {
    const openvdb::CoordBBox box = value.getBoundingBox();
    if (!std::isfinite(*value) || *value < 0)
      fail("an extinction is negative or not finite");
    for (const openvdb::Coord& at : box) {
      const openvdb::Coord c = at - low;
      if (c.x() < 0 || c.y() < 0 || c.z() < 0 || c.x() >= cells.x() ||
          c.y() >= cells.y() || c.z() >= cells.z()) {
        fail("a voxel lies outside the box");
      }
      grid.Set(c.x(), c.y(), c.z(), *value);
    }
  }
  return grid;
}

Metadata ReadMetadata(const fs::path& file) {
  openvdb::MetaMap::Ptr map;
  ReadGrids(file, kMakeAgain, &map);
  Metadata metadata;
  if (!map) return metadata;
  for (auto entry = map->beginMeta(); entry != map->endMeta(); ++entry) {
    metadata[entry->first] = entry->second->str();
  }
  return metadata;
}

ExtinctionGrid ImportVdb(const fs::path& file, const VdbImport& options) {
  constexpr int kMostCells = 512, kMostPoints = 8;
  const auto grids = ReadGrids(file, "write it again with the program it is from");
  const openvdb::FloatGrid::Ptr vdb = Foreign(*grids, options.grid, file);
  if (vdb->getGridClass() == openvdb::GRID_LEVEL_SET) {
    throw InputError(file.string() + ": \"" + vdb->getName() +
                     "\" is a surface (level set), not a density; convert it to a fog "
                     "volume");
  }
  if (vdb->background() != 0.0f) {
    throw InputError(file.string() + ": \"" + vdb->getName() +
                     "\" is not 0 outside the tree; write it with a background of 0");
  }
  for (auto value = vdb->cbeginValueOn(); value; ++value) {
    if (!std::isfinite(*value) || *value < 0) {
      throw InputError(file.string() + ": \"" + vdb->getName() +
                       "\" holds a density that is negative or not finite");
    }
  }
  const openvdb::CoordBBox box = vdb->evalActiveVoxelBoundingBox();
  if (box.empty()) {
    throw InputError(file.string() + ": \"" + vdb->getName() + "\" is empty");
  }

  // File's world to ENU metres and back
  const bool y_up = options.up == UpAxis::kY;
  const auto to_m = [&](const openvdb::Vec3d& p) {
    return Eigen::Vector3d(options.unit_m * (y_up
                                                 ? Eigen::Vector3d(p.x(), -p.z(), p.y())
                                                 : Eigen::Vector3d(p.x(), p.y(), p.z())));
  };
  const auto from_m = [&](const Eigen::Vector3d& m) {
    const Eigen::Vector3d p = m / options.unit_m;
    return y_up ? openvdb::Vec3d(p.x(), p.z(), -p.y())
                : openvdb::Vec3d(p.x(), p.y(), p.z());
  };
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const openvdb::Vec3d low = box.min().asVec3d(), high = box.max().asVec3d();
    bounds.extend(to_m(
        vdb->indexToWorld(openvdb::Vec3d(corner & 1 ? high.x() + 0.5 : low.x() - 0.5,
                                         corner & 2 ? high.y() + 0.5 : low.y() - 0.5,
                                         corner & 4 ? high.z() + 0.5 : low.z() - 0.5))));
  }
  const openvdb::Vec3d size = vdb->voxelSize();
  const double finest_m = options.unit_m * std::min({size.x(), size.y(), size.z()});
  const double longest_m = bounds.sizes().maxCoeff();
  if (!(finest_m > 0) || !(longest_m < 1e6)) {
    throw InputError(file.string() + ": its voxels have no size");
  }
  const double native = longest_m / finest_m;
  if (!options.cells && native > kMostCells + 0.5) {
    throw InputError(file.string() + ": has " + std::to_string(std::lround(native)) +
                     " voxels along its longest side, more than 512; say how many to "
                     "take with --cells N");
  }
  const int cells =
      options.cells.value_or(std::max(1, static_cast<int>(std::lround(native))));

  ExtinctionGrid grid = EmptyGrid(bounds, cells);
  const int points = std::clamp(
      static_cast<int>(std::ceil(grid.cell_m / finest_m - 1e-6)), 1, kMostPoints);
  const auto accessor = vdb->getConstAccessor();
  for (int z = 0; z < grid.cells.z(); ++z) {
    for (int y = 0; y < grid.cells.y(); ++y) {
      for (int x = 0; x < grid.cells.x(); ++x) {
        double sum = 0;
        for (int point = 0; point < points * points * points; ++point) {
          const Eigen::Vector3d within(
              point % points, point / points % points, point / (points * points));
          const Eigen::Vector3d at =
              grid.origin_m + grid.cell_m * (Eigen::Vector3d(x, y, z) +
                                             (within.array() + 0.5).matrix() / points);
          openvdb::Vec3d index = vdb->worldToIndex(from_m(at));
          // On a voxel's centre but for rounding: its own value
          for (int axis = 0; axis < 3; ++axis) {
            const double whole = std::round(index[axis]);
            if (std::abs(index[axis] - whole) < 1e-4) index[axis] = whole;
          }
          sum += openvdb::tools::BoxSampler::sample(accessor, index);
        }
        grid.Set(
            x,
            y,
            z,
            static_cast<float>(sum / (points * points * points) * options.scale_per_m));
      }
    }
  }
  return grid;
}

void WriteChannels(const fs::path& file,
                   const ExtinctionGrid& grid,
                   const std::string& name,
                   std::span<const std::vector<float>> values) {
  InitializeOnce();
  const OccupiedVoxels occupied = FindOccupied(grid);
  openvdb::GridPtrVec grids;
  for (std::size_t channel = 0; channel < values.size(); ++channel) {
    Require(values[channel].size() == occupied.cell.size(),
            "one value a non-empty voxel");
    auto vdb = EmptyVdb(grid, name + "_" + std::to_string(channel));
    auto accessor = vdb->getAccessor();
    for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      accessor.setValue({at.x(), at.y(), at.z()}, values[channel][v]);
    }
    grids.push_back(vdb);
  }
  WriteGrids(file, grids, {});
}

std::vector<std::vector<float>> ReadChannels(const fs::path& file,
                                             const ExtinctionGrid& grid,
                                             const std::string& name,
                                             int channels) {
  const openvdb::GridPtrVecPtr grids = ReadGrids(file);
  const OccupiedVoxels occupied = FindOccupied(grid);
  std::vector<std::vector<float>> values;
  for (int channel = 0; channel < channels; ++channel) {
    const auto vdb = Named(*grids, name + "_" + std::to_string(channel), file);
    auto accessor = vdb->getConstAccessor();
    std::vector<float>& row = values.emplace_back(occupied.cell.size());
    for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      row[v] = accessor.getValue({at.x(), at.y(), at.z()});
    }
  }
  return values;
}

}  // namespace relight
