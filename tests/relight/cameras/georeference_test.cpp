// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/georeference.h"

#include "relight/base/error.h"
#include "relight/cameras/colmap_model.h"
#include "tests/support/made_cameras.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>
#include <GeographicLib/LocalCartesian.hpp>

#include <algorithm>
#include <random>

namespace relight {
namespace {

const Place kPlace{40.35, -74.65, 20};

// Cameras in ENU metres, and the same in a frame of some program.
struct Made {
  CalibratedScene world, model;
  double scale = 0;          // Of the world to the model.
  Eigen::Matrix3d rotation;  // World from model.
};

CalibratedScene RingScene(int count, double distance_m) {
  CalibratedScene scene;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d away =
        DirectionFromAzimuthElevation(2 * std::numbers::pi * i / count, 0);
    const Eigen::Vector3d eye = distance_m * away + Eigen::Vector3d(0, 0, 1.6);
    scene.cameras.push_back({"view_" + std::to_string(10 + i),
                             tests::LookingAt(eye, {0, 0, 5}, 800, 600, 700)});
  }
  return scene;
}

Made InAnotherFrame(const CalibratedScene& world, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-2, 2);
  Made made;
  made.world = world;
  Georeference any;
  any.scale = std::exp(uniform(random));
  any.rotation =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
          .normalized()
          .toRotationMatrix();
  any.translation = 3 * Eigen::Vector3d(normal(random), normal(random), normal(random));
  made.model = InWorld(world, any);
  made.model.enu_origin.reset();
  made.scale = 1 / any.scale;
  made.rotation = any.rotation.transpose();
  return made;
}

// What the photos of these cameras say, with noise.
std::vector<CameraClues> CluesOf(const CalibratedScene& world,
                                 double gps_m,
                                 double compass_deg,
                                 std::mt19937& random) {
  const GeographicLib::LocalCartesian frame(
      kPlace.latitude_deg, kPlace.longitude_deg, kPlace.altitude_m);
  std::normal_distribution<double> normal;
  std::vector<CameraClues> clues;
  for (const auto& [view, camera] : world.cameras) {
    Eigen::Vector3d at = camera.PositionInWorld();
    for (int axis = 0; axis < 3; ++axis) at[axis] += gps_m * normal(random);
    CameraClues clue{.view = view};
    Place place;
    frame.Reverse(at.x(),
                  at.y(),
                  at.z(),
                  place.latitude_deg,
                  place.longitude_deg,
                  place.altitude_m);
    clue.place = place;
    clue.heading_rad =
        AzimuthOf(camera.ForwardInWorld()) + RadFromDeg(compass_deg) * normal(random);
    clues.push_back(clue);
  }
  return clues;
}

struct Errors {
  double north_rad, up_rad, scale;
};

