// SPDX-License-Identifier: Apache-2.0
#include "matting/automatic_trimap.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace relight {
namespace {

constexpr int kWorkPixels = 400000;  // Sky, ground and crown are told apart at this size.
constexpr int kCutPixels = 40000;    // A graph cut cannot be stopped half-way.
constexpr int kSkyCell = 8;          // The sky's colour is smooth: one in 8 x 8 pixels.
constexpr double kEdgeContrast = 0.6;  // Of (M10): a leaf's rim is still mostly leaf.
constexpr std::uint8_t kDecide =
    64;  // Of a zone: (M10) is to decide at the photo's size.

cv::Size Reduced(cv::Size size, int pixels) {
  const double scale =
      std::min(1.0, std::sqrt(pixels / (1.0 * size.width * size.height)));
  return {std::max(1, cvRound(scale * size.width)),
          std::max(1, cvRound(scale * size.height))};
}

cv::Mat1b Dilated(const cv::Mat1b& mask, int radius) {
  cv::Mat1b out;
  cv::dilate(mask, out, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U));
  return out;
}

cv::Mat1b Eroded(const cv::Mat1b& mask, int radius) {
  cv::Mat1b out;
  cv::erode(mask, out, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U));
  return out;
}

// The value that `share` of those under the mask stay below; 0 for none.
double Quantile(const cv::Mat1f& values, const cv::Mat1b& mask, double share) {
  std::vector<float> in;
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) {
      if (mask(y, x) != 0) in.push_back(values(y, x));
    }
  }
  if (in.empty()) return 0;
  const auto at = in.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(in.size() - 1));
  std::nth_element(in.begin(), at, in.end());
  return *at;
}

cv::Mat3f LabFromDisplay(const cv::Mat3f& display) {
  cv::Mat3f lab;
  cv::cvtColor(display, lab, cv::COLOR_RGB2Lab);
  cv::patchNaNs(lab);
  return lab;
}

// d of (M9) for the rows from `first` on of a picture of `size`; `sky` covers all of it.
cv::Mat1f DistanceToSky(const cv::Mat3f& display_rows,
                        int first,
                        cv::Size size,
                        const cv::Mat3f& sky) {
  const cv::Mat3f lab = LabFromDisplay(display_rows);
  cv::Mat1f distance(lab.size());
  for (int y = 0; y < lab.rows; ++y) {
    const double sky_y = (first + y + 0.5) * sky.rows / size.height - 0.5;
    const int y0 = std::clamp(cvFloor(sky_y), 0, sky.rows - 1);
    const int y1 = std::min(y0 + 1, sky.rows - 1);
    const auto v = static_cast<float>(std::clamp(sky_y - y0, 0.0, 1.0));
    for (int x = 0; x < lab.cols; ++x) {
      const double sky_x = (x + 0.5) * sky.cols / size.width - 0.5;
      const int x0 = std::clamp(cvFloor(sky_x), 0, sky.cols - 1);
      const int x1 = std::min(x0 + 1, sky.cols - 1);
      const auto u = static_cast<float>(std::clamp(sky_x - x0, 0.0, 1.0));
      const cv::Vec3f there = (1 - v) * ((1 - u) * sky(y0, x0) + u * sky(y0, x1)) +
                              v * ((1 - u) * sky(y1, x0) + u * sky(y1, x1));
      distance(y, x) = static_cast<float>(cv::norm(lab(y, x) - there));
    }
  }
  return distance;
}

// Fills a field in from what is known of it: `sum` is the value times `weight`, the share
// of each cell that is known. What a cell lacks comes from cells of twice its size.
cv::Mat3f FilledIn(const cv::Mat3f& sum, const cv::Mat1f& weight) {
  cv::Mat3f filled(sum.size(), cv::Vec3f::all(0));
  if (sum.rows > 1 || sum.cols > 1) {
    const cv::Size half((sum.cols + 1) / 2, (sum.rows + 1) / 2);
    cv::Mat half_sum, half_weight, up;
    cv::resize(sum, half_sum, half, 0, 0, cv::INTER_AREA);
    cv::resize(weight, half_weight, half, 0, 0, cv::INTER_AREA);
    cv::resize(FilledIn(half_sum, half_weight), up, sum.size(), 0, 0, cv::INTER_LINEAR);
    filled = up;
  }
  for (int y = 0; y < sum.rows; ++y) {
    for (int x = 0; x < sum.cols; ++x) {
      if (weight(y, x) <= 0) continue;
      const float enough = std::min(1.0f, 4 * weight(y, x));  // A quarter tells the mean
      filled(y, x) = enough / weight(y, x) * sum(y, x) + (1 - enough) * filled(y, x);
    }
  }
  return filled;
}

