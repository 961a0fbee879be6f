// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/sky_in_photo.h"

#include "matting/sky_behind.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/capture/capture_folder.h"
#include "relight/capture/capture_times.h"
#include "relight/capture/view_matte.h"
#include "relight/photo/color.h"
#include "relight/photo/read_photo.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr int kLongest_px = 600;       // Photos are looked at no larger for their air,
constexpr int kLongestOfSky_px = 800;  // nor for where their sky ends.
constexpr int kBlock_px = 12;
constexpr float kTreeAlpha = 0.02f;
constexpr double kSmooth = 0.02;  // Of ln Y within a block, beside the noise of 8 bits.
constexpr double kStep = 0.12;    // From a block to the next, in any channel's logarithm.
// Where little is left so: skies whose colours a camera deepens change faster, and have
// hardly any red.
constexpr std::size_t kLittle = 60;
constexpr double kDeepStep = 0.3;
constexpr double kLeastShare = 0.05;  // Of the luminance: less red is not compared.
constexpr std::size_t kMostPhotos = 6;

// A photo's copy that is looked at; more would only cost time.
template <class Image>
Image Small(const Image& image, int longest_px) {
  const double shrink =
      std::max(image.cols, image.rows) / static_cast<double>(longest_px);
  if (shrink <= 1) return image;
  Image small;
  cv::resize(image,
             small,
             {std::max(1, static_cast<int>(std::lround(image.cols / shrink))),
              std::max(1, static_cast<int>(std::lround(image.rows / shrink)))},
             0,
             0,
             cv::INTER_AREA);
  return small;
}

// A matte with what is near it; the one that is given, which may be the caller's, stays.
cv::Mat1f Grown(const cv::Mat1f& alpha, int side_px) {
  cv::Mat1f grown;
  cv::dilate(alpha, grown, cv::getStructuringElement(cv::MORPH_RECT, {side_px, side_px}));
  return grown;
}

template <class Color>
double Luminance(const Color& c) {
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

struct Block {
  bool tree = false;  // Too much tree in it to see what is behind.
  bool even = false;  // All alike, neither black nor at the limit.
  Eigen::Array3d color = Eigen::Array3d::Zero();
};

Block BlockAt(const cv::Mat3f& pixels,
              const cv::Mat1f& alpha,
              const cv::Rect& at,
              bool is_deep) {
  const float limit = LinearFromSrgb(252.0f / 255), black = LinearFromSrgb(12.0f / 255);
  Block block;
  double sum = 0, square = 0;
  int count = 0, tree = 0;
  for (int row = at.y; row < at.y + at.height; ++row) {
    for (int column = at.x; column < at.x + at.width; ++column) {
      if (alpha(row, column) > kTreeAlpha) {
        ++tree;
        continue;
      }
      const cv::Vec3f& c = pixels(row, column);
      const double luminance = Luminance(c);
      const double darkest = is_deep ? luminance : std::min({c[0], c[1], c[2]});
      if (!(darkest > black) || std::max({c[0], c[1], c[2]}) > limit) return block;
      const double log_luminance = std::log(luminance);
      sum += log_luminance;
      square += log_luminance * log_luminance;
      for (int i = 0; i < 3; ++i) block.color[i] += c[i];
      ++count;
    }
  }
  block.tree = tree > 0;
  if (block.tree) return block;
  block.color /= count;
  const double mean = sum / count;
  // A step of 8 bits in the darkest sky, and a gradient across the block
  block.even = std::sqrt(std::max(0.0, square / count - mean * mean)) < 2 * kSmooth;
  return block;
}

// So that hardly any red is not compared.
Eigen::Array3d Compared(const Eigen::Array3d& color) {
  return color.max(kLeastShare * Luminance(color));
}

std::string SunText(const Eigen::Vector3d& sun) {
  return std::to_string(sun.x()) + " " + std::to_string(sun.y()) + " " +
         std::to_string(sun.z());
}

}  // namespace

std::vector<SkySample> SkySamples(const cv::Mat3f& all_pixels,
                                  const cv::Mat1f& all_alpha,
                                  const Camera& full_camera,
                                  const Eigen::Vector3d& sun_in_world,
                                  int photo) {
  const cv::Mat3f pixels = Small(all_pixels, kLongest_px);
  // A matte ends softly: what is next to the tree is not the sky alone
  const cv::Mat1f alpha = Grown(Small(all_alpha, kLongest_px), 5);
  Require(pixels.size() == alpha.size(), "photo and matte of one size");
  const Camera camera = full_camera.Resized(pixels.cols, pixels.rows);
  const auto samples_of = [&](bool is_deep) {
    const double step = is_deep ? kDeepStep : kStep;
    std::vector<SkySample> samples;
    for (int x = 0; x + kBlock_px <= pixels.cols; x += kBlock_px) {
      std::optional<Eigen::Array3d> above;
      for (int y = 0; y + kBlock_px <= pixels.rows; y += kBlock_px) {
        const Eigen::Vector3d direction =
            camera.RayInWorld({x + 0.5 * kBlock_px, y + 0.5 * kBlock_px});
        if (direction.z() <= 0) break;
        const Block block = BlockAt(pixels, alpha, {x, y, kBlock_px, kBlock_px}, is_deep);
        if (block.tree) continue;
        if (!block.even) break;
        const Eigen::Array3d color = is_deep ? Compared(block.color) : block.color;
        if (above && ((color / *above).log().abs() > step).any()) break;
        above = color;
        samples.push_back({direction, sun_in_world, block.color, photo});
      }
    }
    return samples;
  };
  const std::vector<SkySample> samples = samples_of(/*is_deep=*/false);
  return samples.size() < kLittle ? samples_of(/*is_deep=*/true) : samples;
}

