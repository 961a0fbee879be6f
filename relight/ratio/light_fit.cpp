// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/light_fit.h"

#include "relight/base/error.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace relight {
namespace {

constexpr double kPrior = 0.3;   // d_0
constexpr double kWidest = 1.2;  // Four deviations of the prior
constexpr std::size_t kFewest = 8;

double Prior(double log_value) { return log_value * log_value / (2 * kPrior * kPrior); }

// Says less than the prior when less than half of the curvature is the data's.
FittedNumber Number(double log_value, double curvature) {
  const double of_prior = 1 / (kPrior * kPrior);
  const double whole = std::max(curvature, of_prior);
  return {log_value, 1 / std::sqrt(whole), whole < 2 * of_prior};
}

// Weighted variance of ln P - ln(A + e^k B).
double Variance(const ShadingPatches& p, double log_sky) {
  const double sky = std::exp(log_sky);
  double sum = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < p.photo.size(); ++i) {
    const double left = std::log(p.photo[i] / (p.sun[i] + sky * p.rest[i]));
    sum += p.weight[i];
    mean += p.weight[i] * left;
    square += p.weight[i] * left * left;
  }
  mean /= sum;
  return std::max(1e-12, square / sum - mean * mean);
}

}  // namespace

ShadingPatches ShadingOf(const IrradianceImage& input,
                         const cv::Mat3f& colors,
                         const cv::Mat1f& alpha) {
  Require(colors.size() == alpha.size(), "colours and matte have one size");
  ShadingPatches patches;
  const cv::Size size = input.sun.size();
  cv::Mat1f cover;
  cv::resize(alpha, cover, size, 0, 0, cv::INTER_AREA);
  cv::Mat3f premultiplied(colors.size()), photo;
  for (int row = 0; row < colors.rows; ++row) {
    for (int column = 0; column < colors.cols; ++column) {
      premultiplied(row, column) = alpha(row, column) * colors(row, column);
    }
  }
  cv::resize(premultiplied, photo, size, 0, 0, cv::INTER_AREA);
  const cv::Rect box = cv::boundingRect(cv::Mat1b(cover > 0.5f));
  if (box.empty()) return patches;

  const int edge = std::max(2, box.height / 20);
  const auto luminance = [](const cv::Vec3f& c) {
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  };
  for (int top = box.y; top + edge <= box.br().y; top += edge) {
    for (int left = box.x; left + edge <= box.br().x; left += edge) {
      double tree = 0, seen = 0, sun = 0, rest = 0;
      for (int row = top; row < top + edge; ++row) {
        for (int column = left; column < left + edge; ++column) {
          const float a = cover(row, column);
          tree += a;
          seen += luminance(photo(row, column));
          sun += a * luminance(input.sun(row, column));
          rest += a * luminance(input.sky(row, column) + input.indirect(row, column));
        }
      }
      const double full = edge * edge;
      if (tree < 0.25 * full || !(seen > 0) || !(rest > 0)) continue;
      patches.photo.push_back(seen / tree);
      patches.sun.push_back(sun / tree);
      patches.rest.push_back(rest / tree);
      patches.weight.push_back(tree / full);
    }
  }
  return patches;
}

std::string FitInWords(const LightFit& fit) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed;
  const auto add = [&](const FittedNumber& number) {
    text << std::exp(number.log_value) << " ("
         << std::exp(number.log_value - number.deviation) << " to "
         << std::exp(number.log_value + number.deviation) << ") times as ";
  };
  text << "by the photo's own shading the sky is ";
  add(fit.sky);
  text << "strong" << (fit.sky.flat ? ", which it hardly tells," : "")
       << " and the tree ";
  add(fit.density);
  text << "dense" << (fit.density.flat ? ", which it hardly tells" : "")
       << "; what the light leaves unexplained goes from " << fit.unfitted << " to "
       << fit.spread << " in the logarithm";
  return text.str();
}

SkyFit FitSky(const ShadingPatches& patches) {
  SkyFit fit;
  const std::size_t count = patches.photo.size();
  if (count < kFewest) {
    fit.sky = Number(0, 0);
    return fit;
  }
  const auto cost = [&](double k) {
    return 0.5 * static_cast<double>(count) * std::log(Variance(patches, k)) + Prior(k);
  };
  constexpr double kStep = 0.02;
  double best = 0;
  fit.least = cost(0);
  for (double k = -kWidest; k <= kWidest; k += kStep) {
    const double here = cost(k);
    if (here < fit.least) {
      fit.least = here;
      best = k;
    }
  }
  const double curvature =
      (cost(best - kStep) - 2 * fit.least + cost(best + kStep)) / (kStep * kStep);
  fit.sky = Number(best, curvature);
  fit.spread = std::sqrt(Variance(patches, best));
  fit.unfitted = std::sqrt(Variance(patches, 0));
  return fit;
}

FittedNumber FitScale(const std::vector<double>& log_scales,
                      const std::vector<double>& costs) {
  Require(log_scales.size() == costs.size() && costs.size() >= 3,
          "a cost for each of three scales or more");
  std::vector<double> whole;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    whole.push_back(costs[i] + Prior(log_scales[i]));
  }
  const auto least = std::min_element(whole.begin(), whole.end()) - whole.begin();
  const auto middle = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(least, 1, std::ssize(whole) - 2));
  const double step = log_scales[middle] - log_scales[middle - 1];
  const double low = whole[middle - 1], here = whole[middle], high = whole[middle + 1];
  const double curvature = (low - 2 * here + high) / (step * step);
  const double slope = (high - low) / (2 * step);
  double at = log_scales[static_cast<std::size_t>(least)];
  if (curvature > 0) {
    at = std::clamp(
        log_scales[middle] - slope / curvature, log_scales.front(), log_scales.back());
  }
  return Number(at, curvature);
}

}  // namespace relight