// The sky's gradient, linear across and quadratic in height, over the whole picture: what
// the open sky says of places where none is seen nearby. Clouds among it are left out.
cv::Mat3f SkyGradient(const cv::Mat3f& lab, const cv::Mat1b& sky) {
  int lowest = 0;
  for (int y = 0; y < lab.rows; ++y) {
    if (cv::countNonZero(sky.row(y)) > 0) lowest = y;
  }
  const auto basis = [&](int x, int y) {  // Below the lowest sky nothing is extrapolated
    const double u = 2.0 * x / lab.cols - 1, v = 1.0 * std::min(y, lowest) / lab.rows;
    return Eigen::Vector4d(1, u, v, v * v);
  };
  cv::Mat3f gradient(lab.size());
  cv::Mat1f residual(lab.size(), 0.0f);
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    const double limit = std::max(3.0, 4.5 * Quantile(residual, sky, 0.5));
    Eigen::Matrix4d square = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
    for (int y = 0; y < lab.rows; y += 2) {
      for (int x = 0; x < lab.cols; x += 2) {
        if (sky(y, x) == 0 || residual(y, x) > limit) continue;
        const Eigen::Vector4d b = basis(x, y);
        square += b * b.transpose();
        right += b * Eigen::RowVector3d(lab(y, x)[0], lab(y, x)[1], lab(y, x)[2]);
      }
    }
    // A little of the data says "flat", for where it says nothing else
    square.diagonal().tail<3>().array() += 1e-5 * square(0, 0) + 1e-9;
    const Eigen::Matrix<double, 4, 3> coefficients = square.ldlt().solve(right);
    for (int y = 0; y < lab.rows; ++y) {
      for (int x = 0; x < lab.cols; ++x) {
        const Eigen::RowVector3f c =
            (basis(x, y).transpose() * coefficients).cast<float>();
        gradient(y, x) = {c[0], c[1], c[2]};
        residual(y, x) = static_cast<float>(cv::norm(lab(y, x) - gradient(y, x)));
      }
    }
  }
  return gradient;
}

struct Sky {
  cv::Mat3f color;          // s of (M9), a cell each kSkyCell pixels.
  cv::Mat1f distance;       // d
  cv::Mat1b known, ground;  // Smooth: sky, also through the crown; what is below it.
  double sigma = 1, contrast = 0;
  double share = 0;  // Of the upper border; 0: no sky.
  int horizon = -1;  // Row.
};

// A smooth piece of the picture.
struct Piece {
  int pixels = 0, at_top = 0, at_bottom = 0;
  bool sky = false, not_sky = false;
  cv::Vec3d color{0, 0, 0}, color_at_top{0, 0, 0};
  double distance = 0;
};