Errors ErrorsOf(const Made& made, const Georeference& found) {
  // Turn of the found world against the true one
  const Eigen::Matrix3d turn = found.rotation * made.rotation.transpose();
  const Eigen::Vector3d north = turn * Eigen::Vector3d::UnitY();
  return {std::abs(std::atan2(north.x(), north.y())),
          AngleBetween(turn * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()),
          std::abs(found.scale / made.scale - 1)};
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

struct Quantiles {
  std::vector<double> north_deg, up_deg, scale;

  void Add(const Errors& e) {
    north_deg.push_back(DegFromRad(e.north_rad));
    up_deg.push_back(DegFromRad(e.up_rad));
    scale.push_back(e.scale);
  }
  void Print(const char* what) const {
    std::printf(
        "%s: median (95th percentile): north %.2f (%.2f) deg, up %.3f (%.3f) deg, "
        "scale %.2f (%.2f) %%\n",
        what,
        Quantile(north_deg, 0.5),
        Quantile(north_deg, 0.95),
        Quantile(up_deg, 0.5),
        Quantile(up_deg, 0.95),
        100 * Quantile(scale, 0.5),
        100 * Quantile(scale, 0.95));
  }
};

TEST(Georeference, WithoutNoiseTheFrameIsFoundExactly) {
  std::mt19937 random(1);
  for (int n = 0; n < 10; ++n) {
    const Made made = InAnotherFrame(RingScene(8, 20), random);
    const Georeference found =
        FindGeoreference(made.model, CluesOf(made.world, 0, 0, random));
    const Errors errors = ErrorsOf(made, found);
    // Degrees of latitude in a double are known to some 1e-9 m
    EXPECT_LT(errors.north_rad, 1e-6);
    EXPECT_LT(errors.up_rad, 1e-6);
    EXPECT_LT(errors.scale, 1e-6);
    EXPECT_FALSE(found.kept_frame);
    const CalibratedScene world = InWorld(made.model, found);
    for (std::size_t i = 1; i < world.cameras.size(); ++i) {
      const auto between = [&](const CalibratedScene& scene) -> Eigen::Vector3d {
        return scene.cameras[i].camera.PositionInWorld() -
               scene.cameras[0].camera.PositionInWorld();
      };
      EXPECT_LT((between(world) - between(made.world)).norm(), 1e-4);
    }
  }
}

// 3 m of noise in GPS, 5 degrees in headings, 200 seeds. GPS alone would have about 2
// degrees (3 m over the ring's radius times the root of the count), headings alone 1.4.
TEST(Georeference, JoinsGpsAndCompassOfARenderedTree) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/sparse");
  const CalibratedScene world = ReadColmap(tests::SharedPath("data/maple/sparse"));
  Quantiles both, gps_only;
  int honest = 0;
  constexpr int kSeeds = 200;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(seed);
    const Made made = InAnotherFrame(world, random);
    std::vector<CameraClues> clues = CluesOf(made.world, 3, 5, random);
    const Georeference found = FindGeoreference(made.model, clues);
    const Errors errors = ErrorsOf(made, found);
    both.Add(errors);
    honest += errors.north_rad < 2 * found.north_error_rad;
    for (CameraClues& clue : clues) clue.heading_rad.reset();
    gps_only.Add(ErrorsOf(made, FindGeoreference(made.model, clues)));
  }
  both.Print("GPS and compass");
  gps_only.Print("GPS alone");
  EXPECT_LE(Quantile(both.north_deg, 0.5), 1.0);
  EXPECT_LE(Quantile(both.up_deg, 0.5), 0.5);
  EXPECT_LE(Quantile(both.scale, 0.5), 0.03);
  // Two standard deviations hold in 95 of 100; their own estimate is uncertain, too
  EXPECT_GE(honest, 0.85 * kSeeds);
  EXPECT_LT(Quantile(both.north_deg, 0.5), Quantile(gps_only.north_deg, 0.5));
}

TEST(Georeference, WrongQuadrantsAndWrongPlacesAreFoundAndNamed) {
  Quantiles errors;
  for (int seed = 0; seed < 30; ++seed) {
    std::mt19937 random(100 + seed);
    const Made made = InAnotherFrame(RingScene(14, 20), random);
    std::vector<CameraClues> clues = CluesOf(made.world, 3, 5, random);
    *clues[2].heading_rad += std::numbers::pi / 2;
    *clues[5].heading_rad += std::numbers::pi;
    clues[7].heading_rad.reset();
    clues[9].place->latitude_deg += 0.002;  // 222 m
    clues[11].place.reset();
    const Georeference found = FindGeoreference(made.model, clues);
    errors.Add(ErrorsOf(made, found));
    EXPECT_TRUE(found.residuals[2].compass_is_outlier);
    EXPECT_TRUE(found.residuals[5].compass_is_outlier);
    EXPECT_FALSE(found.residuals[7].compass_rad);
    EXPECT_TRUE(found.residuals[9].gps_is_outlier);
    EXPECT_FALSE(found.residuals[11].gps_m);
    EXPECT_EQ(found.notes.size(), 2u);
  }
  errors.Print("two wrong headings, one wrong place of 14");
  EXPECT_LE(Quantile(errors.north_deg, 0.5), 1.5);
  EXPECT_LE(Quantile(errors.north_deg, 1.0), 6.0);
}

