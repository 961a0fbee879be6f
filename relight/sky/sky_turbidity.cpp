// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sky_turbidity.h"

#include "relight/base/angles.h"
#include "relight/sky/preetham_sky.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace relight {
namespace {

constexpr double kLowest_rad = RadFromDeg(6);
constexpr double kNearestToSun_rad = RadFromDeg(15);
constexpr double kColorError = 0.10;     // s_c
constexpr double kGradientError = 0.30;  // s_y
constexpr double kPriorMean = 3.0, kPriorSpread = 0.40;
constexpr double kIndependent = 4.0;                          // n
constexpr double kMostDeepened = 3.0, kDeepenedSpread = 0.7;  // Of g, and s_g.
constexpr int kTurbidities = 90;  // From 2 to 10, evenly in ln T.

constexpr std::size_t kFewestSamples = 24;
constexpr double kWidestSpread = 0.2;
constexpr double kWorstMisfit = 0.15;
constexpr double kHaziest = 7.5;

double Huber(double x) {
  const double size = std::abs(x);
  return size <= 1 ? x * x : 2 * size - 1;
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// In Rec.2020's primaries, which hold deeper colours.                        [BT.2087]
Eigen::Array3d Wide(const Eigen::Array3d& rec709) {
  Eigen::Matrix3d rec2020_from_rec709;
  rec2020_from_rec709 << 0.6274, 0.3293, 0.0433,  //
      0.0691, 0.9195, 0.0114,                     //
      0.0164, 0.0880, 0.8956;
  return (rec2020_from_rec709 * rec709.matrix()).array();
}

// ln R/G, ln B/G, ln Y; what is outside the primaries is held inside.
Eigen::Array3d LogsOf(const Eigen::Array3d& rec709, bool may_be_deepened) {
  const double luminance = std::max(Luminance(rec709), 1e-9);
  const Eigen::Array3d rgb = may_be_deepened ? Wide(rec709) : rec709;
  const Eigen::Array3d inside = rgb.max(0.01 * luminance);
  return {std::log(inside[0] / inside[1]),
          std::log(inside[2] / inside[1]),
          std::log(luminance)};
}

struct Fit {
  double cost = 0.0;    // Mean over the samples.
  double misfit = 0.0;  // Root mean square of r and b.
  double deepened = 1.0;
};

// (K9), with (K11) where the camera may have deepened the colours.
Fit FitAt(double turbidity,
          std::span<const SkySample> samples,
          const std::vector<Eigen::Array3d>& logs,
          bool may_be_deepened) {
  std::vector<Eigen::Array3d> model;
  // The sun stands still in a photo, and often from one to the next
  std::optional<PreethamSky> sky;
  Eigen::Vector3d sun = Eigen::Vector3d::Zero();
  for (const SkySample& sample : samples) {
    if (!sky || sun != sample.sun_in_world) {
      sun = sample.sun_in_world;
      sky.emplace(sun, PreethamSkyOptions{.turbidity = turbidity});
    }
    model.push_back(LogsOf((*sky)(sample.direction_in_world), may_be_deepened));
  }
  Fit fit;
  if (may_be_deepened) {
    double both = 0, of_model = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      both += (logs[i].head<2>() * model[i].head<2>()).sum();
      of_model += model[i].head<2>().square().sum();
    }
    fit.deepened = std::clamp(both / std::max(of_model, 1e-9), 1.0, kMostDeepened);
  }
  std::map<int, std::pair<double, int>> level;  // Of each photo: sum, count.
  for (std::size_t i = 0; i < samples.size(); ++i) {
    auto& [sum, count] = level[samples[i].photo];
    sum += logs[i][2] - model[i][2];
    ++count;
  }
  const auto n = static_cast<double>(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& [sum, count] = level[samples[i].photo];
    const double r = logs[i][0] - fit.deepened * model[i][0];
    const double b = logs[i][1] - fit.deepened * model[i][1];
    const double y = logs[i][2] - model[i][2] - sum / count;
    fit.cost +=
        (Huber(r / kColorError) + Huber(b / kColorError) + Huber(y / kGradientError)) / n;
    fit.misfit += (r * r + b * b) / (2 * n);
  }
  fit.misfit = std::sqrt(fit.misfit);
  return fit;
}

// The whole posterior, on a grid.
TurbidityEstimate EstimateFrom(std::span<const SkySample> samples, bool may_be_deepened) {
  std::vector<Eigen::Array3d> logs;
  for (const SkySample& sample : samples)
    logs.push_back(LogsOf(sample.color, may_be_deepened));
  std::vector<double> log_turbidity, log_posterior;
  for (int i = 0; i < kTurbidities; ++i) {
    const double at =
        std::log(2.0) + (std::log(10.0) - std::log(2.0)) * i / (kTurbidities - 1);
    const double turbidity = std::min(std::exp(at), 10.0);  // Not beyond by rounding
    const double prior = (at - std::log(kPriorMean)) / kPriorSpread;
    const Fit fit = FitAt(turbidity, samples, logs, may_be_deepened);
    const double deepened = std::log(fit.deepened) / kDeepenedSpread;
    log_turbidity.push_back(at);
    log_posterior.push_back(-0.5 * kIndependent * fit.cost - 0.5 * prior * prior -
                            0.5 * deepened * deepened);
  }
  const double highest = *std::max_element(log_posterior.begin(), log_posterior.end());
  double total = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < log_turbidity.size(); ++i) {
    const double weight = std::exp(log_posterior[i] - highest);
    total += weight;
    mean += weight * log_turbidity[i];
    square += weight * log_turbidity[i] * log_turbidity[i];
  }
  mean /= total;
  TurbidityEstimate estimate;
  estimate.turbidity = std::clamp(std::exp(mean), 2.0, 10.0);
  estimate.spread = std::sqrt(std::max(0.0, square / total - mean * mean));
  const Fit fit = FitAt(estimate.turbidity, samples, logs, may_be_deepened);
  estimate.misfit = fit.misfit;
  estimate.deepened = fit.deepened;
  return estimate;
}

}  // namespace