Sky FindSky(const cv::Mat3f& display, const Progress& progress) {
  const cv::Mat3f lab = LabFromDisplay(display);
  const int rows = lab.rows, cols = lab.cols, edge = std::max(1, rows / 50);
  progress.Report(0.05);
  Sky sky;
  sky.known = cv::Mat1b(lab.size(), std::uint8_t{0});
  sky.ground = sky.known.clone();
  sky.distance = cv::Mat1f(lab.size(), 0.0f);

  // Smooth: colours spread no more than a noisy sky's at the upper border, at most 8
  cv::Mat mean, square;
  cv::blur(lab, mean, {5, 5});
  cv::blur(lab.mul(lab), square, {5, 5});
  const cv::Mat3f variance = square - mean.mul(mean);
  cv::Mat1f spread(lab.size());
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      const cv::Vec3f& v = variance(y, x);
      spread(y, x) = std::sqrt(std::max(0.0f, v[0] + v[1] + v[2]));
    }
  }
  const cv::Mat1b all(edge, cols, std::uint8_t{255});
  const double noise = Quantile(spread.rowRange(0, edge), all, 0.25);
  const cv::Mat1b smooth = spread < std::clamp(2 * noise, 3.0, 8.0);
  cv::Mat1i piece_at;
  std::vector<Piece> pieces(
      static_cast<std::size_t>(cv::connectedComponents(smooth, piece_at, 4, CV_32S)));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      Piece& piece = pieces[static_cast<std::size_t>(piece_at(y, x))];
      ++piece.pixels;
      piece.color += lab(y, x);
      if (y < edge) {
        ++piece.at_top;
        piece.color_at_top += lab(y, x);
      }
      if (y >= rows - edge) ++piece.at_bottom;
    }
  }
  progress.Report(0.1);

  // Sky begins at the upper border. It is blue there, or bright (L* 75 is half of white's
  // luminance, which clouds reach in any usual exposure): not lawn, leaves or asphalt.
  pieces[0] = {};
  pieces[0].not_sky = true;
  for (Piece& piece : pieces) {
    piece.color *= 1.0 / std::max(piece.pixels, 1);
    const cv::Vec3d top = piece.color_at_top * (1.0 / std::max(piece.at_top, 1));
    const bool looks_it = top[2] < -5 || (top[0] > 75 && top[2] < 10);
    piece.sky = piece.at_top > 0 && looks_it && !piece.not_sky;
    if (piece.at_bottom > 0 && !piece.sky) piece.not_sky = true;
  }
  const auto of = [&](int y, int x) -> Piece& {
    return pieces[static_cast<std::size_t>(piece_at(y, x))];
  };
  int open = 0;
  for (int x = 0; x < cols; ++x) {
    bool any = false;
    for (int y = 0; y < edge; ++y) any = any || of(y, x).sky;
    if (any) ++open;
  }
  if (3 * open < cols) open = 0;  // A road or a lake may be as little
  sky.share = static_cast<double>(open) / cols;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      if (of(y, x).sky) sky.known(y, x) = 255;
      if (of(y, x).at_bottom > 0 && !of(y, x).sky) sky.ground(y, x) = 255;
    }
  }
  const cv::Scalar ground_mean = cv::mean(lab, sky.ground);
  const cv::Vec3d ground_color(ground_mean[0], ground_mean[1], ground_mean[2]);
  const bool has_ground = cv::countNonZero(sky.ground) > 0;
  if (open == 0) return sky;
  progress.Report(0.2);

  // From there it goes on behind the tree: what is alike is sky too, and tells its colour
  const cv::Mat1b open_sky = sky.known.clone();
  const cv::Mat3f gradient = SkyGradient(lab, open_sky);
  const cv::Size cells((cols + kSkyCell - 1) / kSkyCell,
                       (rows + kSkyCell - 1) / kSkyCell);
  cv::Mat cell_gradient;
  cv::resize(gradient, cell_gradient, cells, 0, 0, cv::INTER_AREA);
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    cv::Mat3f left = lab - gradient;
    left.setTo(cv::Scalar::all(0), sky.known == 0);
    cv::Mat weight, cell_left, cell_weight;
    sky.known.convertTo(weight, CV_32F, 1.0 / 255);
    cv::resize(left, cell_left, cells, 0, 0, cv::INTER_AREA);
    cv::resize(weight, cell_weight, cells, 0, 0, cv::INTER_AREA);
    sky.color = cell_gradient + FilledIn(cell_left, cell_weight);
    sky.distance = DistanceToSky(display, 0, lab.size(), sky.color);
    sky.sigma = std::max(1.0, 1.5 * Quantile(sky.distance, open_sky, 0.5));
    sky.contrast = Quantile(sky.distance, sky.distance > 8 * sky.sigma, 0.9);
    progress.Report(0.2 + 0.8 * (round + 1) / kRounds);
    if (round + 1 == kRounds) break;

    for (Piece& piece : pieces) piece.distance = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < cols; ++x) of(y, x).distance += sky.distance(y, x);
    }
    for (Piece& piece : pieces) {
      if (piece.not_sky || piece.sky) continue;
      const double distance = piece.distance / std::max(piece.pixels, 1);
      piece.sky = piece.pixels > 12 && distance < 0.4 * sky.contrast &&
                  (!has_ground || distance < cv::norm(piece.color - ground_color));
    }
    const cv::Mat1b tree_near = Dilated(sky.distance > 6 * sky.sigma, 1);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < cols; ++x) {
        const bool alike = sky.distance(y, x) < 2 * sky.sigma && tree_near(y, x) == 0 &&
                           sky.ground(y, x) == 0 && !(of(y, x).not_sky && smooth(y, x));
        sky.known(y, x) = of(y, x).sky || alike ? 255 : 0;
      }
    }
  }
  for (int y = 0; y < rows; ++y) {
    if (cv::countNonZero(sky.known.row(y)) > 0.02 * cols) sky.horizon = y;
  }
  sky.horizon = std::max(0, sky.horizon - 3);  // Nearer, sky and ground are blurred
  return sky;
}

