// SPDX-License-Identifier: Apache-2.0
#include "matting/automatic_trimap.h"

#include "matting/sky_behind.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace relight {
namespace {

constexpr int kWorkPixels = 400000;  // Sky, ground and crown are told apart at this size.
constexpr int kCutPixels = 40000;    // A graph cut cannot be stopped half-way.
constexpr double kEdgeContrast = 0.6;  // Of (M10): a leaf's rim is still mostly leaf.
constexpr int kLeastToLearn = 20;      // Fewer pixels do not teach a mixture.
constexpr int kTwigGap = 3;            // At the reduced size.
constexpr std::uint8_t kDecide = 64;   // Of a zone: (M10) decides at the photo's size.

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

// The least and the most of a square around each pixel.
struct Extremes {
  cv::Mat1f least, most;
};

Extremes ExtremesAround(const cv::Mat1f& values, int side) {
  Extremes around;
  cv::erode(values, around.least, cv::Mat::ones(side, side, CV_8U));
  cv::dilate(values, around.most, cv::Mat::ones(side, side, CV_8U));
  return around;
}

// The photo at the reduced size, and what is known before the tree is looked for.
struct Scene {
  cv::Mat3f display;
  cv::Mat3b picture;                           // The same in bytes.
  cv::Mat1b strokes;                           // Labels; unknown where none is.
  bool taught = false, ground_marked = false;  // Strokes of both kinds; of background.
  ColorModels carried;  // From another photo; none if this one's own strokes teach.
  SkyBehind sky;

