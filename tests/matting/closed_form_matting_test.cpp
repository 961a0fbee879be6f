// SPDX-License-Identifier: Apache-2.0
#include "matting/closed_form_matting.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace relight {
namespace {

cv::Mat3f RandomImage(cv::Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  cv::Mat3f image(size);
  for (cv::Vec3f& pixel : image)
    pixel = {uniform(random), uniform(random), uniform(random)};
  return image;
}

// Background on the left, foreground on the right, unknown between.
cv::Mat1b BandTrimap(cv::Size size, int first, int last) {
  cv::Mat1b trimap(size, kTrimapUnknown);
  trimap.colRange(0, first).setTo(kTrimapBackground);
  trimap.colRange(last, size.width).setTo(kTrimapForeground);
  return trimap;
}

// Two colours mixed: every window lies on one colour line, where alpha is one affine
// function of colour, and (M1) is met by the mixture itself but for eps.
TEST(ClosedFormMatting, FindsTheMixtureOfTwoColours) {
  const cv::Size size(60, 40);
  const cv::Vec3f leaf(0.2f, 0.5f, 0.1f), sky(0.6f, 0.7f, 0.9f);
  cv::Mat1f truth(size);
  cv::Mat3f image(size);
  cv::Mat1b trimap(size, kTrimapUnknown);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool known = x < 10 || x >= 50, solid = x % 10 >= 5;
      const double wave = 0.5 + 0.5 * std::sin(0.5 * x + 0.3 * y);
      truth(y, x) = known ? (solid ? 1.0f : 0.0f) : static_cast<float>(wave);
      image(y, x) = truth(y, x) * leaf + (1 - truth(y, x)) * sky;
      if (known) trimap(y, x) = solid ? kTrimapForeground : kTrimapBackground;
    }
  }
  const MatteEstimate estimate =
      EstimateMatte(image, trimap, {.prior_weight = 0, .relative_residual = 1e-11});
  EXPECT_EQ(estimate.summary.unknown_pixels, 40 * 40);
  // eps pulls every window's slope towards 0: the further from what is known the more. 1
  // % is what 40 columns at eps = 1e-7 leave; ten times eps leaves more
  const double error = cv::norm(estimate.alpha, truth, cv::NORM_INF);
  EXPECT_LT(error, 0.02);
  const MatteEstimate looser = EstimateMatte(
      image, trimap, {.epsilon = 1e-6, .prior_weight = 0, .relative_residual = 1e-11});
  EXPECT_GT(cv::norm(looser.alpha, truth, cv::NORM_INF), error);
}

TEST(ClosedFormMatting, KeepsWhatTheTrimapKnows) {
  const cv::Size size(50, 30);
  const cv::Mat1b trimap = BandTrimap(size, 15, 35);
  const cv::Mat1f alpha = EstimateMatte(RandomImage(size, 5), trimap).alpha;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      // Beyond the system's margin exactly; inside it as lambda = 100 holds it
      if (x < 13) {
        EXPECT_EQ(alpha(y, x), 0.0f);
      }
      if (x >= 37) {
        EXPECT_EQ(alpha(y, x), 1.0f);
      }
      if (x < 15) {
        EXPECT_NEAR(alpha(y, x), 0.0f, 0.02);
      }
      if (x >= 35) {
        EXPECT_NEAR(alpha(y, x), 1.0f, 0.02);
      }
      EXPECT_GE(alpha(y, x), 0.0f);
      EXPECT_LE(alpha(y, x), 1.0f);
    }
  }
}

TEST(ClosedFormMatting, IsTheSameForAnyNumberOfThreads) {
  const cv::Size size(300, 240);
  const cv::Mat3f image = RandomImage(size, 7);
  SetThreadCount(1);
  const cv::Mat1f one = EstimateMatte(image, BandTrimap(size, 80, 200)).alpha;
  SetThreadCount(2);
  const cv::Mat1f two = EstimateMatte(image, BandTrimap(size, 80, 200)).alpha;
  SetThreadCount(0);
  EXPECT_EQ(cv::norm(one, two, cv::NORM_INF), 0.0);
}