// cv::grabCut draws from cv::theRNG: the same numbers each time, and none of the
// caller's.
class FixedRandom {
 public:
  FixedRandom() : before_(cv::theRNG().state) { cv::setRNGSeed(1); }
  ~FixedRandom() { cv::theRNG().state = before_; }
  FixedRandom(const FixedRandom&) = delete;
  FixedRandom& operator=(const FixedRandom&) = delete;

 private:
  std::uint64_t before_;
};

// Runs GrabCut from `first_row` on, at a small size; 255 is tree. With `models` they are
// kept, else they are learned from the mask.
cv::Mat1b Cut(const cv::Mat3b& picture,
              const cv::Mat1b& mask,
              int first_row,
              const ColorModels& models,
              const Progress& progress) {
  const cv::Mat part = picture.rowRange(first_row, picture.rows);
  const cv::Size size = Reduced(part.size(), kCutPixels);
  cv::Mat small;
  cv::Mat1b labels;
  cv::resize(part, small, size, 0, 0, cv::INTER_AREA);
  cv::resize(mask.rowRange(first_row, mask.rows), labels, size, 0, 0, cv::INTER_NEAREST);
  const auto is_tree = [&] {
    return cv::Mat1b((labels == cv::GC_FGD) | (labels == cv::GC_PR_FGD));
  };
  const int tree_pixels = cv::countNonZero(is_tree());
  constexpr int kLeast = 20;  // Fewer pixels do not teach a mixture
  if (!models.Empty() || (tree_pixels >= kLeast &&
                          static_cast<int>(labels.total()) - tree_pixels >= kLeast)) {
    const FixedRandom fixed_random;
    cv::Mat foreground = models.foreground.clone(),
            background = models.background.clone();
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      const int mode = !models.Empty() ? cv::GC_EVAL_FREEZE_MODEL
                       : round == 0    ? cv::GC_INIT_WITH_MASK
                                       : cv::GC_EVAL;
      cv::grabCut(small, labels, {}, background, foreground, 1, mode);
      progress.Report((round + 1.0) / kRounds);
      if (!models.Empty()) break;
    }
  }
  cv::Mat1b tree(picture.size(), std::uint8_t{0}), at_size;
  cv::resize(is_tree(), at_size, part.size(), 0, 0, cv::INTER_LINEAR);
  cv::Mat1b(at_size > 127).copyTo(tree.rowRange(first_row, picture.rows));
  return tree;
}

// Mixtures of the pixels labelled foreground and of those labelled background.
ColorModels LearnModels(const cv::Mat3b& picture, const cv::Mat1b& labels) {
  ColorModels models;
  const TrimapCounts counts = CountLabels(labels);
  constexpr int kMost = 20000, kLeast = 20;
  if (std::min(counts.foreground, counts.background) < kLeast) return models;
  std::vector<cv::Vec3b> colors;
  std::vector<std::uint8_t> mask;
  std::array<std::int64_t, 2> seen{0, 0};
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      if (labels(y, x) == kTrimapUnknown) continue;
      const bool tree = labels(y, x) == kTrimapForeground;
      const std::int64_t count = tree ? counts.foreground : counts.background;
      if (seen[tree ? 1 : 0]++ % (count / kMost + 1) != 0) continue;
      colors.push_back(picture(y, x));
      mask.push_back(tree ? cv::GC_FGD : cv::GC_BGD);
    }
  }
  const FixedRandom fixed_random;
  cv::Mat1b mask_row = cv::Mat1b(mask, true).reshape(1, 1);
  cv::grabCut(cv::Mat3b(colors, true).reshape(3, 1),
              mask_row,
              {},
              models.background,
              models.foreground,
              1,
              cv::GC_INIT_WITH_MASK);
  return models;
}

