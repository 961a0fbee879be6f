// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/color_transfer.h"

#include "relight/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace relight {
namespace {

// Sums of a thousand doubles, and matrices inverted: far from it.
constexpr double kSums = 1e-10;

// Correlated colours: a brightness that all channels share, and some of each.
cv::Mat3d RandomColors(unsigned seed, const cv::Vec3d& share) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  cv::Mat3d colors(30, 40);
  for (cv::Vec3d& color : colors) {
    const double bright = uniform(random);
    for (int c = 0; c < 3; ++c) color[c] = share[c] * bright + 0.1 * uniform(random);
  }
  return colors;
}

cv::Mat1b LeftHalf(const cv::Size& size) {
  cv::Mat1b inside(size, uchar{0});
  inside.colRange(0, size.width / 2).setTo(255);
  return inside;
}

struct Statistics {
  cv::Matx31d mean;
  cv::Matx33d covariance;
};

Statistics StatisticsOf(const cv::Mat3d& colors, const cv::Mat1b& inside) {
  Statistics s;
  double count = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int y = 0; y < colors.rows; ++y) {
      for (int x = 0; x < colors.cols; ++x) {
        if (inside(y, x) == 0) continue;
        const cv::Matx31d color(colors(y, x)[0], colors(y, x)[1], colors(y, x)[2]);
        if (pass == 0) {
          s.mean = s.mean + color;
          count += 1.0;
        } else {
          s.covariance = s.covariance + (color - s.mean) * (color - s.mean).t();
        }
      }
    }
    if (pass == 0) s.mean = s.mean * (1.0 / count);
  }
  s.covariance = s.covariance * (1.0 / count);
  return s;
}

// l-alpha-beta written out as the paper has it, apart from the code that is tested.
cv::Mat3d OpponentOf(const cv::Mat3d& colors) {
  cv::Mat3d opponent(colors.size());
  for (int y = 0; y < colors.rows; ++y) {
    for (int x = 0; x < colors.cols; ++x) {
      const cv::Vec3d& c = colors(y, x);
      const double l = std::log10(0.3811 * c[0] + 0.5783 * c[1] + 0.0402 * c[2]);
      const double m = std::log10(0.1967 * c[0] + 0.7244 * c[1] + 0.0782 * c[2]);
      const double s = std::log10(0.0241 * c[0] + 0.1288 * c[1] + 0.8444 * c[2]);
      opponent(y, x) = {(l + m + s) / std::sqrt(3.0),
                        (l + m - 2.0 * s) / std::sqrt(6.0),
                        (l - m) / std::sqrt(2.0)};
    }
  }
  return opponent;
}

const cv::Vec3d kNoon(0.4, 0.5, 0.2), kEvening(0.7, 0.3, 0.1);

TEST(ColorTransfer, ReinhardGivesMeansAndDeviationsInOpponentColours) {
  const cv::Mat3d source = RandomColors(1, kNoon), target = RandomColors(2, kEvening);
  const cv::Mat1b inside = LeftHalf(source.size());
  const Statistics got =
      StatisticsOf(OpponentOf(ReinhardTransfer(source, target, inside)), inside);
  const Statistics wanted = StatisticsOf(OpponentOf(target), inside);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(got.mean(c), wanted.mean(c), kSums);
    EXPECT_NEAR(got.covariance(c, c), wanted.covariance(c, c), kSums);
  }
}

TEST(ColorTransfer, MongeKantorovichGivesMeanAndCovariance) {
  const cv::Mat3d source = RandomColors(1, kNoon), target = RandomColors(2, kEvening);
  const cv::Mat1b inside = LeftHalf(source.size());
  const Statistics got =
      StatisticsOf(MongeKantorovichTransfer(source, target, inside), inside);
  const Statistics wanted = StatisticsOf(target, inside);
  EXPECT_LT(cv::norm(got.mean - wanted.mean), kSums);
  EXPECT_LT(cv::norm(got.covariance - wanted.covariance), kSums);
  // The histogram of a channel says nothing of how channels go together; this does
  EXPECT_GT(cv::norm(wanted.covariance - StatisticsOf(source, inside).covariance), 1e-3);
}

// Of all linear maps that do this, (E6) is the symmetric one: swapping two channels of
// both pictures swaps those of the result.
TEST(ColorTransfer, MongeKantorovichDoesNotDependOnTheOrderOfChannels) {
  const cv::Mat3d source = RandomColors(1, kNoon), target = RandomColors(2, kEvening);
  const cv::Mat1b inside = LeftHalf(source.size());
  const auto swapped = [](const cv::Mat3d& colors) {
    cv::Mat3d out = colors.clone();
    for (cv::Vec3d& color : out) std::swap(color[0], color[2]);
    return out;
  };
  const cv::Mat3d plain = MongeKantorovichTransfer(source, target, inside);
  const cv::Mat3d turned =
      MongeKantorovichTransfer(swapped(source), swapped(target), inside);
  EXPECT_LT(cv::norm(swapped(turned), plain, cv::NORM_INF), kSums);
}

TEST(ColorTransfer, TheSamePictureStaysAndNothingOutsideChanges) {
  const cv::Mat3d source = RandomColors(1, kNoon), target = RandomColors(2, kEvening);
  const cv::Mat1b inside = LeftHalf(source.size());
  for (const auto transfer : {ReinhardTransfer, MongeKantorovichTransfer}) {
    EXPECT_LT(cv::norm(transfer(source, source, inside), source, cv::NORM_INF), kSums);
    const cv::Mat3d got = transfer(source, target, inside);
    EXPECT_EQ(cv::norm(got.colRange(20, 40), source.colRange(20, 40), cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(got.colRange(0, 20), source.colRange(0, 20), cv::NORM_INF), 0.1);
  }
}

TEST(ColorTransfer, AFlatOrBlackSourceStaysFinite) {
  const cv::Mat3d target = RandomColors(2, kEvening);
  const cv::Mat1b inside = LeftHalf(target.size());
  for (const double value : {0.0, 0.5}) {
    const cv::Mat3d flat(target.size(), cv::Vec3d::all(value));
    for (const auto transfer : {ReinhardTransfer, MongeKantorovichTransfer})
      EXPECT_TRUE(cv::checkRange(transfer(flat, target, inside)));
  }
}

TEST(ColorTransfer, SizesThatDifferAndAnEmptyMaskAreRefused) {
  const cv::Mat3d source = RandomColors(1, kNoon);
  const cv::Mat1b none(source.size(), uchar{0});
  EXPECT_THROW(ReinhardTransfer(source, source, none), InputError);
  EXPECT_THROW(MongeKantorovichTransfer(source, source, cv::Mat1b(3, 3, uchar{1})),
               InputError);
}

}  // namespace
}  // namespace relight
