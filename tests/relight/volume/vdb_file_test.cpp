// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/vdb_file.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

namespace relight {
namespace {

ExtinctionGrid TestGrid() {
  ExtinctionGrid grid = tests::RandomCanopy({19, 11, 23}, 0.093, 7.0, /*seed=*/51);
  grid.origin_m = {-4.2857, 1.5, -0.15};
  grid.Set(3, 0, 0, 1e-38f);  // As small as a float is
  grid.Set(4, 0, 0, 99.03f);
  return grid;
}

class VdbFile : public testing::Test {
 protected:
  // What the InputError of reading says; "" when it was read.
  static std::string Complaint(const std::filesystem::path& file) {
    try {
      ReadVolume(file);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }
  std::filesystem::path File(const std::string& bytes) const {
    std::ofstream(folder_ / "other.vdb", std::ios::binary) << bytes;
    return folder_ / "other.vdb";
  }
  tests::ScratchFolder folder_;
};

TEST_F(VdbFile, WhatIsWrittenIsReadToTheLastBit) {
  const ExtinctionGrid grid = TestGrid();
  WriteVolume(folder_ / "volume.vdb", grid, {{"relight:stage", "volume"}});
  const ExtinctionGrid read = ReadVolume(folder_ / "volume.vdb");
  EXPECT_EQ(read.cells, grid.cells);
  EXPECT_TRUE(tests::SameBytes(tests::AllValues(read), tests::AllValues(grid)));
  EXPECT_EQ(read.cell_m, grid.cell_m);
  // Through the centre of a voxel and back: rounding of some metres
  EXPECT_LT((read.origin_m - grid.origin_m).cwiseAbs().maxCoeff(), 1e-14);
}

TEST_F(VdbFile, AnEmptyVolumeKeepsItsBox) {
  const ExtinctionGrid grid = tests::Slab({5, 6, 7}, 0.5, 0.0);
  WriteVolume(folder_ / "volume.vdb", grid);
  const ExtinctionGrid read = ReadVolume(folder_ / "volume.vdb");
  EXPECT_EQ(read.cells, grid.cells);
  EXPECT_TRUE(tests::SameBytes(tests::AllValues(read), tests::AllValues(grid)));
}

TEST_F(VdbFile, TheSameVolumeGivesTheSameBytes) {
  WriteVolume(folder_ / "a.vdb", TestGrid(), {{"one", "1"}, {"two", "2"}});
  WriteVolume(folder_ / "b.vdb", TestGrid(), {{"two", "2"}, {"one", "1"}});
  EXPECT_EQ(ReadText(folder_ / "a.vdb"), ReadText(folder_ / "b.vdb"));
  ExtinctionGrid other = TestGrid();
  other.Set(4, 0, 0, 99.04f);
  WriteVolume(folder_ / "b.vdb", other, {{"two", "2"}, {"one", "1"}});
  EXPECT_NE(ReadText(folder_ / "a.vdb"), ReadText(folder_ / "b.vdb"));
}

// What another program sees: names, units, size and place of the voxels.
TEST_F(VdbFile, IsAnOpenVdbFogVolume) {
  const ExtinctionGrid grid = TestGrid();
  WriteVolume(folder_ / "volume.vdb", grid, {{"relight:options", "cells=100"}});
  openvdb::io::File file((folder_ / "volume.vdb").string());
  file.open(false);
  EXPECT_EQ(file.getMetadata()->metaValue<std::string>("relight:options"), "cells=100");
  const auto vdb = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("extinction"));
  ASSERT_TRUE(vdb);
  EXPECT_EQ(vdb->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(vdb->metaValue<std::string>("unit"), "1/m");
  EXPECT_EQ(vdb->background(), 0.0f);
  EXPECT_EQ(vdb->activeVoxelCount(), FindOccupied(grid).cell.size());
  const openvdb::Vec3d center = vdb->indexToWorld(openvdb::Coord(2, 3, 4));
  const Eigen::Vector3d ours = grid.Center(2, 3, 4);
  EXPECT_NEAR(center.x(), ours.x(), 1e-12);
  EXPECT_NEAR(center.y(), ours.y(), 1e-12);
  EXPECT_NEAR(center.z(), ours.z(), 1e-12);
}

TEST_F(VdbFile, ChannelsComeBack) {
  const ExtinctionGrid grid = TestGrid();
  const std::size_t voxels = FindOccupied(grid).cell.size();
  std::vector<std::vector<float>> values(3, std::vector<float>(voxels));
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t v = 0; v < voxels; ++v) {
      values[c][v] = static_cast<float>(c) - 0.001f * static_cast<float>(v);
    }
  }
  WriteChannels(folder_ / "sky.vdb", grid, "sky", values);
  const auto read = ReadChannels(folder_ / "sky.vdb", grid, "sky", 3);
  ASSERT_EQ(read.size(), 3u);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_TRUE(tests::SameBytes(read[c], values[c]));
  EXPECT_THROW(ReadChannels(folder_ / "sky.vdb", grid, "sky", 4), InputError);
  EXPECT_THROW(ReadChannels(folder_ / "sky.vdb", grid, "sun", 1), InputError);
}

TEST_F(VdbFile, ForeignFilesAreRefused) {
  EXPECT_NE(Complaint(folder_ / "nothing.vdb").find("not there"), std::string::npos);
  for (const std::string& bytes : {std::string(),
                                   std::string("volume"),
                                   std::string(4096, '\0'),
                                   std::string("\xff\xd8\xff\xe0 JFIF"),
                                   std::string(" BDV") + std::string(8, '\xff')}) {
    const std::string said = Complaint(File(bytes));
    EXPECT_NE(said.find("other.vdb: cannot be read as OpenVDB"), std::string::npos)
        << said;
    EXPECT_NE(said.find("relight volume --force"), std::string::npos) << said;
  }
}

TEST_F(VdbFile, VolumesThatAreNoneOfOursAreRefused) {
  openvdb::initialize();
  const auto complaint = [&](const std::function<void(openvdb::FloatGrid&)>& change) {
    auto vdb = openvdb::FloatGrid::create(0.0f);
    vdb->setName("extinction");
    vdb->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    vdb->tree().setValue({1, 2, 3}, 0.5f);
    change(*vdb);
    const auto file = folder_ / "other.vdb";
    openvdb::io::File(file.string()).write({vdb});
    return Complaint(file);
  };
  // Another program's is taken as it is: the box of what is active
  EXPECT_EQ(complaint([](auto&) {}), "");
  EXPECT_EQ(ReadVolume(folder_ / "other.vdb").cells, Eigen::Vector3i(1, 1, 1));

  const auto says = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << text << "\"";
  };
  says(complaint([](auto& vdb) { vdb.setName("density"); }), "named \"extinction\"");
  says(complaint([](auto& vdb) { vdb.tree().setValue({4, 4, 4}, -1.0f); }), "negative");
  says(complaint([](auto& vdb) {
         vdb.tree().setValue({4, 4, 4}, std::numeric_limits<float>::quiet_NaN());
       }),
       "not finite");
  says(complaint([](auto& vdb) { vdb.tree().setValue({1200, 4, 4}, 1.0f); }), "1024");
  says(complaint([](auto& vdb) {
         vdb.insertMeta("cells", openvdb::Vec3IMetadata({2, 2, 2}));
       }),
       "outside the box");
  says(complaint([](auto& vdb) {
         vdb.insertMeta("cells", openvdb::Vec3IMetadata({2, -2, 2}));
       }),
       "1024");
  const auto transformed =
      [&](const std::function<void(openvdb::math::Transform&)>& how) {
        return complaint([&](auto& vdb) {
          auto transform = openvdb::math::Transform::createLinearTransform(0.1);
          how(*transform);
          vdb.setTransform(transform);
        });
      };
  EXPECT_EQ(transformed([](auto& t) { t.postTranslate({1, 2, 3}); }), "");
  says(transformed([](auto& t) { t.preScale(openvdb::Vec3d(1, 2, 1)); }), "not cubes");
  says(transformed([](auto& t) { t.preScale(openvdb::Vec3d(1, 1, -1)); }), "not cubes");
  says(transformed([](auto& t) { t.preRotate(0.3, openvdb::math::Z_AXIS); }),
       "not cubes along the axes");
}