// ln of a mixture's density at a colour: of all its Gaussians, where [Rother04] takes one
class MixtureDensity {
 public:
  explicit MixtureDensity(const cv::Mat& model) {
    const double* m = model.ptr<double>();
    for (int i = 0; i < 5; ++i) {
      if (m[i] <= 0) continue;
      const Eigen::Matrix3d covariance =
          Eigen::Map<const Eigen::Matrix3d>(m + 20 + 9 * i) +
          0.01 * Eigen::Matrix3d::Identity();
      parts_.push_back({Eigen::Map<const Eigen::Vector3d>(m + 5 + 3 * i),
                        covariance.inverse(),
                        m[i] / std::sqrt(covariance.determinant())});
    }
  }
  double Log(const cv::Vec3b& color) const {
    double density = 1e-30;  // Of a colour far from all
    for (const Part& part : parts_) {
      const Eigen::Vector3d c = Eigen::Vector3d(color[0], color[1], color[2]) - part.mean;
      density += part.weight * std::exp(-0.5 * c.dot(part.inverse * c));
    }
    return std::log(density);
  }

 private:
  struct Part {
    Eigen::Vector3d mean;
    Eigen::Matrix3d inverse;
    double weight;
  };
  std::vector<Part> parts_;
};

// Where colours say, over a neighbourhood of the strong pixels, that it is no tree.
cv::Mat1b UnlikeTree(const cv::Mat3b& picture,
                     const cv::Mat1b& strong,
                     const ColorModels& models) {
  const MixtureDensity tree(models.foreground), other(models.background);
  cv::Mat1f sum(picture.size(), 0.0f), weight(picture.size(), 0.0f);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      if (strong(y, x) == 0) continue;
      sum(y, x) = static_cast<float>(tree.Log(picture(y, x)) - other.Log(picture(y, x)));
      weight(y, x) = 1;
    }
  }
  const int side = std::max(3, cvRound(std::sqrt(picture.total()) / 30)) | 1;
  cv::boxFilter(sum, sum, -1, {side, side});
  cv::boxFilter(weight, weight, -1, {side, side});
  return sum < -1.0f * weight;  // e times likelier
}

// The pieces of `tree`, gaps of a hundredth of the picture's side closed, that a
// foreground stroke touches; without one the piece with the most of `solid`.
cv::Mat1b MainPiece(const cv::Mat1b& tree,
                    const cv::Mat1b& solid,
                    const cv::Mat1b& strokes) {
  const int r = std::max(1, cvRound(std::sqrt(tree.total()) / 100));
  cv::Mat1b closed;
  cv::morphologyEx(tree,
                   closed,
                   cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * r + 1, 2 * r + 1}));
  cv::Mat1i piece_at;
  const int count = cv::connectedComponents(closed, piece_at, 8, CV_32S);
  std::vector<int> solid_pixels(static_cast<std::size_t>(count), 0);
  std::vector<bool> chosen(static_cast<std::size_t>(count), false);
  bool any = false;
  for (int y = 0; y < tree.rows; ++y) {
    for (int x = 0; x < tree.cols; ++x) {
      const auto piece = static_cast<std::size_t>(piece_at(y, x));
      if (piece == 0) continue;
      if (solid(y, x) != 0) ++solid_pixels[piece];
      if (strokes(y, x) == kTrimapForeground) chosen[piece] = any = true;
    }
  }
  if (!any) {
    const auto most = std::max_element(solid_pixels.begin(), solid_pixels.end());
    if (*most > 0) chosen[static_cast<std::size_t>(most - solid_pixels.begin())] = true;
  }
  cv::Mat1b main(tree.size(), std::uint8_t{0});
  for (int y = 0; y < tree.rows; ++y) {
    for (int x = 0; x < tree.cols; ++x) {
      if (chosen[static_cast<std::size_t>(piece_at(y, x))]) main(y, x) = 255;
    }
  }
  return main;
}