TurbidityEstimate TurbidityFromSky(std::span<const SkySample> samples) {
  std::vector<SkySample> used;
  std::set<int> photos;
  for (const SkySample& sample : samples) {
    const bool shines = Luminance(sample.color) > 0 && sample.sun_in_world.z() > 0;
    if (!shines || ElevationOf(sample.direction_in_world) < kLowest_rad ||
        AngleBetween(sample.direction_in_world, sample.sun_in_world) <
            kNearestToSun_rad) {
      continue;
    }
    used.push_back(sample);
    photos.insert(sample.photo);
  }
  const auto counted = [&](TurbidityEstimate estimate) {
    estimate.samples = static_cast<int>(used.size());
    estimate.photos = static_cast<int>(photos.size());
    return estimate;
  };
  if (used.size() < kFewestSamples) {
    TurbidityEstimate none = counted({});
    none.doubt = "they show too little open sky";
    return none;
  }
  TurbidityEstimate estimate = counted(EstimateFrom(used, false));
  if (estimate.misfit > kWorstMisfit) {
    const TurbidityEstimate deep = counted(EstimateFrom(used, true));
    if (deep.misfit <= kWorstMisfit && deep.deepened > 1) estimate = deep;
  }
  if (estimate.misfit > kWorstMisfit) {
    estimate.doubt = "their sky is not the colour of a clear one";
  } else if (estimate.turbidity > kHaziest) {
    estimate.doubt = "haze and thin cloud look alike in them";
  } else if (estimate.spread > kWidestSpread) {
    estimate.doubt = "their sky tells too little";
  }
  estimate.sure = estimate.doubt.empty();
  return estimate;
}

}  // namespace relight
