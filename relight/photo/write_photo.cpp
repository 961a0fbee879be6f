// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/write_photo.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/base/write_file.h"
#include "relight/photo/color.h"
#include "relight/photo/picture_bytes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr int kRowsAtOnce = 16;
constexpr float kMaxHalf = 65504.f;
constexpr std::size_t kMaxProvenance = 30000;  // Twice and a half fits a JPEG's segment.

struct Extension {
  const char* name;
  PictureFormat format;
};
constexpr std::array kExtensions = {Extension{".exr", PictureFormat::kExr},
                                    Extension{".png", PictureFormat::kPng},
                                    Extension{".tif", PictureFormat::kTiff},
                                    Extension{".tiff", PictureFormat::kTiff},
                                    Extension{".jpg", PictureFormat::kJpeg},
                                    Extension{".jpeg", PictureFormat::kJpeg}};

PictureFormat FormatOf(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(
      extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
      });
  std::string known;
  for (const Extension& each : kExtensions) {
    if (extension == each.name) return each.format;
    known += (known.empty() ? "" : ", ") + std::string(each.name);
  }
  throw OptionError(path.string() + ": the extension must be one of " + known + ", got " +
                    (extension.empty() ? "none" : extension));
}

// One pixel as it goes into the file, and what had to be cut.
struct Counts {
  std::int64_t clipped = 0, negative = 0, non_finite = 0;
};

cv::Vec3f Counted(cv::Vec3f linear, float alpha, float largest, Counts* counts) {
  if (alpha <= 0.f) return linear;
  if (!std::isfinite(linear[0] + linear[1] + linear[2])) {
    ++counts->non_finite;
    return cv::Vec3f::all(0.f);
  }
  if (std::max({linear[0], linear[1], linear[2]}) > largest) ++counts->clipped;
  if (std::min({linear[0], linear[1], linear[2]}) < 0.f) ++counts->negative;
  return linear;
}

float FiniteOr0(float value) { return std::isfinite(value) ? value : 0.f; }

// Straight linear to premultiplied half.
struct ToHalf {
  using Sample = float;
  static constexpr float kLargest = kMaxHalf;
  static void Pixel(const cv::Vec3f& linear, float alpha, bool has_alpha, float* out) {
    for (int c = 0; c < 3; ++c) {
      out[c] = std::clamp(FiniteOr0(linear[c]) * alpha, -kMaxHalf, kMaxHalf);
    }
    if (has_alpha) out[3] = alpha;
  }
};

// Straight linear to straight sRGB of `Integer`.
template <class Integer>
struct ToDisplay {
  using Sample = Integer;
  static constexpr float kLargest = 1.f;
  static Integer Quantised(float value) {
    constexpr float kMax = std::numeric_limits<Integer>::max();
    return static_cast<Integer>(std::lround(std::clamp(value, 0.f, 1.f) * kMax));
  }
  static void Pixel(const cv::Vec3f& linear, float alpha, bool has_alpha, Integer* out) {
    for (int c = 0; c < 3; ++c) {
      const float value = std::clamp(FiniteOr0(linear[c]), 0.f, 1.f);
      out[c] = Quantised(SrgbFromLinear(value));
    }
    if (has_alpha) out[3] = Quantised(alpha);
  }
};

template <class Encoding>
WriteSummary Encode(const Photo& photo, cv::Mat* samples) {
  using Sample = typename Encoding::Sample;
  const bool has_alpha = !photo.alpha.empty();
  const int channels = has_alpha ? 4 : 3;
  samples->create(photo.pixels.size(),
                  CV_MAKETYPE(cv::DataType<Sample>::depth, channels));
  std::atomic<std::int64_t> clipped = 0, negative = 0, non_finite = 0;
  ParallelRanges(photo.pixels.rows, kRowsAtOnce, [&](int begin, int end) {
    Counts counts;
    for (int y = begin; y < end; ++y) {
      Sample* out = samples->ptr<Sample>(y);
      for (int x = 0; x < photo.pixels.cols; ++x, out += channels) {
        const float alpha =
            has_alpha ? std::clamp(FiniteOr0(photo.alpha(y, x)), 0.f, 1.f) : 1.f;
        const cv::Vec3f linear =
            Counted(photo.pixels(y, x), alpha, Encoding::kLargest, &counts);
        Encoding::Pixel(linear, alpha, has_alpha, out);
      }
    }
    clipped += counts.clipped;
    negative += counts.negative;
    non_finite += counts.non_finite;
  });
  return {.clipped_pixels = clipped,
          .negative_pixels = negative,
          .non_finite_pixels = non_finite};
}

}  // namespace

WriteSummary WritePhoto(const fs::path& path,
                        const Photo& photo,
                        const Provenance& provenance,
                        const WritePhotoOptions& options,
                        const cv::Mat1f& confidence) {
  CheckFields(options);
  Require(!photo.pixels.empty(), "a photo that is written has pixels");
  Require(photo.alpha.empty() || photo.alpha.size() == photo.pixels.size(),
          "alpha of the photo's size");
  Require(provenance.software.rfind("relight ", 0) == 0,
          "software named relight VERSION");
  Require(provenance.json.size() <= kMaxProvenance &&
              provenance.json.find('\0') == std::string::npos,
          "provenance of at most 30000 bytes, none of them 0");
  const PictureFormat format = FormatOf(path);
  const bool has_alpha = !photo.alpha.empty();
  if (format == PictureFormat::kJpeg && has_alpha) {
    throw OptionError(
        path.string() +
        ": a JPEG has no transparency; write .png, .tif or .exr, or the whole "
        "photo with --whole");
  }

  PictureToEncode picture{.channels = {"R", "G", "B"}, .quality = options.quality};
  if (has_alpha) {
    picture.channels.push_back("A");
    picture.alpha_channel = 3;
  }
  picture.metadata = {{"Software", provenance.software},
                      {"ImageDescription", provenance.json}};
  WriteSummary summary;
  if (format == PictureFormat::kExr) {
    picture.half = true;
    picture.display_encoded = false;
    summary = Encode<ToHalf>(photo, &picture.samples);
    if (!confidence.empty()) {
      Require(confidence.size() == photo.pixels.size(), "confidence of the photo's size");
      std::vector<cv::Mat> channels;
      cv::split(picture.samples, channels);
      channels.push_back(confidence);
      cv::merge(channels, picture.samples);
      picture.channels.push_back("confidence");
    }
  } else if (format == PictureFormat::kJpeg) {
    summary = Encode<ToDisplay<std::uint8_t>>(photo, &picture.samples);
  } else {
    summary = Encode<ToDisplay<std::uint16_t>>(photo, &picture.samples);
  }
  WriteTextWhole(path, EncodePicture(format, picture, path));
  return summary;
}

std::vector<std::string> WritableExtensions() {
  std::vector<std::string> names;
  names.reserve(kExtensions.size());
  for (const Extension& each : kExtensions) names.emplace_back(each.name);
  return names;
}

}  // namespace relight