// Labels of all rows: those of `zone` (of any size), and (M10) where it says so.
cv::Mat1b Decided(const cv::Mat3f& display,
                  const Sky& sky,
                  const cv::Mat1b& zone,
                  const AutomaticTrimapOptions& options,
                  const Progress& progress) {
  const int rows = display.rows, cols = display.cols;
  const cv::Size size = display.size();

  // The sky's spread is larger at the photo's own size, where no noise was averaged
  double sigma = sky.sigma;
  if (sky.share > 0) {
    constexpr int kSamples = 16;
    cv::Mat1f sampled(kSamples, cols);
    cv::Mat1b known(kSamples, cols);
    for (int i = 0; i < kSamples; ++i) {
      const int y = static_cast<int>((i + 0.5) * rows / kSamples);
      DistanceToSky(display.row(y), y, size, sky.color).copyTo(sampled.row(i));
      cv::resize(sky.known.row(static_cast<int>(1LL * y * sky.known.rows / rows)),
                 known.row(i),
                 {cols, 1},
                 0,
                 0,
                 cv::INTER_NEAREST);
    }
    sigma = std::max(sigma, 1.5 * Quantile(sampled, known, 0.5));
  }

  cv::Mat1b trimap(size);
  constexpr int kRows = 32;
  ParallelRanges(
      rows,
      kRows,
      [&](int begin, int end) {
        const int first = std::max(begin - 1, 0), last = std::min(end + 1, rows);
        cv::Mat1f distance, least, most;
        for (int y = begin; y < end; ++y) {
          const std::uint8_t* zones =
              zone.ptr(static_cast<int>(1LL * y * zone.rows / rows));
          for (int x = 0; x < cols; ++x) {
            std::uint8_t label = zones[1LL * x * zone.cols / cols];
            if (label == kDecide) {
              if (distance.empty()) {
                distance =
                    DistanceToSky(display.rowRange(first, last), first, size, sky.color);
                cv::erode(distance, least, cv::Mat::ones(3, 3, CV_8U));
                cv::dilate(distance, most, cv::Mat::ones(3, 3, CV_8U));
              }
              const bool is_sky = most(y - first, x) < options.sky_tolerance * sigma;
              const bool is_tree =
                  distance(y - first, x) > options.foreground_contrast * sky.contrast &&
                  least(y - first, x) > kEdgeContrast * sky.contrast;
              label = is_sky    ? kTrimapBackground
                      : is_tree ? kTrimapForeground
                                : kTrimapUnknown;
            }
            trimap(y, x) = label;
          }
        }
      },
      progress);
  return trimap;
}

// Strokes at a smaller size: none, however thin, is lost. All unknown where there are
// none.
cv::Mat1b ReducedStrokes(const cv::Mat1b& strokes, cv::Size size) {
  cv::Mat1b reduced(size, kTrimapUnknown);
  for (int y = 0; y < strokes.rows; ++y) {
    for (int x = 0; x < strokes.cols; ++x) {
      if (strokes(y, x) == kTrimapUnknown) continue;
      reduced(static_cast<int>(1LL * y * size.height / strokes.rows),
              static_cast<int>(1LL * x * size.width / strokes.cols)) = strokes(y, x);
    }
  }
  return reduced;
}

// What stands before the sky: more than the sky's own spread, and as much as solid tree.
struct Standing {
  cv::Mat1b weak, strong;
};

Standing BeforeTheSky(const Sky& sky,
                      const cv::Mat1b& strokes,
                      const AutomaticTrimapOptions& options) {
  Standing standing{sky.distance > options.sky_tolerance * sky.sigma,
                    sky.distance > options.foreground_contrast * sky.contrast};
  const int below = sky.horizon + 1;
  standing.weak.rowRange(below, standing.weak.rows).setTo(0);
  standing.weak.setTo(255, strokes == kTrimapForeground);
  standing.weak.setTo(0, strokes == kTrimapBackground);
  standing.strong &= standing.weak;

  // Faint and soft all around: cloud, not leaves
  cv::Mat1f most;
  cv::dilate(sky.distance, most, cv::Mat::ones(5, 5, CV_8U));
  cv::Mat1f least;
  cv::erode(sky.distance, least, cv::Mat::ones(5, 5, CV_8U));
  standing.weak.setTo(0,
                      (most < 0.35 * sky.contrast) & (most - least < 0.2 * sky.contrast) &
                          (strokes != kTrimapForeground));
  return standing;
}