// Cut off anywhere: an error, never a crash, never half a tree.
TEST_F(VdbFile, AFileCutOffIsRefused) {
  WriteVolume(folder_ / "ours.vdb", TestGrid());
  auto theirs = openvdb::FloatGrid::create(0.0f);  // Of another program: a random id
  theirs->setName("extinction");
  for (int i = 0; i < 3000; ++i) theirs->tree().setValue({i % 40, i % 37, i % 41}, 0.5f);
  openvdb::io::File((folder_ / "theirs.vdb").string()).write({theirs});
  EXPECT_EQ(Complaint(folder_ / "theirs.vdb"), "");
  for (const char* name : {"ours.vdb", "theirs.vdb"}) {
    const std::string whole = ReadText(folder_ / name);
    for (std::size_t length = 0; length < whole.size();
         length += std::max<std::size_t>(1, whole.size() / 97)) {
      EXPECT_NE(Complaint(File(whole.substr(0, length))), "")
          << name << ": " << length << " bytes of " << whole.size();
    }
    EXPECT_NE(Complaint(File(whole.substr(0, whole.size() - 1))), "") << name;
  }
}

// Any bytes changed are found, wherever they are.
TEST_F(VdbFile, ADamagedFileIsRefused) {
  WriteVolume(folder_ / "volume.vdb", TestGrid());
  const std::string whole = ReadText(folder_ / "volume.vdb");
  std::mt19937 random(52);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes = whole;
    // The header and the tree's topology are where one byte says most
    const std::size_t reach =
        trial % 2 == 0 ? std::min<std::size_t>(700, bytes.size()) : bytes.size();
    const std::size_t at = random() % reach;
    if (at == 35) continue;  // What marks it as ours: without it the id says nothing
    bytes[at] = static_cast<char>(bytes[at] ^ (1 + random() % 255));
    ASSERT_NE(Complaint(File(bytes)), "") << "byte " << at;
  }
}