TEST(ClosedFormMatting, RefusesWhatItCannotSolve) {
  const cv::Mat3f image = RandomImage({20, 20}, 1);
  EXPECT_THROW(EstimateMatte(image, cv::Mat1b(10, 20, kTrimapUnknown)), InputError);
  cv::Mat1b no_foreground(20, 20, kTrimapUnknown);
  no_foreground.row(0).setTo(kTrimapBackground);
  EXPECT_THROW(EstimateMatte(image, no_foreground), InputError);
  EXPECT_THROW(EstimateMatte(image, BandTrimap({20, 20}, 5, 15), {.lambda = -1}),
               OptionError);
  EXPECT_THROW(
      EstimateMatte(image, BandTrimap({20, 20}, 5, 15), {}, [](double) { return false; }),
      Cancelled);
  cv::Mat3f no_number = image.clone();
  no_number(3, 4)[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(EstimateMatte(no_number, BandTrimap({20, 20}, 5, 15)), InputError);
}

TEST(ClosedFormMatting, TakesPhotosOfAnyShape) {
  for (const cv::Size size : {cv::Size(1, 9), cv::Size(9, 2), cv::Size(3, 2000)}) {
    cv::Mat1b trimap(size, kTrimapUnknown);
    trimap(0, 0) = kTrimapBackground;
    trimap(size.height - 1, size.width - 1) = kTrimapForeground;
    const MatteEstimate estimate = EstimateMatte(RandomImage(size, 11), trimap);
    ASSERT_EQ(estimate.alpha.size(), size);
    EXPECT_EQ(estimate.summary.unknown_pixels, size.area() - 2);
    EXPECT_EQ(estimate.alpha(0, 0), 0.0f);
    EXPECT_EQ(estimate.alpha(size.height - 1, size.width - 1), 1.0f);
    EXPECT_TRUE(cv::checkRange(estimate.alpha, true, nullptr, 0.0, 1.0 + 1e-6));
  }
  const cv::Mat1b known(1, 1, kTrimapForeground);
  EXPECT_EQ(EstimateMatte(RandomImage({1, 1}, 1), known).alpha(0, 0), 1.0f);
}

// A cancelled run has to stop soon: reports come all the way, none of them late.
TEST(ClosedFormMatting, ReportsOftenAndForwards) {
  const cv::Size size(900, 700);
  using Clock = std::chrono::steady_clock;
  auto last = Clock::now();
  double done = 0, longest_s = 0;
  int reports = 0;
  EstimateMatte(RandomImage(size, 3), BandTrimap(size, 100, 800), {}, [&](double now) {
    EXPECT_GE(now, done - 1e-9);
    done = now;
    const auto here = Clock::now();
    longest_s = std::max(longest_s, std::chrono::duration<double>(here - last).count());
    last = here;
    ++reports;
    return true;
  });
  std::printf("%d reports, %.3f s between two at most\n", reports, longest_s);
  EXPECT_GT(reports, 100);
  EXPECT_LT(longest_s, 2.0);  // 0.2 s on an idle machine; benchmark_matting prints it
}

TEST(ClosedFormMatting, AllKnownIsTheTrimapItself) {
  const cv::Mat1b trimap = BandTrimap({20, 20}, 10, 10);
  const cv::Mat1f alpha = EstimateMatte(RandomImage({20, 20}, 2), trimap).alpha;
  for (int x = 0; x < 20; ++x) EXPECT_EQ(alpha(7, x), x < 10 ? 0.0f : 1.0f);
}

// Photographs with true alphas, beside the figures of another program of the same method
// (PyMatting 1.1.15, README of shared data/matting).
TEST(ClosedFormMatting, IsAsGoodAsAnotherProgramOfTheMethod) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/matting");
  const std::map<std::string, double> theirs = {{"GT01", .00556},
                                                {"GT02", .05176},
                                                {"GT04", .02305},
                                                {"GT05", .01846},
                                                {"GT07", .00810},
                                                {"GT08", .01870},
                                                {"GT11", .01251},
                                                {"GT14", .00300},
                                                {"GT17", .00350},
                                                {"GT20", .00297},
                                                {"GT22", .00265},
                                                {"GT24", .01804},
                                                {"GT27", .03037}};
  double our_sum = 0, prior_sum = 0, their_sum = 0;
  for (const auto& [name, mse] : theirs) {
    std::filesystem::path image, trimap, truth;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             tests::SharedPath("data/matting"))) {
      const std::string path = entry.path().string();
      if (entry.path().stem() != name) continue;
      if (path.find("trimap") != std::string::npos) {
        trimap = entry.path();
      } else if (path.find("alpha") != std::string::npos ||
                 path.find("gt") != std::string::npos) {
        truth = entry.path();
      } else {
        image = entry.path();
      }
    }
    ASSERT_FALSE(image.empty() || trimap.empty() || truth.empty()) << name;
    const cv::Mat1b labels = TrimapFromGray(ReadMatte(trimap));
    const auto begin = std::chrono::steady_clock::now();
    // The method alone, on display values as that program takes them
    const cv::Mat3f linear = ReadPhoto(image).pixels;
    const MatteEstimate estimate =
        EstimateMatte(DisplayFromLinear(linear), labels, {.prior_weight = 0});
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const cv::Mat1f alpha = ReadMatte(truth);
    const auto error = [&](const cv::Mat1f& matte) {
      double sum = 0;
      for (int y = 0; y < alpha.rows; ++y) {
        for (int x = 0; x < alpha.cols; ++x) {
          if (labels(y, x) == kTrimapUnknown)
            sum += std::pow(matte(y, x) - alpha(y, x), 2);
        }
      }
      return sum / static_cast<double>(estimate.summary.unknown_pixels);
    };
    const double ours = error(estimate.alpha);
    const double with_prior = error(EstimateMatte(linear, labels).alpha);
    std::printf("%s MSE %.5f (theirs %.5f), %d iterations, %.1f s; default %.5f\n",
                name.c_str(),
                ours,
                mse,
                estimate.summary.iterations,
                seconds,
                with_prior);
    our_sum += ours;
    prior_sum += with_prior;
    their_sum += mse;
  }
  // The same minimum, found to other residuals
  EXPECT_LT(our_sum, their_sum);
  // And the colour prior pays
  std::printf("mean %.5f (theirs %.5f), default %.5f\n",
              our_sum / 13,
              their_sum / 13,
              prior_sum / 13);
  EXPECT_LT(prior_sum, 0.7 * their_sum);
}

}  // namespace
}  // namespace relight