  bool Informed() const { return taught || !carried.Empty(); }
};

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

// Runs GrabCut from `first_row` on, at a small size; 255 is tree. Carried models are
// kept, else they are learned from the mask.
cv::Mat1b Cut(const Scene& scene,
              const cv::Mat1b& mask,
              int first_row,
              const Progress& progress) {
  const cv::Mat part = scene.picture.rowRange(first_row, mask.rows);
  const cv::Size size = Reduced(part.size(), kCutPixels);
  cv::Mat small;
  cv::Mat1b labels;
  cv::resize(part, small, size, 0, 0, cv::INTER_AREA);
  cv::resize(mask.rowRange(first_row, mask.rows), labels, size, 0, 0, cv::INTER_NEAREST);
  const auto is_tree = [&] { return cv::Mat1b((labels & cv::GC_FGD) != 0); };
  const int pixels = cv::countNonZero(is_tree()), others = size.area() - pixels;
  const bool keep = !scene.carried.Empty();
  if (keep || std::min(pixels, others) >= kLeastToLearn) {
    const FixedRandom fixed_random;
    cv::Mat tree = scene.carried.foreground.clone();
    cv::Mat other = scene.carried.background.clone();
    const int rounds = keep ? 1 : 3;
    for (int round = 0; round < rounds; ++round) {
      const int mode = keep         ? cv::GC_EVAL_FREEZE_MODEL
                       : round == 0 ? cv::GC_INIT_WITH_MASK
                                    : cv::GC_EVAL;
      cv::grabCut(small, labels, {}, other, tree, 1, mode);
      progress.Report((round + 1.0) / rounds);
    }
  }
  cv::Mat1b tree(mask.size(), std::uint8_t{0}), at_size;
  cv::resize(is_tree(), at_size, part.size(), 0, 0, cv::INTER_LINEAR);
  cv::Mat1b(at_size > 127).copyTo(tree.rowRange(first_row, mask.rows));
  return tree;
}

// Mixtures of the pixels labelled foreground and of those labelled background.
ColorModels LearnModels(const cv::Mat3b& picture, const cv::Mat1b& labels) {
  ColorModels models;
  const TrimapCounts counts = CountLabels(labels);
  if (std::min(counts.foreground, counts.background) < kLeastToLearn) return models;
  constexpr int kMost = 20000;
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
  const cv::Mat row = cv::Mat3b(colors, true).reshape(3, 1);
  auto& [tree, other] = models;
  cv::grabCut(row, mask_row, {}, other, tree, 1, cv::GC_INIT_WITH_MASK);
  return models;
}

// A Gaussian of a mixture.
struct Gaussian {
  Eigen::Vector3d mean;
  Eigen::Matrix3d inverse;
  double weight;
};

std::vector<Gaussian> Gaussians(const cv::Mat& model) {
  std::vector<Gaussian> mixture;
  const double* m = model.ptr<double>();
  for (int i = 0; i < 5; ++i) {
    if (m[i] <= 0) continue;
    const Eigen::Matrix3d covariance = Eigen::Map<const Eigen::Matrix3d>(m + 20 + 9 * i) +
                                       0.01 * Eigen::Matrix3d::Identity();
    mixture.push_back({Eigen::Map<const Eigen::Vector3d>(m + 5 + 3 * i),
                       covariance.inverse(),
                       m[i] / std::sqrt(covariance.determinant())});
  }
  return mixture;
}

// ln of a mixture's density at a colour: of all its Gaussians, where [Rother04] takes one
double LogDensity(const std::vector<Gaussian>& mixture, const cv::Vec3b& color) {
  double density = 1e-30;  // Of a colour far from all
  for (const auto& [mean, inverse, weight] : mixture) {
    const Eigen::Vector3d c = Eigen::Vector3d(color[0], color[1], color[2]) - mean;
    density += weight * std::exp(-0.5 * c.dot(inverse * c));
  }
  return std::log(density);
}

// Where colours say, over a neighbourhood of the strong pixels, that it is no tree.
cv::Mat1b UnlikeTree(const cv::Mat3b& picture,
                     const cv::Mat1b& strong,
                     const ColorModels& models) {
  const auto tree = Gaussians(models.foreground), other = Gaussians(models.background);
  cv::Mat1f sum(picture.size(), 0.0f), weight(picture.size(), 0.0f);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      if (strong(y, x) == 0) continue;
      const cv::Vec3b& color = picture(y, x);
      sum(y, x) = static_cast<float>(LogDensity(tree, color) - LogDensity(other, color));
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
  const int side = 2 * std::max(1, cvRound(std::sqrt(tree.total()) / 100)) + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::Mat1b closed;
  cv::morphologyEx(tree, closed, cv::MORPH_CLOSE, disc);
  cv::Mat1i piece_at;
  const auto count =
      static_cast<std::size_t>(cv::connectedComponents(closed, piece_at, 8, CV_32S));
  std::vector<int> solid_pixels(count, 0);
  std::vector<std::uint8_t> chosen(count, 0);
  bool any = false;
  for (int y = 0; y < tree.rows; ++y) {
    for (int x = 0; x < tree.cols; ++x) {
      const auto piece = static_cast<std::size_t>(piece_at(y, x));
      if (piece == 0) continue;
      if (solid(y, x) != 0) ++solid_pixels[piece];
      if (strokes(y, x) != kTrimapForeground) continue;
      chosen[piece] = 255;
      any = true;
    }
  }
  const auto most = std::max_element(solid_pixels.begin(), solid_pixels.end());
  if (!any && *most > 0) {
    chosen[static_cast<std::size_t>(most - solid_pixels.begin())] = 255;
  }
  cv::Mat1b main(tree.size());
  std::transform(piece_at.begin(), piece_at.end(), main.begin(), [&](int piece) {
    return chosen[static_cast<std::size_t>(piece)];
  });
  return main;
}

// Labels of a photo of any size: those of `zone` (of any size), and (M10) where it says
// so.
cv::Mat1b Decided(const cv::Mat3f& display,
                  const SkyBehind& sky,
                  const cv::Mat1b& zone,
                  const AutomaticTrimapOptions& options,
                  const Progress& progress) {
  const int rows = display.rows, cols = display.cols;
  const double sky_most = options.sky_tolerance * SkySpread(display, sky);
  const double tree_least = options.foreground_contrast * sky.contrast;
  cv::Mat1b trimap(display.size());
  const auto decide = [&](int begin, int end) {
    const int first = std::max(begin - 1, 0), last = std::min(end + 1, rows);
    cv::Mat1f distance;
    Extremes around;
    for (int y = begin; y < end; ++y) {
      const std::uint8_t* zones = zone.ptr(static_cast<int>(1LL * y * zone.rows / rows));
      for (int x = 0; x < cols; ++x) {
        trimap(y, x) = zones[1LL * x * zone.cols / cols];
        if (trimap(y, x) != kDecide) continue;
        if (distance.empty()) {
          distance = DistanceToSky(display.rowRange(first, last), first, rows, sky);
          around = ExtremesAround(distance, 3);
        }
        const bool is_tree = distance(y - first, x) > tree_least &&
                             around.least(y - first, x) > kEdgeContrast * sky.contrast;
        trimap(y, x) = around.most(y - first, x) < sky_most ? kTrimapBackground
                       : is_tree                            ? kTrimapForeground
                                                            : kTrimapUnknown;
      }
    }
  };
  ParallelRanges(rows, 32, decide, progress);
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

Standing BeforeTheSky(const Scene& scene, const AutomaticTrimapOptions& options) {
  const SkyBehind& sky = scene.sky;
  Standing standing{sky.distance > options.sky_tolerance * sky.spread,
                    sky.distance > options.foreground_contrast * sky.contrast};
  standing.weak.rowRange(sky.horizon + 1, standing.weak.rows).setTo(0);
  standing.weak.setTo(255, scene.strokes == kTrimapForeground);
  standing.weak.setTo(0, scene.strokes == kTrimapBackground);
  standing.strong &= standing.weak;

  // Faint and soft all around: cloud, not leaves
  const auto [least, most] = ExtremesAround(sky.distance, 5);
  standing.weak.setTo(0,
                      (most < 0.35 * sky.contrast) & (most - least < 0.2 * sky.contrast) &
                          (scene.strokes != kTrimapForeground));
  return standing;
}

// The last rows of sky, below the blurred horizon: what is like it there is no tree.
cv::Mat1b SkyAtTheHorizon(const SkyBehind& sky, const AutomaticTrimapOptions& options) {
  cv::Mat1b alike = sky.distance < options.sky_tolerance * sky.spread;
  const int below = sky.horizon + 1, rows = alike.rows;
  alike.rowRange(0, below).setTo(0);
  alike.rowRange(std::min(rows, below + std::max(5, rows / 80)), rows).setTo(0);
  return alike;
}

// How far each row may widen a tree that is seen before the ground: a trunk and drooping
// boughs by a pixel in three rows at most; what the ground can be neither in the sun nor
// in the shade, where the sky alone lights it, at any angle: it has other hues, at its
// own lightness; and what is as dark as ground in the shade not at all, for a shadow lies
// flat.
enum Widening : std::uint8_t { kSlow = 0, kFree = 255, kNone = 1 };

cv::Mat1b WideningBeforeGround(const Scene& scene) {
  constexpr double kHue = 10;    // Of a* and b*.
  constexpr double kDark = 0.6;  // Of the ground's L*.
  cv::Mat1b widening(scene.display.size(), kSlow);
  if (cv::countNonZero(scene.sky.ground) == 0) return widening;
  cv::Mat3f lab;
  cv::cvtColor(scene.display, lab, cv::COLOR_RGB2Lab);
  const auto hue_of = [&](const cv::Scalar& display) {
    cv::Mat3f one(1, 1, cv::Vec3f(display[0], display[1], display[2]));
    cv::cvtColor(one, one, cv::COLOR_RGB2Lab);
    const float lightness = std::max(one(0)[0], 1.0f);
    return cv::Vec2d(one(0)[1] / lightness, one(0)[2] / lightness);
  };
  const cv::Scalar ground = cv::mean(scene.display, scene.sky.ground);
  const cv::Scalar sky = cv::mean(scene.display, scene.sky.known);
  const cv::Vec2d sunlit = hue_of(ground);
  const double dark = kDark * cv::mean(lab, scene.sky.ground)[0];
  const cv::Vec2d way = hue_of(ground.mul(sky)) - sunlit;  // To the shade
  const double length = std::max(way.dot(way), 1e-9);
  for (int y = 0; y < lab.rows; ++y) {
    for (int x = 0; x < lab.cols; ++x) {
      const cv::Vec3f& c = lab(y, x);
      const double lightness = std::max(c[0], 1.0f);
      const cv::Vec2d hue = cv::Vec2d(c[1], c[2]) / lightness - sunlit;
      const double shade = std::clamp(hue.dot(way) / length, 0.0, 1.0);
      const bool is_ground = lightness * cv::norm(hue - shade * way) <= kHue;
      widening(y, x) = !is_ground ? kFree : lightness < dark ? kNone : kSlow;
    }
  }
  return widening;
}

// Leaves and twigs that hang before the ground, beside a tree: narrow, unlike the ground.
// None where the ground that is nowhere near the tree is as unlike itself.
cv::Mat1b HangingBefore(const cv::Mat1b& ground_rows,
                        const cv::Mat1b& tree,
                        const cv::Mat1b& widening) {
  constexpr double kMostElsewhere = 0.02;
  const int rows = tree.rows, side = std::max(3, rows / 20);
  cv::Mat1b unlike = (widening == kFree) & ground_rows & ~tree;
  const cv::Mat1b elsewhere = ground_rows & ~Dilated(tree, rows / 12);
  const double share = cv::countNonZero(unlike & elsewhere) /
                       std::max(1.0, 1.0 * cv::countNonZero(elsewhere));
  if (share > kMostElsewhere) return cv::Mat1b(tree.size(), std::uint8_t{0});
  cv::Mat1b wide;
  cv::morphologyEx(unlike, wide, cv::MORPH_OPEN, cv::Mat::ones(side, side, CV_8U));
  return unlike & ~wide;
}

// The mask that GrabCut starts from.
cv::Mat1b CutMask(const Scene& scene,
                  const Standing& standing,
                  const cv::Mat1b& main,
                  const AutomaticTrimapOptions& options) {
  const int rows = main.rows, below = scene.sky.horizon + 1, under = rows - below;
  cv::Mat1b mask(main.size(), static_cast<std::uint8_t>(cv::GC_PR_BGD));
  if (scene.sky.share > 0) {
    // Above the horizon the sky model knows
    const cv::Mat1b sky = standing.weak == 0, weak = standing.weak & main,
                    strong = standing.strong & main;
    cv::Mat1b above = mask.rowRange(0, below);
    above.setTo(cv::GC_BGD, sky.rowRange(0, below));
    above.setTo(cv::GC_PR_FGD, weak.rowRange(0, below));
    above.setTo(scene.Informed() ? cv::GC_PR_FGD : cv::GC_FGD, strong.rowRange(0, below));

    // What stands on the horizon may reach half-way down; the lowest fifth is ground
    const int from = std::max(0, below - std::max(2, rows / 50));
    for (int x = 0; x < main.cols; ++x) {
      if (cv::countNonZero(weak.col(x).rowRange(from, below)) > 0.9 * (below - from)) {
        mask(cv::Rect(x, below, 1, under / 2)).setTo(cv::GC_PR_FGD);
      }
    }
    mask.setTo(cv::GC_BGD, scene.sky.ground);
    mask.setTo(cv::GC_BGD, SkyAtTheHorizon(scene.sky, options));
    mask.rowRange(rows - under / 5, rows).setTo(cv::GC_BGD);
  }
  mask.setTo(cv::GC_BGD, scene.strokes == kTrimapBackground);
  mask.setTo(cv::GC_FGD, scene.strokes == kTrimapForeground);
  return mask;
}

// Takes away below the horizon what nothing holds from above. Twigs are lost here and
// there.
void KeepWhatIsHeld(cv::Mat1b& tree,
                    int horizon,
                    const cv::Mat1b& widening,
                    const cv::Mat1b& strokes) {
  for (int y = std::max(horizon + 1, 1); y < tree.rows; ++y) {
    for (int x = 0; x < tree.cols; ++x) {
      const bool free = widening(y, x) == kFree;
      const int reach = free ? 2 : widening(y, x) == kSlow && y % 3 == 0 ? 1 : 0;
      const int gap = free ? kTwigGap : 0;
      bool held = strokes(y, x) == kTrimapForeground;
      for (int j = std::max(0, y - 1 - gap); j < y; ++j) {
        for (int i = std::max(0, x - reach); i <= std::min(tree.cols - 1, x + reach); ++i)
          held = held || tree(j, i) != 0;
      }
      if (!held) tree(y, x) = 0;
    }
  }
}

// The tree: before the sky what differs from it, elsewhere what GrabCut separates.
cv::Mat1b FindTree(const Scene& scene,
                   const AutomaticTrimapOptions& options,
                   const Progress& progress) {
  const SkyBehind& sky = scene.sky;
  const Standing standing = BeforeTheSky(scene, options);
  cv::Mat1b tree = standing.weak.clone();
  const int rows = tree.rows, below = sky.horizon + 1;
  if (below < rows) {
    const cv::Mat1b main = MainPiece(standing.weak, standing.strong, scene.strokes);
    const int first = scene.Informed() ? 0 : std::max(0, below - rows / 8);
    const cv::Mat1b cut =
        Cut(scene, CutMask(scene, standing, main, options), first, progress);
    cut.rowRange(below, rows).copyTo(tree.rowRange(below, rows));
    if (sky.share > 0) {
      const cv::Mat1b widening = WideningBeforeGround(scene);
      cv::Mat1b ground_rows =
          (scene.strokes != kTrimapBackground) & ~SkyAtTheHorizon(sky, options);
      ground_rows.rowRange(0, below).setTo(0);
      tree |= HangingBefore(ground_rows, tree, widening);  // The cut leaves out thin ends
      KeepWhatIsHeld(tree, sky.horizon, widening, scene.strokes);
    }
  }
  if (scene.Informed() && sky.share > 0) {
    const ColorModels models =
        scene.taught ? LearnModels(scene.picture, scene.strokes) : scene.carried;
    if (!models.Empty()) {
      tree.setTo(0,
                 UnlikeTree(scene.picture, standing.strong, models) &
                     (scene.strokes != kTrimapForeground));
    }
  }
  const cv::Mat1b solid = sky.share > 0 ? standing.strong : standing.strong | tree;
  return tree & MainPiece(tree, solid, scene.strokes);
}

// (M10) decides above the horizon; below it a band around the cut is unknown.
cv::Mat1b Zones(const cv::Mat1b& tree, int horizon, double ground_band) {
  const int band = std::max(2, cvRound(ground_band * tree.rows));
  cv::Mat1b zone(tree.size(), kTrimapBackground);
  zone.setTo(kTrimapUnknown, Dilated(tree, band));
  zone.setTo(kTrimapForeground, ~Dilated(~tree, band));
  cv::Mat1b above = zone.rowRange(0, horizon + 1);
  above.setTo(kTrimapBackground);
  above.setTo(kDecide, Dilated(tree, 2).rowRange(0, horizon + 1));
  return zone;
}

// Lowers the confidence to a factor of it; a small one gives the user the reason.
void Doubt(double factor, const char* words, AutomaticTrimap& result) {
  result.confidence *= std::clamp(factor, 0.0, 1.0);
  if (factor < 0.8) result.doubts.emplace_back(words);
}

// Doubts of a tree that colours tell apart from the sky alone: is all of it the tree?
void JudgeShape(const cv::Mat1b& tree,
                int horizon,
                bool ground_marked,
                AutomaticTrimap& result) {
  const cv::Rect box = cv::boundingRect(tree);
  const int at_sides =
      cv::countNonZero(tree.col(0)) + cv::countNonZero(tree.col(tree.cols - 1));
  Doubt(std::max(0.4, 1 - 2.0 * at_sides / box.height),
        "the tree reaches the left or right border: if other things stand beside it, "
        "draw strokes on the tree and on them",
        result);
  const int foot = box.br().y;
  if (horizon + 5 >= tree.rows) {
    Doubt(0.7,
          "sky down to the lower border: if there is ground, draw strokes on the tree "
          "and on the ground",
          result);
  } else if (foot <= horizon + tree.rows / 50) {
    Doubt(0.5, "the tree ends at the horizon: draw a stroke on its trunk", result);
  } else if (!ground_marked) {
    // A trunk is narrow somewhere between the horizon and the foot
    const int last = foot - std::max(0, foot - horizon) / 5;
    int widest = 1, narrowest = tree.cols;
    for (int y = box.y; y < foot; ++y) {
      const int width = cv::countNonZero(tree.row(y));
      widest = std::max(widest, width);
      if (y >= horizon && y <= last) narrowest = std::min(narrowest, width);
    }
    Doubt(std::max(0.5, 1.2 - 1.0 * narrowest / widest),
          "the tree is wide where it meets the ground: draw a background stroke on the "
          "ground",
          result);
  }
}

// How far the tree can be trusted: the doubts, each with the factor it leaves.
void Judge(const Scene& scene, const cv::Mat1b& tree, AutomaticTrimap& result) {
  const SkyBehind& sky = scene.sky;
  result.confidence = 1;
  if (cv::countNonZero(tree) == 0) {
    Doubt(0, "no tree found: draw a stroke on the tree", result);
  } else if (sky.share == 0) {
    Doubt(0.5,
          "no sky at the upper border: look at the result, add strokes if needed",
          result);
  } else {
    Doubt(2 * sky.share,
          "little sky at the upper border: draw a stroke on the sky and one on the tree",
          result);
    // Sure sky and sure leaves are apart when the contrast is 4 t spreads and more
    Doubt(sky.contrast / (12 * sky.spread),
          "the tree hardly differs from the sky: draw strokes on both",
          result);
    if (!scene.Informed()) JudgeShape(tree, sky.horizon, scene.ground_marked, result);
  }
}

Scene MakeScene(const cv::Mat3f& display,
                const cv::Mat1b& strokes,
                const ColorModels* like,
                const Progress& progress) {
  Scene scene;
  if (!strokes.empty()) {
    const TrimapCounts counts = CountLabels(strokes);
    scene.ground_marked = counts.background > 0;
    scene.taught = counts.foreground > 0 && counts.background > 0;
  }
  if (like != nullptr && !scene.taught) scene.carried = *like;
  const cv::Size size = Reduced(display.size(), kWorkPixels);
  cv::resize(display, scene.display, size, 0, 0, cv::INTER_AREA);
  cv::patchNaNs(scene.display);
  scene.display.convertTo(scene.picture, CV_8U, 255);
  scene.strokes = ReducedStrokes(strokes, size);
  progress.Report(0.1);
  scene.sky = FindSky(scene.display, progress.Part(0.1, 1.0));
  return scene;
}

}  // namespace

AutomaticTrimap EstimateTrimap(const cv::Mat3f& display,
                               const cv::Mat1b& strokes,
                               const ColorModels* like,
                               const AutomaticTrimapOptions& options,
                               const Progress& progress) {
  CheckFields(options);
  if (display.empty()) throw InputError("the photo is empty (0 x 0 pixels)");
  if (!strokes.empty() && strokes.size() != display.size()) {
    const auto words = [](cv::Size size) {
      return std::to_string(size.width) + " x " + std::to_string(size.height);
    };
    throw InputError("the strokes are " + words(strokes.size()) + " pixels, the photo " +
                     words(display.size()) +
                     "; draw them on a picture of the photo's size");
  }
  const Scene scene = MakeScene(display, strokes, like, progress.Part(0, 0.4));
  AutomaticTrimap result;
  if (scene.sky.share == 0 && !scene.Informed()) {
    result.trimap = cv::Mat1b(display.size(), kTrimapUnknown);
    result.doubts = {
        "no sky along the upper border: draw a stroke on the tree and one on what is "
        "not"};
    progress.Report(1.0);
  } else {
    const cv::Mat1b tree = FindTree(scene, options, progress.Part(0.4, 0.6));
    const cv::Mat1b zone = Zones(tree, scene.sky.horizon, options.ground_band);
    const auto decided = [&](const cv::Mat3f& at_size, double from, double to) {
      return Decided(at_size, scene.sky, zone, options, progress.Part(from, to));
    };
    result.models = LearnModels(scene.picture, decided(scene.display, 0.65, 0.7));
    result.trimap = decided(display, 0.7, 1.0);
    Judge(scene, tree, result);
  }
  if (!strokes.empty()) strokes.copyTo(result.trimap, strokes != kTrimapUnknown);
  return result;
}

bool IsBeforeSky(const cv::Mat3f& display,
                 const cv::Mat1b& trimap,
                 const Progress& progress) {
  const cv::Size size = Reduced(display.size(), kWorkPixels);
  cv::Mat3f small;
  cv::resize(display, small, size, 0, 0, cv::INTER_AREA);
  cv::patchNaNs(small);
  const SkyBehind sky = FindSky(small, progress);
  if (sky.share < 0.5) return false;
  cv::Mat1b labels;
  cv::resize(trimap, labels, size, 0, 0, cv::INTER_NEAREST);
  const cv::Mat1b background = labels == kTrimapBackground;
  return 2 * cv::countNonZero(background & sky.known) > cv::countNonZero(background);
}

}  // namespace relight
