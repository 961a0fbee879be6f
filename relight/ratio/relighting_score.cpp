// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/relighting_score.h"

#include "relight/base/error.h"
#include "relight/ratio/color_transfer.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>
#include <vector>

namespace relight {
namespace {

using Values = std::vector<double>;

const cv::Vec3d kLuminance(0.2126, 0.7152, 0.0722);

// The inside: a mask, and its pixels row by row.
struct Inside {
  cv::Mat1b mask;
  std::vector<cv::Point> pixels;
};

Values Gather(const cv::Mat1d& image, const Inside& inside) {
  Values values;
  values.reserve(inside.pixels.size());
  for (const cv::Point& p : inside.pixels) values.push_back(image(p));
  return values;
}

double Mean(const Values& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// sum (a - mean a)(b - mean b) / count
double Covariance(const Values& a, const Values& b) {
  const double mean_a = Mean(a), mean_b = Mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / double(a.size());
}

double Deviation(const Values& values) { return std::sqrt(Covariance(values, values)); }

double Correlation(const Values& a, const Values& b) {
  const double deviations = Deviation(a) * Deviation(b);
  return deviations > 0.0 ? std::clamp(Covariance(a, b) / deviations, -1.0, 1.0) : 0.0;
}

Values Minus(Values a, const Values& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

// Between the two nearest ranks, linearly.
double Percentile(Values values, double percent) {
  std::sort(values.begin(), values.end());
  const double rank = percent / 100.0 * double(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (rank - double(below)) * (values[above] - values[below]);
}

cv::Mat1d LuminanceOf(const cv::Mat3d& color) {
  cv::Mat1d luminance(color.size());
  for (int y = 0; y < color.rows; ++y) {
    for (int x = 0; x < color.cols; ++x) luminance(y, x) = color(y, x).dot(kLuminance);
  }
  return luminance;
}

template <class Pixel>
cv::Mat_<Pixel> OnlyInside(const cv::Mat_<Pixel>& image, const Inside& inside) {
  cv::Mat_<Pixel> masked(image.size(), Pixel{});
  image.copyTo(masked, inside.mask);
  return masked;
}

// Mean over the inside part of a box of side 13/300 of the height, mirrored at the edges.
cv::Mat3d LowPass(const cv::Mat3d& color, const Inside& inside) {
  const int side = 2 * static_cast<int>(std::lrint(color.rows * 6 / 300.0)) + 1;
  const auto box = [&](const cv::Mat& image) {
    cv::Mat mean;
    cv::boxFilter(image, mean, CV_64F, {side, side}, {-1, -1}, true, cv::BORDER_REFLECT);
    return mean;
  };
  const cv::Mat3d sums = box(OnlyInside(color, inside));
  const cv::Mat1d weight = box(OnlyInside(cv::Mat1d(color.size(), 1.0), inside));
  cv::Mat3d low(color.size());
  for (int y = 0; y < low.rows; ++y) {
    for (int x = 0; x < low.cols; ++x)
      low(y, x) = sums(y, x) / std::max(weight(y, x), 1e-9);
  }
  return low;
}

// PSNR = 10 log10(peak^2 / mean(e^2)), over `count` values e.                   (E1)
double Psnr(double sum_of_squares, std::size_t count, double peak) {
  return 10.0 * std::log10(peak * peak / std::max(sum_of_squares / double(count), 1e-20));
}

// Mean over the inside of
//   (2 m_a m_b + c1)(2 cov + c2) / ((m_a^2 + m_b^2 + c1)(v_a + v_b + c2)),
// Gaussian windows of sigma 1.5 over the inside, c1 = (0.01 p)^2, c2 = (0.03 p)^2
// [Wang04]
double Ssim(const cv::Mat1d& a, const cv::Mat1d& b, const Inside& inside, double peak) {
  const auto blur = [&](const cv::Mat1d& image) {
    constexpr int kSide = 2 * 6 + 1;  // 4 sigma on each side
    cv::Mat1d blurred;
    cv::GaussianBlur(
        OnlyInside(image, inside), blurred, {kSide, kSide}, 1.5, 1.5, cv::BORDER_REFLECT);
    return blurred;
  };
  const cv::Mat1d weight = blur(cv::Mat1d(a.size(), 1.0));
  const cv::Mat1d sum_a = blur(a), sum_b = blur(b);
  const cv::Mat1d sum_aa = blur(a.mul(a)), sum_bb = blur(b.mul(b)),
                  sum_ab = blur(a.mul(b));
  const double c1 = std::pow(0.01 * peak, 2), c2 = std::pow(0.03 * peak, 2);
  double sum = 0.0;
  for (const cv::Point& p : inside.pixels) {
    const double w = std::max(weight(p), 1e-6);
    const double m_a = sum_a(p) / w, m_b = sum_b(p) / w;
    const double v_a = sum_aa(p) / w - m_a * m_a, v_b = sum_bb(p) / w - m_b * m_b;
    const double cov = sum_ab(p) / w - m_a * m_b;
    sum += (2 * m_a * m_b + c1) * (2 * cov + c2) /
           ((m_a * m_a + m_b * m_b + c1) * (v_a + v_b + c2));
  }
  return sum / double(inside.pixels.size());
}

// g = sum L(result) L(truth) / sum L(result)^2, per channel                     (E2)
cv::Vec3d BestGain(const cv::Mat3d& low,
                   const cv::Mat3d& low_truth,
                   const Inside& inside) {
  cv::Vec3d products, squares;
  for (const cv::Point& p : inside.pixels) {
    products += low(p).mul(low_truth(p));
    squares += low(p).mul(low(p));
  }
  cv::Vec3d gain;
  for (int c = 0; c < 3; ++c) gain[c] = products[c] / std::max(squares[c], 1e-20);
  return gain;
}

// What is the same for every row.
struct Truth {
  cv::Mat3d color;
  cv::Mat1f alpha;
  cv::Mat1d luminance;
  cv::Mat3d low;
  double peak = 0.0;
};

std::optional<double> RingPsnr(const cv::Mat3d& color,
                               const cv::Mat1f& alpha,
                               const Truth& truth,
                               const cv::Vec3d& gain) {
  if (truth.alpha.empty()) return std::nullopt;
  double sum = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < color.rows; ++y) {
    for (int x = 0; x < color.cols; ++x) {
      const float covered = truth.alpha(y, x);
      if (!(covered > 0.05 && covered < 0.5)) continue;
      const cv::Vec3d error = double(alpha(y, x)) * color(y, x).mul(gain) -
                              double(covered) * truth.color(y, x);
      sum += error.dot(error);
      count += 3;
    }
  }
  if (count == 0) return std::nullopt;
  return Psnr(sum, count, truth.peak);
}

RelightingFigures Score(const cv::Mat3d& color,
                        const cv::Mat1f& alpha,
                        const Truth& truth,
                        const Inside& inside) {
  const cv::Mat3d low = LowPass(color, inside);
  const cv::Vec3d gain = BestGain(low, truth.low, inside);
  double low_error = 0.0, error = 0.0;
  for (const cv::Point& p : inside.pixels) {
    const cv::Vec3d at_low = low(p).mul(gain) - truth.low(p);
    const cv::Vec3d at_full = color(p) - truth.color(p);
    low_error += at_low.dot(at_low);
    error += at_full.dot(at_full);
  }
  const std::size_t values = 3 * inside.pixels.size();

  const cv::Mat1d luminance = LuminanceOf(color);
  const Values all = Gather(luminance, inside),
               all_truth = Gather(truth.luminance, inside);
  const Values a = Gather(LuminanceOf(low), inside);
  const Values b = Gather(LuminanceOf(truth.low), inside);
  const Values high = Minus(all, a), high_truth = Minus(all_truth, b);

  // contrast = (std(Y - Y L) / mean(Y L)) over that of the truth               (E3)
  const double local = Deviation(high) / std::max(Mean(a), 1e-20);
  const double local_truth = Deviation(high_truth) / Mean(b);
  // colour = (|ln g_R / g_G| + |ln g_B / g_G|) / 2                             (E4)
  const double colour =
      (std::abs(std::log(gain[0] / gain[1])) + std::abs(std::log(gain[2] / gain[1]))) /
      2.0;

  return {.psnr_low = Psnr(low_error, values, truth.peak),
          .corr_low = Correlation(a, b),
          .contrast = local / local_truth,
          .corr_high = Correlation(high, high_truth),
          .level = Mean(all) / Mean(all_truth),
          .colour = colour,
          .ring = RingPsnr(color, alpha, truth, gain),
          .psnr = Psnr(error, values, truth.peak),
          .ssim = Ssim(luminance, truth.luminance, inside, truth.peak),
          .gain = {gain[0], gain[1], gain[2]}};
}

// The source's pixels in the order of their brightness, channel by channel, given the
// truth's values in that order; equal ones row by row.
cv::Mat3d HistogramTransfer(const cv::Mat3d& source,
                            const cv::Mat3d& truth,
                            const Inside& inside) {
  cv::Mat3d transferred = source.clone();
  for (int c = 0; c < 3; ++c) {
    std::vector<cv::Point> order = inside.pixels;
    std::stable_sort(
        order.begin(), order.end(), [&](const cv::Point& p, const cv::Point& q) {
          return source(p)[c] < source(q)[c];
        });
    Values values;
    for (const cv::Point& p : inside.pixels) values.push_back(truth(p)[c]);
    std::sort(values.begin(), values.end());
    for (std::size_t i = 0; i < order.size(); ++i) transferred(order[i])[c] = values[i];
  }
  return transferred;
}

std::string SizeInWords(const cv::Mat& image) {
  return std::to_string(image.cols) + "x" + std::to_string(image.rows);
}

void CheckSizes(const RelightingPictures& pictures) {
  const cv::Size size = pictures.truth.color.size();
  const auto check = [&](const char* name, const cv::Mat& image, bool needed) {
    if ((image.empty() && !needed) || (image.size() == size && !image.empty())) return;
    throw InputError(std::string(name) + " is " + SizeInWords(image) + ", the truth is " +
                     SizeInWords(pictures.truth.color) +
                     "; give pictures of one view and size");
  };
  check("the truth", pictures.truth.color, true);
  check("the truth's alpha", pictures.truth.alpha, false);
  check("the result", pictures.result.color, true);
  check("the result's alpha", pictures.result.alpha, false);
  check("the source", pictures.source.color, false);
  check("the matte", pictures.matte, false);
}

bool IsOpaque(const cv::Mat1f& alpha) { return cv::countNonZero(alpha < 1.0f) == 0; }

Inside FindInside(const RelightingPictures& pictures) {
  Inside inside{.mask = ScoredInside(pictures), .pixels = {}};
  cv::findNonZero(inside.mask, inside.pixels);
  return inside;
}

void CheckFinite(const char* name, const cv::Mat3d& color, const Inside& inside) {
  for (const cv::Point& p : inside.pixels) {
    const cv::Vec3d value = color(p);
    if (std::isfinite(value[0]) && std::isfinite(value[1]) && std::isfinite(value[2]))
      continue;
    std::ostringstream text;
    text << name << " is not a finite number at pixel " << p.x << "," << p.y
         << " inside the matte; it cannot be scored";
    throw InputError(text.str());
  }
}

}  // namespace

cv::Mat1b ScoredInside(const RelightingPictures& pictures) {
  CheckSizes(pictures);
  const cv::Mat1f &alpha = pictures.truth.alpha, &matte = pictures.matte;
  if (matte.empty() && (alpha.empty() || IsOpaque(alpha))) {
    throw InputError(
        "nothing says where the tree is: the truth has no alpha, or is opaque all over; "
        "give the matte of this view, --alpha FILE");
  }
  cv::Mat1b inside(pictures.truth.color.size(), uchar{255});
  if (!alpha.empty()) inside &= alpha > 0.5f;
  if (!matte.empty()) inside &= matte > 0.5f;
  if (cv::countNonZero(inside) == 0) {
    throw InputError(
        "no pixel has alpha > 0.5 in both the truth and the matte; give the "
        "matte of this view");
  }
  return inside;
}

RelightingScore ScoreRelighting(const RelightingPictures& pictures,
                                const RelightingScoreOptions& options) {
  CheckFields(options);
  const Inside inside = FindInside(pictures);
  cv::Mat3d result;
  Truth truth{.color = {}, .alpha = pictures.truth.alpha, .luminance = {}, .low = {}};
  pictures.result.color.convertTo(result, CV_64F);
  pictures.truth.color.convertTo(truth.color, CV_64F);
  result /= options.scale;
  CheckFinite("the result", result, inside);
  CheckFinite("the truth", truth.color, inside);

  truth.luminance = LuminanceOf(truth.color);
  truth.low = LowPass(truth.color, inside);
  truth.peak = Percentile(Gather(truth.luminance, inside), 99.0);
  if (!(truth.peak > 0.0)) {
    throw InputError("the truth is black inside the matte; give the lit tree");
  }

  const cv::Mat1f& matte = pictures.matte.empty() ? pictures.truth.alpha : pictures.matte;
  const cv::Mat1f& alpha = pictures.result.alpha.empty() ? matte : pictures.result.alpha;
  RelightingScore score{.result = Score(result, alpha, truth, inside),
                        .pixels = static_cast<int>(inside.pixels.size()),
                        .peak = truth.peak};
  if (pictures.source.color.empty()) return score;

  cv::Mat3d source;
  pictures.source.color.convertTo(source, CV_64F);
  CheckFinite("the source", source, inside);
  const auto row = [&](const cv::Mat3d& color) {
    return Score(color, matte, truth, inside);
  };
  score.nothing = row(source);
  score.histogram = row(HistogramTransfer(source, truth.color, inside));
  score.reinhard = row(ReinhardTransfer(source, truth.color, inside.mask));
  score.monge_kantorovich =
      row(MongeKantorovichTransfer(source, truth.color, inside.mask));
  return score;
}

}  // namespace relight
