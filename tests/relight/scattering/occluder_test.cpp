// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/occluder.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/scattering/arriving_light.h"
#include "relight/volume/vdb_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

namespace relight {
namespace {

using std::numbers::pi;

// A wall across x, from the ground up, `width_m` to each side of the x axis.
Occluder Wall(double x_m, double width_m, double height_m) {
  return {{{x_m, -width_m, 0},
           {x_m, width_m, 0},
           {x_m, width_m, height_m},
           {x_m, -width_m, height_m}},
          {{0, 1, 2}, {0, 2, 3}}};
}

const ExtinctionGrid& Tree() {
  static const ExtinctionGrid grid = tests::Ball({0, 0, 3}, 1.5, 0.7, 16);
  return grid;
}

const Eigen::Vector3d kEvening =
    DirectionFromAzimuthElevation(RadFromDeg(268), RadFromDeg(12));

TEST(Occluder, AWallInTheWestTakesTheEveningSun) {
  const OccupiedVoxels occupied = FindOccupied(Tree());
  const auto lit = [&](const Occluder* occluder, const Eigen::Vector3d& sun) {
    double sum = 0;
    for (const float tau : SunTransmittance(
             Tree(), occupied, sun, {.sun_directions = 16, .own_shade = 0}, occluder)) {
      sum += tau;
    }
    return sum;
  };
  const Occluder wall = Wall(-8, 30, 12);
  EXPECT_GT(lit(nullptr, kEvening), 1);
  EXPECT_EQ(lit(&wall, kEvening), 0);
  // Over the wall's top, and from its other side
  for (const Eigen::Vector3d& sun :
       {DirectionFromAzimuthElevation(RadFromDeg(268), RadFromDeg(70)),
        DirectionFromAzimuthElevation(RadFromDeg(90), RadFromDeg(12))}) {
    EXPECT_EQ(lit(&wall, sun), lit(nullptr, sun));
  }
  // The wall's upper edge before the middle of the tree: some of it is lit
  const double edge_m = 3 + 8 * std::tan(RadFromDeg(12));
  const Occluder half = Wall(-8, 30, edge_m);
  EXPECT_GT(lit(&half, kEvening), 0.2 * lit(nullptr, kEvening));
  EXPECT_LT(lit(&half, kEvening), 0.8 * lit(nullptr, kEvening));
}

TEST(Occluder, FarAwayOrEmptyItChangesNothing) {
  const OccupiedVoxels occupied = FindOccupied(Tree());
  // Below the ground's line of sight from every voxel
  const Occluder far = Wall(-1e6, 10, 1), none;
  EXPECT_TRUE(none.empty());
  const SkyTransmittanceOptions few{.bands = 4, .directions = 256};
  const SkyTransmittance alone = ProjectTransmittance(Tree(), occupied, few);
  for (const Occluder* occluder : {&far, &none}) {
    EXPECT_EQ(ProjectTransmittance(Tree(), occupied, few, {}, occluder).half, alone.half);
    EXPECT_EQ(SunTransmittance(Tree(), occupied, kEvening, {}, occluder),
              SunTransmittance(Tree(), occupied, kEvening));
  }
}

TEST(Occluder, AnEndlessWallTakesHalfOfAUniformSky) {
  // One voxel of next to nothing beside a wall without end: half of the sphere is left
  ExtinctionGrid grid = tests::Slab({5, 5, 5}, 0.2, 0.0);
  grid.Set(2, 2, 2, 1e-30f);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Occluder wall({{-0.6, -1e7, -1e7}, {-0.6, 1e7, -1e7}, {-0.6, 0, 1e7}},
                      {{0, 1, 2}});
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 2}, {}, &wall);
  // c_00 = sqrt(1 / 4 pi) 2 pi; 1024 directions and half floats
  EXPECT_NEAR(sky.Coefficient(0, 0) / (2 * pi * std::sqrt(1 / (4 * pi))), 1, 3e-3);
  // c_11 = integral of x Y over the half with x > 0: sqrt(3 / 4 pi) pi
  EXPECT_NEAR(sky.Coefficient(3, 0) / (pi * std::sqrt(3 / (4 * pi))), 1, 3e-3);
}