TEST_F(VdbFile, WhatItsWriterNotedComesBack) {
  WriteVolume(
      folder_ / "volume.vdb", TestGrid(), {{"views", "a, b"}, {"objective", "3 2"}});
  const Metadata noted = ReadMetadata(folder_ / "volume.vdb");
  EXPECT_EQ(noted.at("views"), "a, b");
  EXPECT_EQ(noted.at("objective"), "3 2");
}

class VdbImportTest : public VdbFile {
 protected:
  VdbImportTest() { openvdb::initialize(); }

  // A box of 4 x 2 x 6 voxels of `density`, its lowest voxel's centre at (1, 2, 3).
  static openvdb::FloatGrid::Ptr Box(const std::string& name, float density) {
    auto vdb = openvdb::FloatGrid::create(0.0f);
    vdb->setName(name);
    auto transform = openvdb::math::Transform::createLinearTransform(0.5);
    transform->postTranslate({1.0, 2.0, 3.0});
    vdb->setTransform(transform);
    vdb->tree().fill(openvdb::CoordBBox({0, 0, 0}, {3, 1, 5}), density);
    return vdb;
  }
  ExtinctionGrid Imported(const openvdb::GridPtrVec& grids,
                          const VdbImport& options = {}) {
    openvdb::io::File((folder_ / "their tree.vdb").string()).write(grids);
    return ImportVdb(folder_ / "their tree.vdb", options);
  }
  std::string ComplaintOf(const openvdb::GridPtrVec& grids,
                          const VdbImport& options = {}) {
    try {
      Imported(grids, options);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }
  static double Mass(const ExtinctionGrid& grid) {
    double sum = 0;
    for (const float sigma : grid.sigma_per_m) sum += sigma;
    return sum * std::pow(grid.cell_m, 3);
  }
};

TEST_F(VdbImportTest, KeepsVoxelsThatAreCubes) {
  auto vdb = Box("density", 2.0f);
  vdb->tree().setValue({2, 1, 4}, 0.3f);
  const ExtinctionGrid grid = Imported({vdb}, {.scale_per_m = 1.5});
  EXPECT_EQ(grid.cells, Eigen::Vector3i(4, 2, 6));
  EXPECT_NEAR(grid.cell_m, 0.5, 1e-12);
  EXPECT_TRUE(grid.origin_m.isApprox(Eigen::Vector3d(0.75, 1.75, 2.75)));
  EXPECT_FLOAT_EQ(grid.At(0, 0, 0), 3.0f);
  EXPECT_FLOAT_EQ(grid.At(2, 1, 4), 0.45f);
}

// Houdini's and Maya's y is up, and a unit can be a centimetre.
TEST_F(VdbImportTest, TurnsYUpAndUnitsIntoMetres) {
  const ExtinctionGrid grid =
      Imported({Box("density", 2.0f)}, {.unit_m = 0.01, .up = UpAxis::kY});
  EXPECT_EQ(grid.cells, Eigen::Vector3i(4, 6, 2));
  EXPECT_NEAR(grid.cell_m, 0.005, 1e-12);
  // East is x; north is -z, from -(3 + 2.75) to -(3 - 0.25); up is y
  EXPECT_TRUE(grid.origin_m.isApprox(Eigen::Vector3d(0.0075, -0.0575, 0.0175), 1e-9));
}

TEST_F(VdbImportTest, CoarserVoxelsAreMeans) {
  auto vdb = Box("density", 0.0f);
  for (int z = 0; z < 6; ++z) vdb->tree().setValue({1, 1, z}, 1.0f);
  const double mass = 6 * std::pow(0.5, 3);
  const ExtinctionGrid grid = Imported({vdb}, {.cells = 3});
  EXPECT_EQ(grid.cells.z(), 3);
  // Values between voxels are interpolated: what lies at the border of the box is lost
  EXPECT_NEAR(Mass(grid), mass, 0.25 * mass);
}

TEST_F(VdbImportTest, TakesVoxelsThatAreTurned) {
  auto vdb = openvdb::FloatGrid::create(0.0f);
  vdb->setName("density");
  auto transform = openvdb::math::Transform::createLinearTransform(0.1);
  transform->postRotate(0.5, openvdb::math::Z_AXIS);
  vdb->setTransform(transform);
  for (int x = -20; x <= 20; ++x) {
    for (int y = -20; y <= 20; ++y) {
      for (int z = -20; z <= 20; ++z) {
        if (x * x + y * y + z * z < 256) vdb->tree().setValue({x, y, z}, 1.0f);
      }
    }
  }
  const double ball_m3 = 4.0 / 3 * 3.14159265358979 * std::pow(1.6, 3);
  EXPECT_NEAR(Mass(Imported({vdb})), ball_m3, 0.02 * ball_m3);
}

TEST_F(VdbImportTest, ChoosesItsGrid) {
  const openvdb::GridPtrVec both = {Box("heat", 1.0f), Box("density", 2.0f)};
  EXPECT_EQ(Imported(both).At(0, 0, 0), 2.0f);
  EXPECT_EQ(Imported(both, {.grid = "heat"}).At(0, 0, 0), 1.0f);
  EXPECT_EQ(Imported({Box("leaves", 3.0f)}).At(0, 0, 0), 3.0f);
  const std::string said = ComplaintOf({Box("heat", 1.0f), Box("leaves", 2.0f)});
  EXPECT_NE(said.find("--grid one of heat, leaves"), std::string::npos) << said;
  const std::string wrong = ComplaintOf(both, {.grid = "wood"});
  EXPECT_NE(wrong.find("no grid of floats named \"wood\""), std::string::npos) << wrong;
}

TEST_F(VdbImportTest, SaysWhatIsWrong) {
  const auto complains = [&](const openvdb::FloatGrid::Ptr& vdb, const std::string& of) {
    const std::string said = ComplaintOf({vdb});
    EXPECT_NE(said.find(of), std::string::npos) << said;
    EXPECT_NE(said.find("their tree.vdb"), std::string::npos) << said;
  };
  auto surface = Box("density", 1.0f);
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  complains(surface, "level set");
  complains(Box("density", -1.0f), "negative or not finite");
  complains(Box("density", std::numeric_limits<float>::infinity()), "not finite");
  complains(openvdb::FloatGrid::create(0.0f), "is empty");
  auto fog = openvdb::FloatGrid::create(0.1f);
  fog->tree().setValue({0, 0, 0}, 0.5f);
  complains(fog, "background of 0");
  auto large = Box("density", 1.0f);
  large->tree().setValue({800, 0, 0}, 1.0f);
  complains(large, "--cells N");
  EXPECT_EQ(Imported({large}, {.cells = 100}).cells.x(), 100);
}

}  // namespace
}  // namespace relight
