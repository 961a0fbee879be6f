// SPDX-License-Identifier: Apache-2.0
#include "matting/cluster_matting.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace relight {
namespace {

constexpr int kClusters = 5;  // Of each label, as the mixtures of other matting methods.
constexpr int kSteps = 32;    // Of alpha from 0 to 1.

struct Cluster {
  double share = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Eigen::Vector3d Lab(const cv::Vec3f& color) { return {color[0], color[1], color[2]}; }

// Lloyd's clustering from seeds that lie furthest apart: no chance in it.
std::vector<Cluster> Clusters(const std::vector<Eigen::Vector3d>& colors) {
  const auto nearest = [](const std::vector<Eigen::Vector3d>& centres,
                          const Eigen::Vector3d& color) {
    std::size_t best = 0;
    for (std::size_t n = 1; n < centres.size(); ++n) {
      if ((centres[n] - color).squaredNorm() < (centres[best] - color).squaredNorm()) {
        best = n;
      }
    }
    return best;
  };
  std::vector<Eigen::Vector3d> centres = {colors.front()};
  while (centres.size() < kClusters) {
    double furthest = 0;
    Eigen::Vector3d seed;
    for (const Eigen::Vector3d& color : colors) {
      const double apart = (centres[nearest(centres, color)] - color).squaredNorm();
      if (apart > furthest) seed = color;
      furthest = std::max(furthest, apart);
    }
    if (furthest < 1) break;  // One unit of LAB is not seen
    centres.push_back(seed);
  }
  std::vector<Cluster> clusters;
  for (int pass = 0; pass < 12; ++pass) {
    clusters.assign(centres.size(), {});
    for (const Eigen::Vector3d& color : colors) {
      Cluster& cluster = clusters[nearest(centres, color)];
      cluster.share += 1;
      cluster.mean += color;
    }
    for (std::size_t n = 0; n < centres.size(); ++n) {
      if (clusters[n].share > 0) centres[n] = clusters[n].mean / clusters[n].share;
    }
  }
  clusters.assign(centres.size(), {});
  for (const Eigen::Vector3d& color : colors) {
    const std::size_t n = nearest(centres, color);
    const Eigen::Vector3d from_mean = color - centres[n];
    clusters[n].share += 1;
    clusters[n].covariance += from_mean * from_mean.transpose();
  }
  for (std::size_t n = 0; n < centres.size(); ++n) {
    clusters[n].mean = centres[n];
    clusters[n].covariance /= std::max(clusters[n].share, 1.0);
    // Noise of a photo, one unit, keeps it regular
    clusters[n].covariance.diagonal().array() += 1;
    clusters[n].share /= static_cast<double>(colors.size());
  }
  std::erase_if(clusters, [](const Cluster& cluster) { return cluster.share == 0; });
  return clusters;
}

// Colours of one label, some tens of thousands, evenly taken.
std::vector<Eigen::Vector3d> ColorsOf(const cv::Mat3f& lab,
                                      const cv::Mat1b& trimap,
                                      std::uint8_t label) {
  const std::int64_t stride = cv::countNonZero(trimap == label) / 30000 + 1;
  std::vector<Eigen::Vector3d> colors;
  std::int64_t n = 0;
  for (int y = 0; y < lab.rows; ++y) {
    for (int x = 0; x < lab.cols; ++x) {
      if (trimap(y, x) == label && n++ % stride == 0) colors.push_back(Lab(lab(y, x)));
    }
  }
  return colors;
}

// A Gaussian between two clusters: log of its weight and norm, mean, inverse covariance.
struct Between {
  float log_weight = 0;
  Eigen::Vector3f mean;
  Eigen::Matrix3f precision;
};

// All pairs at alpha = step / kSteps.
std::vector<Between> PairsAt(const std::vector<Cluster>& foreground,
                             const std::vector<Cluster>& background,
                             int step) {
  const double alpha = static_cast<double>(step) / kSteps;
  std::vector<Between> pairs;
  for (const Cluster& f : foreground) {
    for (const Cluster& b : background) {
      const Eigen::Matrix3d covariance =
          alpha * f.covariance + (1 - alpha) * b.covariance;
      const double weight = f.share * b.share / std::sqrt(covariance.determinant());
      pairs.push_back({static_cast<float>(std::log(weight)),
                       (alpha * f.mean + (1 - alpha) * b.mean).cast<float>(),
                       covariance.inverse().cast<float>()});
    }
  }
  return pairs;
}

using PairTable = std::array<std::vector<Between>, kSteps + 1>;

// The alpha of the likeliest step, between its neighbours by a parabola.
float LikeliestAlpha(const PairTable& table, const Eigen::Vector3f& color) {
  std::array<float, kSteps + 1> log_likelihood{};
  for (int step = 0; step <= kSteps; ++step) {
    float best = -std::numeric_limits<float>::infinity(), sum = 0;
    for (const Between& pair : table[step]) {
      const Eigen::Vector3f from_mean = color - pair.mean;
      const float log_p =
          pair.log_weight - 0.5f * from_mean.dot(pair.precision * from_mean);
      sum =
          log_p > best ? 1 + sum * std::exp(best - log_p) : sum + std::exp(log_p - best);
      best = std::max(best, log_p);
    }
    log_likelihood[step] = best + std::log(sum);
  }
  const auto most =
      static_cast<int>(std::max_element(log_likelihood.begin(), log_likelihood.end()) -
                       log_likelihood.begin());
  float offset = 0;
  if (most > 0 && most < kSteps) {
    const float left = log_likelihood[most - 1], right = log_likelihood[most + 1];
    const float bend = left - 2 * log_likelihood[most] + right;
    if (bend < 0) offset = std::clamp(0.5f * (left - right) / bend, -0.5f, 0.5f);
  }
  return (static_cast<float>(most) + offset) / kSteps;
}

}  // namespace

cv::Mat1f EstimateClusterMatte(const cv::Mat3f& display,
                               const cv::Mat1b& trimap,
                               const Progress& progress) {
  if (display.size() != trimap.size()) {
    throw InputError("the trimap is " + std::to_string(trimap.cols) + " x " +
                     std::to_string(trimap.rows) + " pixels, the photo " +
                     std::to_string(display.cols) + " x " + std::to_string(display.rows) +
                     "; make the trimap at the photo's size");
  }
  CheckTrimap(trimap);
  cv::Mat1f alpha(trimap.size(), 0.0f);
  alpha.setTo(1.0f, trimap == kTrimapForeground);
  if (cv::countNonZero(trimap == kTrimapUnknown) == 0) return alpha;
  progress.Report(0);
  cv::Mat3f lab;
  cv::cvtColor(display, lab, cv::COLOR_RGB2Lab);
  const auto foreground = Clusters(ColorsOf(lab, trimap, kTrimapForeground));
  progress.Report(0.05);
  const auto background = Clusters(ColorsOf(lab, trimap, kTrimapBackground));
  PairTable table;
  for (int step = 0; step <= kSteps; ++step) {
    table[step] = PairsAt(foreground, background, step);
  }
  ParallelRanges(
      alpha.rows,
      4,
      [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
          for (int x = 0; x < alpha.cols; ++x) {
            if (trimap(y, x) != kTrimapUnknown) continue;
            alpha(y, x) = LikeliestAlpha(table, Lab(lab(y, x)).cast<float>());
          }
        }
      },
      progress.Part(0.1, 1));
  return alpha;
}

}  // namespace relight