// The mask that GrabCut starts from.
cv::Mat1b CutMask(const Sky& sky,
                  const Standing& standing,
                  const cv::Mat1b& main,
                  const cv::Mat1b& strokes,
                  bool informed) {
  const int rows = main.rows, cols = main.cols, below = sky.horizon + 1;
  cv::Mat1b mask(main.size(), static_cast<std::uint8_t>(cv::GC_PR_BGD));
  if (sky.share > 0) {
    // Above the horizon the sky model knows
    cv::Mat1b above = mask.rowRange(0, below);
    above.setTo(cv::GC_BGD, standing.weak.rowRange(0, below) == 0);
    above.setTo(cv::GC_PR_FGD,
                standing.weak.rowRange(0, below) & main.rowRange(0, below));
    above.setTo(informed ? cv::GC_PR_FGD : cv::GC_FGD,
                standing.strong.rowRange(0, below) & main.rowRange(0, below));

    // What stands on the horizon may reach half-way down; the lowest fifth is ground
    const int band = std::max(2, rows / 50), under = rows - below;
    const int from = std::max(0, below - band);
    for (int x = 0; x < cols && under > 0; ++x) {
      const int standing_here =
          cv::countNonZero(main(cv::Rect(x, from, 1, below - from)) &
                           standing.weak(cv::Rect(x, from, 1, below - from)));
      if (standing_here > 0.9 * (below - from)) {
        mask(cv::Rect(x, below, 1, under / 2)).setTo(cv::GC_PR_FGD);
      }
    }
    mask.setTo(cv::GC_BGD, sky.ground);
    mask.rowRange(rows - under / 5, rows).setTo(cv::GC_BGD);
  }
  mask.setTo(cv::GC_BGD, strokes == kTrimapBackground);
  mask.setTo(cv::GC_FGD, strokes == kTrimapForeground);
  return mask;
}

// Takes away below the horizon what nothing holds from above: a shadow lies flat, while a
// trunk and drooping boughs widen downwards by a pixel in three rows at most.
void KeepWhatIsHeld(cv::Mat1b& tree, int horizon, const cv::Mat1b& strokes) {
  for (int y = std::max(horizon + 1, 1); y < tree.rows; ++y) {
    const int reach = y % 3 == 0 ? 1 : 0;
    for (int x = 0; x < tree.cols; ++x) {
      bool held = strokes(y, x) == kTrimapForeground;
      for (int i = std::max(0, x - reach); i <= std::min(tree.cols - 1, x + reach); ++i) {
        held = held || tree(y - 1, i) != 0;
      }
      if (!held) tree(y, x) = 0;
    }
  }
}

// How far the main piece can be trusted: the doubts, each with the factor it leaves.
void Judge(const Sky& sky,
           const cv::Mat1b& tree,
           bool ground_marked,
           bool informed,
           AutomaticTrimap& result) {
  const auto doubt = [&](double factor, const char* words) {
    result.confidence *= std::clamp(factor, 0.0, 1.0);
    if (factor < 0.8) result.doubts.emplace_back(words);
  };
  result.confidence = 1;
  if (cv::countNonZero(tree) == 0) {
    doubt(0, "no tree found: draw a stroke on the tree");
    return;
  }
  if (sky.share == 0) {
    doubt(0.5, "no sky at the upper border: look at the result, add strokes if needed");
    return;
  }
  doubt(2 * sky.share,
        "little sky at the upper border: draw a stroke on the sky and one on the tree");
  // Sure sky and sure leaves are apart when D is 4 t sigma and more
  doubt(sky.contrast / (12 * sky.sigma),
        "the tree hardly differs from the sky: draw strokes on both");
  if (informed) return;

  const cv::Rect box = cv::boundingRect(tree);
  const int at_sides =
      cv::countNonZero(tree.col(0)) + cv::countNonZero(tree.col(tree.cols - 1));
  doubt(
      std::max(0.4, 1 - 2.0 * at_sides / box.height),
      "the tree reaches the left or right border: if other things stand beside it, draw "
      "strokes on the tree and on them");
  if (sky.horizon + 5 >= tree.rows) {
    doubt(
        0.7,
        "sky down to the lower border: if there is ground, draw strokes on the tree and "
        "on the ground");
    return;
  }
  if (box.br().y <= sky.horizon + tree.rows / 50) {
    doubt(0.5, "the tree ends at the horizon: draw a stroke on its trunk");
    return;
  }
  if (ground_marked) return;
  // A trunk is narrow somewhere between the horizon and the foot
  const int foot = box.br().y, last = foot - std::max(0, foot - sky.horizon) / 5;
  int widest = 1, narrowest = tree.cols;
  for (int y = box.y; y < foot; ++y) {
    const int width = cv::countNonZero(tree.row(y));
    widest = std::max(widest, width);
    if (y >= sky.horizon && y <= last) narrowest = std::min(narrowest, width);
  }
  doubt(std::max(0.5, 1.2 - 1.0 * narrowest / widest),
        "the tree is wide where it meets the ground: draw a background stroke on the "
        "ground");
}

}  // namespace

