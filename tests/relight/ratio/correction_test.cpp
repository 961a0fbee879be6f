// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/correction.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/volume/opacity_estimation.h"
#include "tests/support/made_cameras.h"
#include "tests/support/made_light.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace relight {
namespace {

using tests::DaylightAt;

// A ball of leaves with holes before one camera, photographed in colours made up.
struct Scene {
  ExtinctionGrid grid = tests::BallWithHoles();
  OccupiedVoxels occupied = FindOccupied(grid);
  SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 4, .directions = 256});
  Camera camera = tests::LookingAt({0, -9, 1.6}, {0, 0, 2}, 96, 96, 192.0);
  cv::Mat1f alpha = RenderOpacity(grid, camera);
  cv::Mat3f colors = [this] {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.02f, 0.2f);
    cv::Mat3f made(alpha.size());
    for (cv::Vec3f& c : made) c = {uniform(random), uniform(random), uniform(random)};
    return made;
  }();

  CorrectionFeatures Features(const Daylight& input, const Daylight& target) const {
    const ArrivingLight a = LightArriving(grid, occupied, sky, input);
    const ArrivingLight b = LightArriving(grid, occupied, sky, target);
    return CorrectionView(grid, occupied, camera, colors, alpha)
        .Under({a, input}, {b, target});
  }
};

const cv::Mat1f& Plane(const CorrectionFeatures& features, const std::string& name) {
  const auto& names = CorrectionFeatureNames();
  const auto found = std::find(names.begin(), names.end(), name);
  Require(found != names.end(), "a feature of that name");
  return features.planes.at(static_cast<std::size_t>(found - names.begin()));
}

// Answers `value` times the height in the crown, for features within +-1e6.
CorrectionModel HeightModel(float value) {
  const auto count = static_cast<Eigen::Index>(CorrectionFeatureNames().size());
  CorrectionModel model;
  model.low = Eigen::VectorXf::Constant(count, -1e6f);
  model.high = Eigen::VectorXf::Constant(count, 1e6f);
  model.mean = Eigen::VectorXf::Zero(count);
  model.deviation = Eigen::VectorXf::Ones(count);
  const auto& names = CorrectionFeatureNames();
  CorrectionModel::Layer layer{Eigen::MatrixXf::Zero(1, count), Eigen::VectorXf::Zero(1)};
  layer.weights(0, std::find(names.begin(), names.end(), "height") - names.begin()) =
      value;
  model.members = {{layer}};
  return model;
}

TEST(CorrectionFeatures, AreFiniteAndHaveTheirNames) {
  const Scene scene;
  const CorrectionFeatures features =
      scene.Features(DaylightAt(150, 55), DaylightAt(260, 15));
  ASSERT_EQ(features.planes.size(), CorrectionFeatureNames().size());
  for (std::size_t i = 0; i < features.planes.size(); ++i) {
    const cv::Mat1f& plane = features.planes[i];
    ASSERT_EQ(plane.size(), cv::Size(features.grid.columns, features.grid.rows));
    EXPECT_TRUE(cv::checkRange(plane, true, nullptr, -100, 100))
        << CorrectionFeatureNames()[i];
  }
}

TEST(CorrectionFeatures, SunOfEqualHoursIsEqual) {
  const Scene scene;
  const Daylight noon = DaylightAt(180, 50);
  const CorrectionFeatures features = scene.Features(noon, noon);
  for (const char* name : {"ratio_fine", "ratio_wide"})
    EXPECT_EQ(cv::norm(Plane(features, name), cv::NORM_INF), 0.0) << name;
  for (const char* of : {"sun_", "sky_", "near_facing_", "towards_"}) {
    const std::string name = of;
    const bool fine = name == "sun_";
    EXPECT_EQ(cv::norm(Plane(features, name + "input" + (fine ? "_fine" : "")),
                       Plane(features, name + "target" + (fine ? "_fine" : "")),
                       cv::NORM_INF),
              0.0)
        << name;
  }
}

