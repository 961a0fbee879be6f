// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/vdb_file.h"

#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

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
openvdb::GridPtrVecPtr ReadGrids(const fs::path& file) {
  InitializeOnce();
  if (!fs::exists(file)) throw InputError(file.string() + ": not there");
  const std::string bytes = ReadText(file, std::size_t{1} << 33);
  if (HasId(bytes) && bytes[kVersionAt] == '8' &&
      bytes.compare(kIdAt, kIdLength, ContentId(bytes)) != 0) {
    throw InputError(file.string() +
                     ": is cut off or damaged; make it again with \"relight volume "
                     "--force\"");
  }
  try {
    std::istringstream in(bytes);
    in.exceptions(std::ios::eofbit | std::ios::failbit | std::ios::badbit);
    return openvdb::io::Stream(in, /*delayLoad=*/false).getGrids();
  } catch (
      const std::exception& error) {  // OpenVDB's and, for broken sizes, the library's
    // Of a damaged file it can quote a gigabyte
    throw InputError(file.string() + ": cannot be read as OpenVDB: " +
                     std::string(error.what()).substr(0, 100) +
                     "; make it again with \"relight volume --force\"");
  }
}

openvdb::FloatGrid::Ptr Named(const openvdb::GridPtrVec& grids,
                              const std::string& name,
                              const fs::path& file) {
  for (const auto& grid : grids) {
    if (grid->getName() != name) continue;
    if (auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return floats;
  }
  throw InputError(file.string() + ": has no grid of floats named \"" + name +
                   "\"; make it again with \"relight volume --force\"");
}

}  // namespace

void WriteVolume(const fs::path& file,
                 const ExtinctionGrid& grid,
                 const Metadata& metadata) {
  InitializeOnce();
  auto vdb = EmptyVdb(grid, kExtinction);
  vdb->insertMeta("unit", openvdb::StringMetadata("1/m"));
  auto accessor = vdb->getAccessor();
  for (const Eigen::Vector3i& at : FindOccupied(grid).cell) {
    accessor.setValue({at.x(), at.y(), at.z()},
                      grid.sigma_per_m[grid.Index(at.x(), at.y(), at.z())]);
  }
  WriteGrids(file, {vdb}, metadata);
}

ExtinctionGrid ReadVolume(const fs::path& file) {
  const auto vdb = Named(*ReadGrids(file), kExtinction, file);
  const openvdb::Vec3d size = vdb->voxelSize();
  const auto fail = [&](const std::string& what) {
    throw InputError(file.string() + ": " + what +
                     "; make it again with \"relight volume --force\"");
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
  ExtinctionGrid grid;
  grid.cells = {cells.x(), cells.y(), cells.z()};
  grid.cell_m = size.x();
  const openvdb::Vec3d center = vdb->indexToWorld(low);
  grid.origin_m =
      Eigen::Vector3d(center.x(), center.y(), center.z()).array() - grid.cell_m / 2;
  grid.sigma_per_m.assign(grid.Count(), 0.0f);
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
      grid.sigma_per_m[grid.Index(c.x(), c.y(), c.z())] = *value;
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