AutomaticTrimap EstimateTrimap(const cv::Mat3f& display,
                               const cv::Mat1b& strokes,
                               const ColorModels* like,
                               const AutomaticTrimapOptions& options,
                               const Progress& progress) {
  CheckFields(options);
  if (display.empty()) throw InputError("the photo is empty (0 x 0 pixels)");
  bool tree_strokes = false, other_strokes = false;
  if (!strokes.empty()) {
    if (strokes.size() != display.size()) {
      throw InputError("the strokes are " + std::to_string(strokes.cols) + " x " +
                       std::to_string(strokes.rows) + " pixels, the photo " +
                       std::to_string(display.cols) + " x " +
                       std::to_string(display.rows) +
                       "; draw them on a picture of the photo's size");
    }
    const TrimapCounts counts = CountLabels(strokes);
    tree_strokes = counts.foreground > 0;
    other_strokes = counts.background > 0;
  }
  const bool carried = like != nullptr && !like->Empty();
  const bool taught = tree_strokes && other_strokes;  // Own strokes teach both mixtures
  const bool informed = taught || carried;

  // At the reduced size: the sky
  const cv::Size size = Reduced(display.size(), kWorkPixels);
  cv::Mat3f work;
  cv::resize(display, work, size, 0, 0, cv::INTER_AREA);
  cv::patchNaNs(work);
  cv::Mat3b picture;
  work.convertTo(picture, CV_8U, 255);
  const cv::Mat1b marked = ReducedStrokes(strokes, size);
  progress.Report(0.05);
  const Sky sky = FindSky(work, progress.Part(0.05, 0.4));
  AutomaticTrimap result;
  if (sky.share == 0 && !informed) {
    result.trimap = cv::Mat1b(display.size(), kTrimapUnknown);
    if (!strokes.empty()) strokes.copyTo(result.trimap);
    result.doubts = {
        "no sky along the upper border: draw a stroke on the tree and one on what is "
        "not"};
    progress.Report(1.0);
    return result;
  }

  // The tree: before the sky what differs from it, elsewhere what GrabCut separates
  Standing standing = BeforeTheSky(sky, marked, options);
  cv::Mat1b main = MainPiece(standing.weak, standing.strong, marked);
  const int below = sky.horizon + 1;
  cv::Mat1b tree = standing.weak.clone();
  if (below < size.height) {
    const int first = informed ? 0 : std::max(0, below - size.height / 8);
    const cv::Mat1b cut = Cut(picture,
                              CutMask(sky, standing, main, marked, informed),
                              first,
                              carried && !taught ? *like : ColorModels{},
                              progress.Part(0.4, 0.6));
    cut.rowRange(below, size.height).copyTo(tree.rowRange(below, size.height));
    if (sky.share > 0) KeepWhatIsHeld(tree, sky.horizon, marked);
  }
  if (informed && sky.share > 0) {
    const ColorModels models = taught ? LearnModels(picture, marked) : *like;
    if (!models.Empty()) {
      tree.setTo(
          0,
          UnlikeTree(picture, standing.strong, models) & (marked != kTrimapForeground));
    }
  }
  const cv::Mat1b solid =
      standing.strong | (sky.share > 0 ? cv::Mat1b(size, std::uint8_t{0}) : tree);
  main = MainPiece(tree, solid, marked);
  tree &= main;
  progress.Report(0.65);

  // Zones: (M10) decides above the horizon, a band around the cut is unknown below it
  const int band = std::max(2, cvRound(options.ground_band * size.height));
  cv::Mat1b zone(size, kTrimapBackground);
  zone.setTo(kTrimapUnknown, Dilated(tree, band));
  zone.setTo(kTrimapForeground, Eroded(tree, band));
  if (below > 0) {
    cv::Mat1b above = zone.rowRange(0, below);
    above.setTo(kTrimapBackground);
    above.setTo(kDecide, Dilated(tree, 2).rowRange(0, below));
  }
  result.models =
      LearnModels(picture, Decided(work, sky, zone, options, progress.Part(0.65, 0.7)));
  result.trimap = Decided(display, sky, zone, options, progress.Part(0.7, 1.0));
  if (!strokes.empty()) {
    strokes.copyTo(result.trimap, strokes != kTrimapUnknown);
  }
  Judge(sky, tree, other_strokes, informed, result);
  return result;
}

}  // namespace relight