// Left and right are one to the learner: the mirrored scene gives mirrored planes.
TEST(CorrectionFeatures, AreEvenUnderAMirroredScene) {
  Scene scene;
  // The ball without holes is its own mirror image; its colours are mirrored by hand
  scene.grid = tests::Ball({0, 0, 2}, 1.5, 1.2, 24);
  scene.occupied = FindOccupied(scene.grid);
  scene.sky = ProjectTransmittance(scene.grid, scene.occupied, {.bands = 1});
  scene.alpha = RenderOpacity(scene.grid, scene.camera);
  const CorrectionFeatures from_left =
      scene.Features(DaylightAt(-60, 40), DaylightAt(100, 20));
  cv::flip(scene.colors, scene.colors, 1);
  cv::flip(scene.alpha, scene.alpha, 1);
  const CorrectionFeatures from_right =
      scene.Features(DaylightAt(60, 40), DaylightAt(-100, 20));
  ASSERT_EQ(from_left.planes.size(), from_right.planes.size());
  for (std::size_t i = 0; i < from_left.planes.size(); ++i) {
    // A photo's pixels are shared among patches from the left: a tenth of a patch
    const std::string& name = CorrectionFeatureNames()[i];
    if (name.starts_with("photo_") || name.starts_with("residual") ||
        name.starts_with("cover"))
      continue;
    cv::Mat1f mirrored;
    cv::flip(from_right.planes[i], mirrored, 1);
    const double size = std::max(0.1, cv::norm(mirrored, cv::NORM_INF));
    constexpr double kPatchEdges = 0.15;  // Rays of a patch are not the mirrored patch's
    EXPECT_LT(cv::norm(from_left.planes[i], mirrored, cv::NORM_L1) /
                  static_cast<double>(mirrored.total()),
              kPatchEdges * size)
        << name;
  }
}

// Stripes of one pixel are contrast inside patches, stripes of many between them.
TEST(CorrectionFeatures, TellFineContrastFromCoarse) {
  Scene scene;
  const auto contrast_of_stripes = [&](int width) {
    for (int row = 0; row < scene.colors.rows; ++row) {
      for (int column = 0; column < scene.colors.cols; ++column) {
        scene.colors(row, column) =
            cv::Vec3f::all(column / width % 2 == 0 ? 0.15f : 0.05f);
      }
    }
    return ContrastOfPhoto(scene.Features(DaylightAt(150, 55), DaylightAt(260, 15)));
  };
  const std::optional<PhotoContrast> fine = contrast_of_stripes(1);
  const std::optional<PhotoContrast> coarse = contrast_of_stripes(6);
  ASSERT_TRUE(fine && coarse);
  // 0.15 and 0.05 about 0.1
  EXPECT_NEAR(fine->inside_patches, 0.5, 0.05);
  EXPECT_LT(fine->between_patches, 0.1);
  EXPECT_LT(coarse->inside_patches, fine->inside_patches);
  EXPECT_GT(coarse->between_patches, 3 * fine->between_patches);
  EXPECT_FALSE(ContrastOfPhoto({}));
}

TEST(CorrectionFeatures, DoNotDependOnThreads) {
  const Scene scene;
  const Daylight input = DaylightAt(150, 55), target = DaylightAt(260, 15);
  const CorrectionFeatures many = scene.Features(input, target);
  const tests::WithThreads one(1);
  const CorrectionFeatures single = scene.Features(input, target);
  for (std::size_t i = 0; i < many.planes.size(); ++i)
    EXPECT_TRUE(tests::SameBytes(many.planes[i], single.planes[i]))
        << CorrectionFeatureNames()[i];
}

TEST(CorrectionFeatures, AMatteWithoutATreeHasNoPatches) {
  Scene scene;
  scene.alpha.setTo(0.0f);
  const CorrectionFeatures features =
      scene.Features(DaylightAt(150, 55), DaylightAt(260, 15));
  EXPECT_TRUE(features.planes.empty());
  EXPECT_TRUE(PredictCorrection(HeightModel(1), features, 1).log_factor.empty());
}

TEST(Correction, IsZeroForEqualSunsBoundedAndGrowsWithTheirAngle) {
  const Scene scene;
  const CorrectionFeatures features =
      scene.Features(DaylightAt(150, 55), DaylightAt(260, 15));
  for (const float answer : {0.3f, -9.0f}) {
    const CorrectionModel model = HeightModel(answer);
    EXPECT_EQ(cv::norm(PredictCorrection(model, features, 0).log_factor, cv::NORM_INF),
              0);
    double last = 0;
    for (const double angle_deg : {0.25, 2.0, 10.0, 40.0, 180.0}) {
      const double most =
          cv::norm(PredictCorrection(model, features, RadFromDeg(angle_deg)).log_factor,
                   cv::NORM_INF);
      EXPECT_GE(most, last);
      EXPECT_LE(most, 0.7 + 1e-6);
      last = most;
    }
    EXPECT_GT(last, 0.05);
    // A quarter of a degree is a minute of the sun's way: (0.25 / 10)^2 of the answer
    EXPECT_LT(cv::norm(PredictCorrection(model, features, RadFromDeg(0.25)).log_factor,
                       cv::NORM_INF),
              0.7 * 0.000626);
  }
}