TEST(Occluder, ManyTrianglesAreMetAsOneByOne) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-5, 5), size(-0.7, 0.7);
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> faces;
  std::vector<Occluder> single;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d at(place(random), place(random), place(random));
    const int first = static_cast<int>(vertices.size());
    for (int c = 0; c < 3; ++c) {
      vertices.push_back(at + Eigen::Vector3d(size(random), size(random), size(random)));
    }
    faces.push_back({first, first + 1, first + 2});
    single.emplace_back(std::vector(vertices.end() - 3, vertices.end()),
                        std::vector<std::array<int, 3>>{{0, 1, 2}});
  }
  const Occluder all(vertices, faces);
  EXPECT_EQ(all.triangles(), 300u);
  int hidden = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d from(place(random), place(random), place(random));
    // Also along the axes, where a slab has no side to enter by
    Eigen::Vector3d to(place(random), place(random), place(random));
    if (i % 4 == 0) to = from + Eigen::Vector3d::Unit(i / 4 % 3);
    const Eigen::Vector3d direction = (to - from).normalized();
    double expected = 1;
    for (const Occluder& one : single) expected *= one.Transmittance(from, direction);
    EXPECT_EQ(all.Transmittance(from, direction), expected) << i;
    hidden += expected == 0;
    // Reciprocity: from either end the way is the same
    EXPECT_EQ(all.TransmittanceBetween(from, to), all.TransmittanceBetween(to, from));
  }
  EXPECT_GT(hidden, 200);
  EXPECT_LT(hidden, 1900);
}

TEST(Occluder, AVolumeIsMoreExtinction) {
  const tests::ScratchFolder folder;
  const auto file = folder / "hedge.vdb";
  ExtinctionGrid hedge = tests::Slab({8, 40, 12}, 0.25, 0.9);
  hedge.origin_m.x() = -6;
  WriteVolume(file, hedge);
  const Occluder read = ReadOccluder(file);
  const Eigen::Vector3d west(-1, 0, 0), at(0, 0, 1.1);
  EXPECT_NEAR(read.Transmittance(at, west), std::exp(-0.9 * 2), 1e-6);
  EXPECT_EQ(read.Transmittance(at, {1, 0, 0}), 1);
  EXPECT_NEAR(read.TransmittanceBetween(at, {-5, 0, 1.1}), std::exp(-0.9 * 1), 1e-6);
  EXPECT_NEAR(read.TransmittanceBetween({-5, 0, 1.1}, at), std::exp(-0.9 * 1), 1e-6);
  const OccupiedVoxels occupied = FindOccupied(Tree());
  const std::vector<float> alone = SunTransmittance(Tree(), occupied, west),
                           behind = SunTransmittance(Tree(), occupied, west, {}, &read);
  for (std::size_t v = 0; v < alone.size(); ++v) {
    const double z = Tree().Center(0, 0, occupied.cell[v].z()).z();
    // The hedge is 3 m high
    EXPECT_NEAR(behind[v], alone[v] * (z < 3 ? std::exp(-1.8) : 1), 1e-5 * alone[v]);
  }
}

TEST(Occluder, ReadsFacesOfEveryKind) {
  const tests::ScratchFolder folder;
  const auto file = folder / "house.obj";
  std::ofstream(file)
      << "# a house\r\nmtllib house.mtl\no wall\nv -8 -30 0 1\nv -8 +30 0\n"
         "v -8 30 12\nvn 1 0 0\nvt 0 0\nv -8 -30 1.2e1\n"
         "usemtl brick\ns off\nf -4//1 -3//1 -2//1 4/1/1\nf 1 2 2\n";
  const Occluder house = ReadOccluder(file);
  EXPECT_EQ(house.triangles(), 2u);  // The one without an area is none
  EXPECT_EQ(house.Transmittance({0, 0, 3}, kEvening), 0);
  EXPECT_EQ(house.Transmittance({0, 0, 3}, -kEvening), 1);
}

TEST(Occluder, RefusesByFileAndLine) {
  const tests::ScratchFolder folder;
  const auto refusal = [&](const std::string& name, const std::string& text) {
    const auto file = folder / name;
    std::ofstream(file) << text;
    try {
      ReadOccluder(file);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"", "no faces"},
           {corners, "no faces"},
           {corners + "f 1 2 4\n", ":4: a face names vertex 4 of 3"},
           {corners + "f 1 2 -4\n", "vertex -4"},
           {corners + "f 1 2 0\n", "vertex 0"},
           {corners + "f 1 2\n", "three corners"},
           {corners + "f 1 2 x\n", "no corner"},
           {corners + "f 1 2 99999999999999999999\n", "no corner"},
           {"v 0 0\n", ":1: a vertex has three numbers"},
           {"v 0 nan 0\n", "no place"},
           {"v 0 inf 0\n", "no place"},
           {"v 0 1e12 0\n", "no place"},
           {"v 0 zero 0\n", "no number"}}) {
    const std::string said = refusal("bad.obj", text);
    EXPECT_NE(said.find(word), std::string::npos) << text << said;
    EXPECT_NE(said.find("bad.obj"), std::string::npos) << said;
  }
  EXPECT_NE(refusal("house.ply", "ply").find(".obj or a volume as .vdb"),
            std::string::npos);
  EXPECT_NE(refusal("house.vdb", "no vdb").find("house.vdb"), std::string::npos);
  EXPECT_THROW(ReadOccluder(folder / "missing.obj"), InputError);
}

}  // namespace
}  // namespace relight