TEST(Georeference, PlacesThatLieTogetherLeaveNorthToTheCompass) {
  std::mt19937 random(7);
  const Made made = InAnotherFrame(RingScene(12, 2), random);  // 2 m, with 3 m of error
  const std::vector<CameraClues> clues = CluesOf(made.world, 3, 5, random);
  GivenFrame given;
  const double apart_m = (made.world.cameras[0].camera.PositionInWorld() -
                          made.world.cameras[6].camera.PositionInWorld())
                             .norm();
  given.distance = {made.world.cameras[0].view, made.world.cameras[6].view, apart_m};
  const Georeference found = FindGeoreference(made.model, clues, given);
  const Errors errors = ErrorsOf(made, found);
  EXPECT_LT(errors.north_rad, RadFromDeg(4));  // 5 degrees over the root of 12, twice
  EXPECT_LT(errors.up_rad, RadFromDeg(1));
  EXPECT_LT(errors.scale, 0.02);
  EXPECT_NE(found.north_from.find("compass"), std::string::npos);
  EXPECT_NE(found.scale_from.find("--scale-from"), std::string::npos);
}

TEST(Georeference, AHeadingOrAShadowTellsNorthWithoutAnyCompass) {
  std::mt19937 random(8);
  const Made made = InAnotherFrame(RingScene(9, 15), random);
  std::vector<CameraClues> none;
  GivenFrame given;
  given.distance = {"view_10",
                    "view_14",
                    (made.world.cameras[0].camera.PositionInWorld() -
                     made.world.cameras[4].camera.PositionInWorld())
                        .norm()};
  given.heading = {"view_11", AzimuthOf(made.world.cameras[1].camera.ForwardInWorld())};
  Errors errors = ErrorsOf(made, FindGeoreference(made.model, none, given));
  EXPECT_LT(errors.north_rad, RadFromDeg(0.01));
  EXPECT_LT(errors.scale, 1e-4);

  // A pole at (1, 0) m throws its shadow away from a sun in the south-west
  given.heading.reset();
  const double sun_rad = RadFromDeg(230);
  const Eigen::Vector3d foot(1, 0, 0);
  const Eigen::Vector3d tip = foot - 2 * DirectionFromAzimuthElevation(sun_rad, 0);
  const Camera& camera = made.world.cameras[2].camera;
  given.shadow = {"view_12", *camera.Project(foot), *camera.Project(tip), sun_rad};
  errors = ErrorsOf(made, FindGeoreference(made.model, none, given));
  EXPECT_LT(errors.north_rad, RadFromDeg(0.01));
}

TEST(Georeference, AModelInMetresEastNorthUpStaysAsItIs) {
  std::mt19937 random(9);
  const CalibratedScene world = RingScene(12, 25);
  const Georeference found = FindGeoreference(world, CluesOf(world, 3, 5, random));
  EXPECT_TRUE(found.kept_frame);
  EXPECT_EQ(found.scale, 1.0);
  EXPECT_EQ(found.rotation, Eigen::Matrix3d::Identity());

  // Turned by 30 degrees it does not agree any more
  Georeference turn;
  turn.rotation = Eigen::AngleAxisd(RadFromDeg(30), Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(
      FindGeoreference(InWorld(world, turn), CluesOf(world, 3, 5, random)).kept_frame);
}

TEST(Georeference, SaysEverythingThatIsMissing) {
  std::mt19937 random(10);
  const Made made = InAnotherFrame(RingScene(6, 12), random);
  try {
    FindGeoreference(made.model, {});
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const char* part :
         {"--heading VIEW=DEG", "--north-from-shadow", "--scale-from", "--keep-frame"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
    }
  }
}

// The place of the origin goes along when it moves: 100 m north is 0.0009 degrees.
TEST(Georeference, TheOriginMovesWithItsPlace) {
  CalibratedScene scene = RingScene(3, 10);
  scene.enu_origin = kPlace;
  const CalibratedScene moved = MovedTo(scene, {0, 100, -2});
  EXPECT_NEAR(moved.enu_origin->latitude_deg, 40.35 + 100 / 111034.0, 1e-6);
  EXPECT_NEAR(moved.enu_origin->altitude_m, 18, 1e-2);  // And the Earth is round
  EXPECT_LT((moved.cameras[1].camera.PositionInWorld() -
             scene.cameras[1].camera.PositionInWorld() - Eigen::Vector3d(0, -100, 2))
                .norm(),
            1e-9);
}

}  // namespace
}  // namespace relight