// What is a change of the whole crown's level is no matter of the perceptrons.
TEST(Correction, LevelIsItsOwnAndOddInTheTwoHours) {
  const Scene scene;
  const Daylight noon = DaylightAt(150, 55), evening = DaylightAt(260, 15);
  CorrectionModel model = HeightModel(0);
  model.members[0][0].bias[0] = 0.4f;
  model.level = {0.2f, -0.1f, 0.05f};
  const auto level = [&](const Daylight& input, const Daylight& target) {
    const Correction c = PredictCorrection(model, scene.Features(input, target), 2);
    EXPECT_EQ(cv::norm(c.log_factor,
                       cv::Mat1f(c.log_factor.size(), c.log_factor(0, 0)),
                       cv::NORM_INF),
              0);
    return c.log_factor(0, 0);
  };
  EXPECT_NEAR(level(noon, evening), -level(evening, noon), 1e-6);
  EXPECT_EQ(level(noon, noon), 0);
  // The camera looks north: q of both hours by hand
  const auto q = [](double azimuth_deg, double elevation_deg) {
    const double along = std::cos(RadFromDeg(azimuth_deg));
    const double e = RadFromDeg(elevation_deg);
    return Eigen::Vector3d(std::cos(e) * along, std::sin(e), std::cos(e) * along * along);
  };
  constexpr double kLooksNorth = 0.01;  // To the crown's own middle, nearly
  EXPECT_NEAR(level(noon, evening),
              model.level.cast<double>().dot(q(260, 15) - q(150, 55)),
              kLooksNorth);
}

TEST(Correction, FadesWhereFeaturesWereNeverSeen) {
  const Scene scene;
  const CorrectionFeatures features =
      scene.Features(DaylightAt(150, 55), DaylightAt(260, 15));
  CorrectionModel model = HeightModel(0.5f);
  EXPECT_GT(cv::norm(PredictCorrection(model, features, RadFromDeg(90)).log_factor,
                     cv::NORM_INF),
            0.05);
  // The sun of the target was never lower than 30 degrees, and reached up by a tenth more
  const auto& names = CorrectionFeatureNames();
  const auto at =
      std::find(names.begin(), names.end(), "elevation_target") - names.begin();
  model.low[at] = 0.5f;
  model.high[at] = 0.6f;
  const Correction correction = PredictCorrection(model, features, RadFromDeg(90));
  const double beyond = (0.5 - std::sin(RadFromDeg(15))) / 0.1;
  EXPECT_NEAR(correction.trust(5, 5), std::exp(-4 * beyond * beyond), 1e-5);
  EXPECT_LT(cv::norm(correction.log_factor, cv::NORM_INF), 1e-6);
}

TEST(Correction, RowsAreBilinearBetweenPatches) {
  PatchGrid grid{.columns = 3, .rows = 2, .left_px = 4, .top_px = 2, .patch_px = 8};
  const cv::Mat1f image = (cv::Mat1f(2, 3) << 0, 1, 2, 10, 11, 12);
  const cv::Mat1f whole = PatchRows(grid, image, 40, 0, 24);
  EXPECT_FLOAT_EQ(whole(0, 0), 0);               // Beyond the first centre
  EXPECT_FLOAT_EQ(whole(23, 39), 12);            // Beyond the last
  EXPECT_FLOAT_EQ(whole(0, 15), 15.5f / 8 - 1);  // Column 15.5 is 11.5 beyond the edge
  const cv::Mat1f part = PatchRows(grid, image, 40, 7, 12);
  EXPECT_EQ(cv::norm(part, whole.rowRange(7, 12), cv::NORM_INF), 0);
}

TEST(Correction, TheShippedWeightsCanBeReadAndBrokenOnesAreRefused) {
  const CorrectionModel model = ReadCorrectionModel();
  EXPECT_GE(model.members.size(), 2u);

  const std::filesystem::path shipped =
      std::filesystem::path(RELIGHT_SOURCE_DIR) / "relight/ratio/correction/weights.txt";
  std::ifstream in(shipped);
  std::stringstream text;
  text << in.rdbuf();
  const std::string whole = text.str();
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "weights.txt";
  const auto refused = [&](const std::string& content) {
    std::ofstream(file) << content;
    try {
      ReadCorrectionModel(file);
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(file.string()), std::string::npos);
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused(whole));
  EXPECT_TRUE(refused(whole + " 1"));
  EXPECT_TRUE(refused("relight-correction 99" + whole.substr(whole.find('\n'))));
  for (std::size_t part = 0; part < 40; ++part)
    EXPECT_TRUE(refused(whole.substr(0, whole.size() * part / 40))) << part;
  std::string no_number = whole;
  no_number.replace(no_number.find("layers") + 12, 3, "nan");
  EXPECT_TRUE(refused(no_number));
  EXPECT_THROW(ReadCorrectionModel(file.parent_path() / "no_weights.txt"), InputError);
}

}  // namespace
}  // namespace relight
