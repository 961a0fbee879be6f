// SPDX-License-Identifier: Apache-2.0
#include "matting/automatic_trimap.h"

#include "matting/closed_form_matting.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <chrono>
#include <cstdio>
#include <random>
#include <string>

namespace relight {
namespace {

// A picture with its true matte.
struct MadePhoto {
  cv::Mat3f display;
  cv::Mat1f alpha;
};

constexpr int kHorizon = 240;

// A crown of leaves of 5 pixels with holes, on a trunk, before a gradient of sky and over
// lawn with the tree's shadow; slightly blurred and noisy as a photograph is. With
// `hanging`, single leaves hang from it to below the horizon, two pixels apart.
MadePhoto MadeTree(cv::Size size = {300, 320}, unsigned seed = 1, bool hanging = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  MadePhoto photo{cv::Mat3f(size), cv::Mat1f(size, 0.0f)};
  cv::Mat3f tree(size, cv::Vec3f(0.25f, 0.18f, 0.12f));
  for (int y = 0; y < size.height; ++y) {
    const float t = static_cast<float>(y) / kHorizon;
    const cv::Vec3f sky(0.35f + 0.4f * t, 0.5f + 0.3f * t, 0.8f + 0.1f * t);
    photo.display.row(y).setTo(y <= kHorizon ? sky : cv::Vec3f(0.6f, 0.65f, 0.3f));
  }
  const int middle = size.width / 2;
  cv::ellipse(photo.display,
              {middle, 295},
              {90, 10},
              0,
              0,
              360,
              cv::Scalar(0.15, 0.2, 0.08),
              cv::FILLED);
  cv::rectangle(photo.alpha, {middle - 9, 130}, {middle + 9, 295}, 1.0, cv::FILLED);
  const auto add_leaf = [&](const cv::Point& at, int radius = 3) {
    const double light = 0.6 + 0.8 * uniform(random);
    cv::circle(photo.alpha, at, radius, 1.0, cv::FILLED);
    cv::circle(tree,
               at,
               radius,
               cv::Scalar(0.15 * light, 0.3 * light, 0.08 * light),
               cv::FILLED);
  };
  for (int leaf = 0; leaf < 2500; ++leaf) {
    const double angle = 6.2832 * uniform(random),
                 radius = 95 * std::sqrt(uniform(random));
    const cv::Point at(cvRound(middle + radius * std::cos(angle)),
                       cvRound(125 + radius * std::sin(angle)));
    if (cv::norm(at - cv::Point(middle - 40, 100)) < 22) continue;  // A hole
    add_leaf(at);
  }
  for (const int column : {-70, -45, 38, 62}) {
    for (int y = 190; hanging && y < 270; y += 7) add_leaf({middle + column, y}, 2);
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (photo.alpha(y, x) > 0) photo.display(y, x) = tree(y, x);
    }
  }
  cv::GaussianBlur(photo.display, photo.display, {0, 0}, 0.6);
  cv::GaussianBlur(photo.alpha, photo.alpha, {0, 0}, 0.6);
  std::normal_distribution<float> noise(0.0f, 0.004f);
  for (cv::Vec3f& pixel : photo.display) {
    for (int i = 0; i < 3; ++i) pixel[i] += noise(random);
  }
  return photo;
}

// Share of the pixels labelled `label` whose true alpha lies off by more than a half.
double WrongShare(const cv::Mat1b& trimap, const cv::Mat1f& alpha, std::uint8_t label) {
  int wrong = 0, all = 0;
  for (int y = 0; y < trimap.rows; ++y) {
    for (int x = 0; x < trimap.cols; ++x) {
      if (trimap(y, x) != label) continue;
      ++all;
      if ((alpha(y, x) > 0.5f) != (label == kTrimapForeground)) ++wrong;
    }
  }
  return all == 0 ? 0 : static_cast<double>(wrong) / all;
}

TEST(AutomaticTrimap, FindsATreeBeforeTheSky) {
  const MadePhoto photo = MadeTree();
  const AutomaticTrimap result = EstimateTrimap(photo.display);
  CheckTrimap(result.trimap);
  EXPECT_GT(result.confidence, 0.8);
  EXPECT_TRUE(result.doubts.empty());
  EXPECT_FALSE(result.models.Empty());
  EXPECT_TRUE(IsBeforeSky(photo.display, result.trimap));
  // Open sky, the hole in the crown and the lawn are background, the trunk is tree
  EXPECT_EQ(result.trimap(10, 10), kTrimapBackground);
  EXPECT_EQ(result.trimap(200, 20), kTrimapBackground);
  EXPECT_EQ(result.trimap(100, 110), kTrimapBackground);
  EXPECT_EQ(result.trimap(315, 40), kTrimapBackground);
  EXPECT_EQ(result.trimap(230, 150), kTrimapForeground);
  EXPECT_EQ(result.trimap(270, 150), kTrimapForeground);
  // What is sure is right: one in a thousand is a leaf alone in the sky, or the rim of
  // the shadow at the foot
  EXPECT_LT(WrongShare(result.trimap, photo.alpha, kTrimapBackground), 0.001);
  EXPECT_LT(WrongShare(result.trimap, photo.alpha, kTrimapForeground), 0.02);
}

TEST(AutomaticTrimap, KeepsLeavesThatHangBeforeTheGround) {
  const MadePhoto photo = MadeTree({300, 320}, 1, /*hanging=*/true);
  const AutomaticTrimap found = EstimateTrimap(photo.display);
  // Below the horizon and beside the trunk; what is unknown there the matting decides
  int leaves = 0, lost = 0, ground = 0, unsure = 0;
  for (int y = kHorizon + 4; y < 275; ++y) {
    for (int x = 0; x < 300; ++x) {
      if (std::abs(x - 150) < 20) continue;
      const std::uint8_t label = found.trimap(y, x);
      if (photo.alpha(y, x) > 0.9f) {
        ++leaves;
        lost += label == kTrimapBackground ? 1 : 0;
      } else if (photo.alpha(y, x) < 0.02f) {
        ++ground;
        unsure += label != kTrimapBackground ? 1 : 0;
      }
    }
  }
  EXPECT_GT(leaves, 50);
  EXPECT_LT(lost, leaves / 20);
  EXPECT_LT(unsure, ground / 4);  // Four bands of 15 pixels in 260
}

TEST(AutomaticTrimap, StrokesHoldAndAreTheModelsOfOtherPhotos) {
  // A brick tower beside the tree stands before the sky as the tree does
  const auto with_tower = [](unsigned seed) {
    MadePhoto photo = MadeTree({400, 320}, seed);
    cv::rectangle(
        photo.display, {300, 60}, {360, 270}, cv::Scalar(0.6, 0.25, 0.2), cv::FILLED);
    photo.alpha.colRange(300, 361).setTo(0.0f);
    return photo;
  };
  const MadePhoto first = with_tower(1), second = with_tower(2);
  cv::Mat1b strokes(first.display.size(), kTrimapUnknown);
  strokes(cv::Rect(310, 80, 40, 150)).setTo(kTrimapBackground);
  strokes(cv::Rect(20, 260, 60, 4)).setTo(kTrimapBackground);
  strokes(cv::Rect(20, 20, 60, 4)).setTo(kTrimapBackground);
  strokes(cv::Rect(170, 70, 60, 4)).setTo(kTrimapForeground);
  strokes(cv::Rect(198, 200, 4, 80)).setTo(kTrimapForeground);
  const AutomaticTrimap taught = EstimateTrimap(first.display, strokes);
  for (int y = 0; y < strokes.rows; ++y) {
    for (int x = 0; x < strokes.cols; ++x) {
      if (strokes(y, x) != kTrimapUnknown) {
        ASSERT_EQ(taught.trimap(y, x), strokes(y, x));
      }
    }
  }
  const cv::Rect tower(305, 65, 50, 170);
  const auto in_tower = [&](const AutomaticTrimap& result) {
    return cv::countNonZero(result.trimap(tower) == kTrimapForeground) /
           static_cast<double>(tower.area());
  };
  EXPECT_LT(in_tower(taught), 0.02);
  EXPECT_GT(in_tower(EstimateTrimap(second.display)), 0.5);
  const AutomaticTrimap like = EstimateTrimap(second.display, {}, &taught.models);
  EXPECT_LT(in_tower(like), 0.02);
  EXPECT_LT(WrongShare(like.trimap, second.alpha, kTrimapForeground), 0.03);
  EXPECT_EQ(like.trimap(230, 200), kTrimapForeground);
}

TEST(AutomaticTrimap, IsTheSameForAnyNumberOfThreadsAndCalls) {
  const MadePhoto photo = MadeTree({900, 1100});
  cv::setRNGSeed(77);
  const std::uint64_t state = cv::theRNG().state;
  SetThreadCount(1);
  const AutomaticTrimap one = EstimateTrimap(photo.display);
  SetThreadCount(2);
  const AutomaticTrimap two = EstimateTrimap(photo.display);
  SetThreadCount(0);
  EXPECT_EQ(cv::norm(one.trimap, two.trimap, cv::NORM_INF), 0.0);
  EXPECT_EQ(one.confidence, two.confidence);
  EXPECT_EQ(cv::norm(one.models.foreground, two.models.foreground, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(one.models.background, two.models.background, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::theRNG().state, state);
}

TEST(AutomaticTrimap, WithoutSkyAllIsUnknownUntilAStroke) {
  // Leaves all over
  cv::Mat3f display(200, 200);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0.2f, 0.5f);
  for (cv::Vec3f& pixel : display) {
    const float light = uniform(random);
    pixel = {0.6f * light, light, 0.3f * light};
  }
  display.colRange(120, 200) = cv::Vec3f(0.5f, 0.3f, 0.2f);  // A wall
  const AutomaticTrimap result = EstimateTrimap(display);
  EXPECT_EQ(cv::countNonZero(result.trimap != kTrimapUnknown), 0);
  EXPECT_EQ(result.confidence, 0.0);
  ASSERT_EQ(result.doubts.size(), 1u);
  EXPECT_NE(result.doubts[0].find("stroke"), std::string::npos);

  cv::Mat1b strokes(display.size(), kTrimapUnknown);
  strokes(cv::Rect(20, 50, 60, 5)).setTo(kTrimapForeground);
  strokes(cv::Rect(150, 50, 20, 5)).setTo(kTrimapBackground);
  const AutomaticTrimap stroked = EstimateTrimap(display, strokes);
  EXPECT_EQ(stroked.trimap(150, 60), kTrimapForeground);
  EXPECT_EQ(stroked.trimap(150, 180), kTrimapBackground);
  EXPECT_FALSE(IsBeforeSky(display, stroked.trimap));
}

TEST(AutomaticTrimap, TakesPicturesOfAnySize) {
  for (const cv::Size size : {cv::Size(1, 1),
                              cv::Size(2, 3),
                              cv::Size(3, 20000),
                              cv::Size(20000, 3),
                              cv::Size(40, 30)}) {
    for (const float light : {0.0f, 0.3f, 1.0f}) {
      const cv::Mat3f flat(size, cv::Vec3f::all(light));
      const AutomaticTrimap result = EstimateTrimap(flat);
      EXPECT_EQ(result.trimap.size(), size);
      EXPECT_EQ(cv::countNonZero(result.trimap == kTrimapForeground), 0);
      EXPECT_LT(result.confidence, 0.5);
      EXPECT_FALSE(result.doubts.empty());
      cv::Mat1b strokes(size, kTrimapForeground);
      strokes(0, 0) = kTrimapBackground;
      EXPECT_EQ(cv::norm(EstimateTrimap(flat, strokes).trimap, strokes, cv::NORM_INF), 0);
    }
  }
}

TEST(AutomaticTrimap, RefusesWhatItCannotUse) {
  const cv::Mat3f display(20, 20, cv::Vec3f::all(0.5f));
  EXPECT_THROW(EstimateTrimap(cv::Mat3f()), InputError);
  EXPECT_THROW(EstimateTrimap(display, cv::Mat1b(10, 20, kTrimapUnknown)), InputError);
  EXPECT_THROW(EstimateTrimap(display, cv::Mat1b(20, 20, std::uint8_t{7})), InputError);
  EXPECT_THROW(EstimateTrimap(display, {}, nullptr, {.sky_tolerance = -1}), OptionError);
  EXPECT_THROW(
      EstimateTrimap(MadeTree().display, {}, nullptr, {}, [](double) { return false; }),
      Cancelled);
}

// Rendered captures with true alphas: the matte from the automatic trimap.
TEST(AutomaticTrimap, IsGoodEnoughToMatteWith) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/photos");
  double sum = 0;
  for (const std::string name : {"maple/photos/view_00",
                                 "maple/photos_camera/view_06",
                                 "birch/photos/view_03",
                                 "birch/photos/view_07"}) {
    const std::filesystem::path photo = tests::SharedPath("data/" + name + ".jpg");
    const cv::Mat3f linear = ReadPhoto(photo).pixels;
    const auto begin = std::chrono::steady_clock::now();
    const AutomaticTrimap result = EstimateTrimap(DisplayFromLinear(linear));
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const cv::Mat1f matte = EstimateMatte(linear, result.trimap).alpha;
    const cv::Mat1f truth = ReadMatte(photo.parent_path().parent_path() / "alpha" /
                                      (photo.stem().string() + ".png"));
    const cv::Rect box = cv::boundingRect(truth > 0.02f);
    const double error = cv::norm(matte(box), truth(box), cv::NORM_L1) / box.area();
    std::printf("%s mean absolute error %.4f, confidence %.2f, %.2f s\n",
                name.c_str(),
                error,
                result.confidence,
                seconds);
    // From trimaps that were made from the true alphas 0.03 to 0.04
    EXPECT_LT(error, 0.06) << name;
    EXPECT_GT(result.confidence, 0.5) << name;
    sum += error;
  }
  EXPECT_LT(sum / 4, 0.05);
}

}  // namespace
}  // namespace relight
