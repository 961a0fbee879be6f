// SPDX-License-Identifier: Apache-2.0
#include "matting/sky_behind.h"

#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <vector>

namespace relight {
namespace {

constexpr int kCell = 8;  // The sky's colour is smooth: one in 8 x 8 pixels.

cv::Mat3f LabFromDisplay(const cv::Mat3f& display) {
  cv::Mat3f lab;
  cv::cvtColor(display, lab, cv::COLOR_RGB2Lab);
  cv::patchNaNs(lab);
  return lab;
}

// The value that `share` of those under the mask stay below; 0 for none.
double Quantile(const cv::Mat1f& values, const cv::Mat1b& mask, double share) {
  std::vector<float> in;
  auto shown = mask.begin();
  for (const float value : values) {
    if (*shown++ != 0) in.push_back(value);
  }
  if (in.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * (1.0 * in.size() - 1));
  const auto at = in.begin() + rank;
  std::nth_element(in.begin(), at, in.end());
  return *at;
}

// Standard deviation by the median, which leaves among the sky do not move.
double Spread(const cv::Mat1f& distance, const cv::Mat1b& sky) {
  return 1.5 * Quantile(distance, sky, 0.5);
}

// The lowest row with more than `count` pixels of the mask; -1 for none.
int LowestRow(const cv::Mat1b& mask, double count) {
  int y = mask.rows - 1;
  while (y >= 0 && cv::countNonZero(mask.row(y)) <= count) --y;
  return y;
}

// The two cells a pixel lies between along one side of the picture.
struct Between {
  int low, high;
  float share;  // Of `high`.
};

Between CellsAt(int pixel, int pixels, int cells) {
  const double at = (pixel + 0.5) * cells / pixels - 0.5;
  const int low = std::clamp(cvFloor(at), 0, cells - 1);
  const auto share = static_cast<float>(std::clamp(at - low, 0.0, 1.0));
  return {low, std::min(low + 1, cells - 1), share};
}

// d of (M9), of colours in CIELAB.
cv::Mat1f Distance(const cv::Mat3f& lab, int first, int photo_rows, const cv::Mat3f& s) {
  cv::Mat1f distance(lab.size());
  for (int y = 0; y < lab.rows; ++y) {
    const auto [y0, y1, v] = CellsAt(first + y, photo_rows, s.rows);
    for (int x = 0; x < lab.cols; ++x) {
      const auto [x0, x1, u] = CellsAt(x, lab.cols, s.cols);
      const cv::Vec3f there = (1 - v) * ((1 - u) * s(y0, x0) + u * s(y0, x1)) +
                              v * ((1 - u) * s(y1, x0) + u * s(y1, x1));
      distance(y, x) = static_cast<float>(cv::norm(lab(y, x) - there));
    }
  }
  return distance;
}

cv::Mat Shrunk(const cv::Mat& field, cv::Size size) {
  cv::Mat shrunk;
  cv::resize(field, shrunk, size, 0, 0, cv::INTER_AREA);
  return shrunk;
}

// Fills a field in from what is known of it: `sum` is the value times `weight`, the share
// of each cell that is known. What a cell lacks comes from cells of twice its size.
cv::Mat3f FilledIn(const cv::Mat3f& sum, const cv::Mat1f& weight) {
  cv::Mat3f filled(sum.size(), cv::Vec3f::all(0));
  if (sum.rows > 1 || sum.cols > 1) {
    const cv::Size half((sum.cols + 1) / 2, (sum.rows + 1) / 2);
    cv::resize(FilledIn(Shrunk(sum, half), Shrunk(weight, half)), filled, sum.size());
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

// What each row's sky is besides its gradient, in the median: near the horizon a sky
// darkens or whitens faster than a quadratic follows. Rows that show little sky take it
// from those around.
void AddRows(const cv::Mat3f& lab, const cv::Mat1b& sky, cv::Mat3f& gradient) {
  cv::Mat3f sum(lab.rows, 1, cv::Vec3f::all(0));
  cv::Mat1f weight(lab.rows, 1, 0.0f);
  std::vector<cv::Mat1f> left;
  cv::split(lab - gradient, left);
  for (int y = 0; y < lab.rows; ++y) {
    const int shown = cv::countNonZero(sky.row(y));
    weight(y) = static_cast<float>(shown) / static_cast<float>(lab.cols);
    for (int c = 0; c < 3 && shown > 0; ++c) {
      const cv::Mat1f& channel = left[static_cast<std::size_t>(c)];
      sum(y)[c] =
          weight(y) * static_cast<float>(Quantile(channel.row(y), sky.row(y), 0.5));
    }
  }
  const cv::Mat3f medians = FilledIn(sum, weight);
  for (int y = 0; y < lab.rows; ++y) {
    for (int x = 0; x < lab.cols; ++x) gradient(y, x) += medians(y);
  }
}

// The sky's gradient, linear across and quadratic in height, and what rows are besides,
// over the whole picture: what the open sky says of places where none is seen nearby.
// Clouds among it are left out.
cv::Mat3f SkyGradient(const cv::Mat3f& lab, const cv::Mat1b& sky) {
  const int lowest = LowestRow(sky, 0);
  const auto basis = [&](int x, int y) {  // Below the lowest sky nothing is extrapolated
    const double u = 2.0 * x / lab.cols - 1, v = 1.0 * std::min(y, lowest) / lab.rows;
    return Eigen::Vector4d(1, u, v, v * v);
  };
  cv::Mat3f gradient(lab.size());
  cv::Mat1f residual(lab.size(), 0.0f);
  for (int round = 0; round < 4; ++round) {
    const double limit = std::max(3.0, 3 * Spread(residual, sky));
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
    const Eigen::Matrix<double, 4, 3> fit = square.ldlt().solve(right);
    for (int y = 0; y < lab.rows; ++y) {
      for (int x = 0; x < lab.cols; ++x) {
        const Eigen::RowVector3f c = (basis(x, y).transpose() * fit).cast<float>();
        gradient(y, x) = {c[0], c[1], c[2]};
        residual(y, x) = static_cast<float>(cv::norm(lab(y, x) - gradient(y, x)));
      }
    }
  }
  AddRows(lab, sky, gradient);
  return gradient;
}

// A smooth piece of the picture; what is not smooth is an empty one, the first.
struct Piece {
  int pixels = 0, at_top = 0;
  cv::Vec3d color{0, 0, 0}, color_at_top{0, 0, 0};  // Means.
  double distance = 0;                              // Summed.
  bool sky = false, ground = false;                 // Ground is at the lower border.
};

struct Pieces {
  cv::Mat1i index;  // Of the piece of a pixel.
  std::vector<Piece> all;
  Piece& Of(int i) { return all[static_cast<std::size_t>(i)]; }
};

cv::Mat1b Where(Pieces& pieces, bool Piece::*is) {
  cv::Mat1b mask(pieces.index.size());
  auto out = mask.begin();
  for (const int i : pieces.index) *out++ = pieces.Of(i).*is ? 255 : 0;
  return mask;
}

// Smooth: colours spread no more than a noisy sky's at the upper border, at most 8.
cv::Mat1b IsSmooth(const cv::Mat3f& lab, int edge) {
  cv::Mat mean, square;
  cv::blur(lab, mean, {5, 5});
  cv::blur(lab.mul(lab), square, {5, 5});
  const cv::Mat3f variance = square - mean.mul(mean);
  cv::Mat1f spread(lab.size());
  auto out = spread.begin();
  for (const cv::Vec3f& v : variance)
    *out++ = std::sqrt(std::max(0.0f, v[0] + v[1] + v[2]));
  const cv::Mat1f top = spread.rowRange(0, edge);
  const double noise = Quantile(top, top >= 0, 0.25);
  return spread < std::clamp(2 * noise, 3.0, 8.0);
}

// The pieces, of which some are sky and others ground, at the lower border.
Pieces FindPieces(const cv::Mat3f& lab, int edge) {
  Pieces pieces;
  const int count = cv::connectedComponents(IsSmooth(lab, edge), pieces.index, 4, CV_32S);
  pieces.all.resize(static_cast<std::size_t>(count));
  for (int y = 0; y < lab.rows; ++y) {
    for (int x = 0; x < lab.cols; ++x) {
      Piece& piece = pieces.Of(pieces.index(y, x));
      ++piece.pixels;
      piece.color += lab(y, x);
      if (y < edge) {
        ++piece.at_top;
        piece.color_at_top += lab(y, x);
      }
      if (y >= lab.rows - edge) piece.ground = true;
    }
  }
  pieces.all[0] = {};

  // Sky begins at the upper border. It is blue there, or bright (L* 75 is half of white's
  // luminance, which clouds reach in any usual exposure): not lawn, leaves or asphalt.
  for (Piece& piece : pieces.all) {
    piece.color *= 1.0 / std::max(piece.pixels, 1);
    piece.color_at_top *= 1.0 / std::max(piece.at_top, 1);
    const double lightness = piece.color_at_top[0], yellow = piece.color_at_top[2];
    piece.sky = piece.at_top > 0 && (yellow < -5 || (lightness > 75 && yellow < 10));
    piece.ground = piece.ground && !piece.sky;
  }
  return pieces;
}

// s of (M9) from the sky known so far, and what follows from it.
void FindColor(const cv::Mat3f& lab,
               const cv::Mat3f& gradient,
               const cv::Mat1b& open,
               SkyBehind& sky) {
  const cv::Size cells((lab.cols + kCell - 1) / kCell, (lab.rows + kCell - 1) / kCell);
  cv::Mat3f left = lab - gradient;
  left.setTo(cv::Scalar::all(0), sky.known == 0);
  cv::Mat weight;
  sky.known.convertTo(weight, CV_32F, 1.0 / 255);
  sky.color =
      Shrunk(gradient, cells) + FilledIn(Shrunk(left, cells), Shrunk(weight, cells));
  sky.distance = Distance(lab, 0, lab.rows, sky.color);
  sky.spread = std::max(1.0, Spread(sky.distance, open));
  sky.contrast = Quantile(sky.distance, sky.distance > 8 * sky.spread, 0.9);
}

// Sky is also each piece that is like the sky, and more so than like the ground, and
// single pixels like it with no tree beside them.
void FindMore(const cv::Mat3f& lab, Pieces& pieces, SkyBehind& sky) {
  const cv::Vec3d ground(cv::mean(lab, sky.ground).val);
  const bool has_ground = cv::countNonZero(sky.ground) > 0;
  for (Piece& piece : pieces.all) piece.distance = 0;
  auto d = sky.distance.begin();
  for (const int i : pieces.index) pieces.Of(i).distance += *d++;
  for (Piece& piece : pieces.all) {
    if (piece.sky || piece.ground || piece.pixels <= 12) continue;
    const double distance = piece.distance / piece.pixels;
    piece.sky = distance < 0.4 * sky.contrast &&
                (!has_ground || distance < cv::norm(piece.color - ground));
  }
  cv::Mat1b tree_near;
  cv::dilate(sky.distance > 6 * sky.spread, tree_near, cv::Mat());
  sky.known = Where(pieces, &Piece::sky) |
              ((sky.distance < 2 * sky.spread) & ~tree_near & ~sky.ground);
}

}  // namespace

SkyBehind FindSky(const cv::Mat3f& display, const Progress& progress) {
  const cv::Mat3f lab = LabFromDisplay(display);
  const int edge = std::max(1, lab.rows / 50);
  Pieces pieces = FindPieces(lab, edge);
  SkyBehind sky;
  sky.known = Where(pieces, &Piece::sky);
  sky.ground = Where(pieces, &Piece::ground);
  sky.distance = cv::Mat1f(lab.size(), 0.0f);
  cv::Mat1b open_columns;
  cv::reduce(sky.known.rowRange(0, edge), open_columns, 0, cv::REDUCE_MAX);
  const int open = cv::countNonZero(open_columns);
  if (3 * open < lab.cols) return sky;  // A road or a lake may be as little
  sky.share = static_cast<double>(open) / lab.cols;
  progress.Report(0.2);

  // It goes on behind the tree: what is alike is sky too, and tells its colour
  const cv::Mat1b open_sky = sky.known.clone();
  const cv::Mat3f gradient = SkyGradient(lab, open_sky);
  for (int round = 0; round < 4; ++round) {
    if (round > 0) FindMore(lab, pieces, sky);
    FindColor(lab, gradient, open_sky, sky);
    progress.Report(0.4 + 0.2 * round);
  }
  sky.horizon = std::max(0, LowestRow(sky.known, 0.02 * lab.cols) - 3);
  return sky;
}

cv::Mat1f DistanceToSky(const cv::Mat3f& display_rows,
                        int first,
                        int photo_rows,
                        const SkyBehind& sky) {
  return Distance(LabFromDisplay(display_rows), first, photo_rows, sky.color);
}

double SkySpread(const cv::Mat3f& display, const SkyBehind& sky) {
  if (sky.share == 0) return sky.spread;
  constexpr int kSamples = 16;
  const int rows = display.rows, cols = display.cols;
  cv::Mat1f distance(kSamples, cols);
  cv::Mat1b known(kSamples, cols);
  for (int i = 0; i < kSamples; ++i) {
    const int y = static_cast<int>((i + 0.5) * rows / kSamples);
    const int row = static_cast<int>(1LL * y * sky.known.rows / rows);
    DistanceToSky(display.row(y), y, rows, sky).copyTo(distance.row(i));
    cv::resize(sky.known.row(row), known.row(i), {cols, 1}, 0, 0, cv::INTER_NEAREST);
  }
  return std::max(sky.spread, Spread(distance, known));
}

}  // namespace relight