cv::Mat1f SkyEnds(const cv::Mat3f& all_pixels,
                  const cv::Mat1f& all_alpha,
                  const Progress& progress) {
  Require(all_pixels.size() == all_alpha.size(), "photo and matte of one size");
  const cv::Mat3f pixels = Small(all_pixels, kLongestOfSky_px);
  // Beside the tree nothing is smooth, and so not known to be sky
  const cv::Mat1f alpha = Grown(Small(all_alpha, kLongestOfSky_px), 9);
  const SkyBehind sky = FindSky(DisplayFromLinear(pixels), progress);
  cv::Mat1f ends(1, pixels.cols, 0.0f);
  if (sky.share > 0) {
    const int most_between = pixels.rows / 50;
    std::vector<int> seen;  // Columns whose sky is seen to end, not behind the tree
    for (int x = 0; x < pixels.cols; ++x) {
      int end = 0, between = 0, y = 0;
      for (; y < pixels.rows && between <= most_between; ++y) {
        if (sky.known(y, x) != 0) {
          end = y + 1;
          between = 0;
        } else if (alpha(y, x) <= kTreeAlpha) {
          ++between;
        }
      }
      // The next row is sky and ground in one
      ends(x) = static_cast<float>(end == 0 ? 0 : std::min(end + 1, pixels.rows));
      const bool into_tree = end < pixels.rows && alpha(end, x) > kTreeAlpha;
      if (!into_tree) seen.push_back(x);
    }
    for (std::size_t i = 1; i < seen.size(); ++i) {
      for (int x = seen[i - 1] + 1; x < seen[i]; ++x) {
        const float u = static_cast<float>(x - seen[i - 1]) /
                        static_cast<float>(seen[i] - seen[i - 1]);
        ends(x) = std::max(ends(x), (1 - u) * ends(seen[i - 1]) + u * ends(seen[i]));
      }
    }
  }
  cv::Mat1f of_photo;
  cv::resize(ends, of_photo, {all_pixels.cols, 1}, 0, 0, cv::INTER_LINEAR);
  return of_photo * (static_cast<double>(all_pixels.rows) / pixels.rows);
}

TurbidityEstimate TurbidityOfCapture(const ViewPlan& plan,
                                     const std::map<std::string, Camera>& cameras,
                                     StageRecords& records) {
  const Capture& capture = *plan.capture;
  struct View {
    const ViewEntry* entry;
    const Camera* camera;
    Eigen::Vector3d sun;
  };
  std::vector<View> views;
  for (const ViewTime& at : ViewTimesOf(capture, plan.request.zone)) {
    const auto camera = cameras.find(at.view);
    if (camera == cameras.end() || !FileOfView(capture, "mattes", at.view)) continue;
    View view{&FindView(capture, at.view), &camera->second, plan.input.sun.direction};
    // Where the user told the time himself it is of all photos
    const bool own_time = at.time && plan.place && !plan.request.taken &&
                          !plan.request.lit_from && at.view != plan.name;
    if (own_time) view.sun = SolarPositionAt(at.time->utc, *plan.place).direction;
    views.push_back(view);
  }
  std::vector<View> chosen;
  const std::size_t count = std::min(kMostPhotos, views.size());
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(views[i * views.size() / count]);

  StageKey key("sky 3");
  key.Add(FieldsText(plan.options.photo));
  key.AddFile(capture.folder / "cameras" / "cameras.txt");
  key.AddFile(capture.folder / "cameras" / "images.txt");
  for (const View& view : chosen) {
    key.Add(SunText(view.sun)).AddFile(capture.PhotoOf(*view.entry));
    key.AddFile(*FileOfView(capture, "mattes", view.entry->name));
  }
  const fs::path file = fs::path("cache") / "sky.json";
  if (records.StateOf("sky", key.Hash()) == StageRecords::State::kUpToDate) {
    const auto json = nlohmann::json::parse(
        ReadText(capture.folder / file, 100'000), nullptr, /*allow_exceptions=*/false);
    if (json.is_object()) {
      return {.turbidity = json.at("turbidity"),
              .spread = json.at("spread"),
              .misfit = json.at("misfit"),
              .deepened = json.at("deepened"),
              .samples = json.at("samples"),
              .photos = json.at("photos"),
              .sure = json.at("sure"),
              .doubt = json.at("doubt")};
    }
  }

  std::vector<SkySample> samples;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const View& view = chosen[i];
    const Photo photo = ReadPhoto(capture.PhotoOf(*view.entry), plan.options.photo);
    if (!photo.alpha.empty()) continue;  // What is behind the tree is cut away
    const cv::Mat1f alpha = ReadMatteFor(*FileOfView(capture, "mattes", view.entry->name),
                                         photo.pixels.size(),
                                         capture.PhotoOf(*view.entry));
    const std::vector<SkySample> of_photo =
        SkySamples(photo.pixels, alpha, *view.camera, view.sun, static_cast<int>(i));
    samples.insert(samples.end(), of_photo.begin(), of_photo.end());
  }
  const TurbidityEstimate estimate = TurbidityFromSky(samples);
  const nlohmann::json json = {{"turbidity", estimate.turbidity},
                               {"spread", estimate.spread},
                               {"misfit", estimate.misfit},
                               {"deepened", estimate.deepened},
                               {"samples", estimate.samples},
                               {"photos", estimate.photos},
                               {"sure", estimate.sure},
                               {"doubt", estimate.doubt}};
  MakeFolderOf(capture.folder, "cache");
  WriteTextWhole(capture.folder / file, json.dump(1) + "\n");
  records.Remember("sky", key.Hash(), {file});
  return estimate;
}

}  // namespace relight
