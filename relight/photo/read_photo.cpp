// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/read_photo.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"
#include "relight/photo/color_transform.h"
#include "relight/photo/picture_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <new>
#include <optional>

namespace relight {
namespace {

constexpr int kRowsAtOnce = 16;

// Which stored channels are red, green, blue and alpha.
struct ChannelMap {
  std::array<int, 3> rgb = {0, 0, 0};
  int alpha = -1;
};

ChannelMap ChannelsOf(const PictureFile& file) {
  const std::vector<std::string>& names = file.channels();
  const auto named = [&](const char* name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  };
  if (file.is_cmyk()) {
    file.Refuse("is CMYK, made for print; convert it to RGB (sRGB) first");
  }
  ChannelMap map;
  map.alpha = file.alpha_channel();

  // An EXR holds what its names say; the others are colours by their order
  if (file.format() == PictureFormat::kExr) {
    if (named("R") >= 0 && named("G") >= 0 && named("B") >= 0) {
      map.rgb = {named("R"), named("G"), named("B")};
    } else if (named("Y") >= 0) {
      map.rgb = {named("Y"), named("Y"), named("Y")};
    } else {
      std::string list;
      for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
      file.Refuse("has no channels R, G, B nor Y, but " + list +
                  "; save the layer you mean as R, G, B");
    }
    return map;
  }
  const int colors = static_cast<int>(names.size()) - (map.alpha >= 0 ? 1 : 0);
  if (colors >= 3) {
    map.rgb = {0, 1, 2};
  } else if (colors >= 1 && map.alpha != 0) {
    map.rgb = {0, 0, 0};
  } else {
    file.Refuse("has no colour, only transparency; it may be a matte");
  }
  return map;
}

// From one stored band of rows to the photo's rows. A table per sample value does the
// curve of integer files; a matrix, floats and premultiplied colours go the long way,
// with the same result.
class BandConverter {
 public:
  BandConverter(const PictureFile& file, const ColorTransform& transform, Tone tone)
      : channels_(ChannelsOf(file)),
        premultiplied_(file.is_premultiplied() && channels_.alpha >= 0),
        transform_(transform),
        camera_(tone == Tone::kCamera && file.depth() != CV_32F) {
    if (file.depth() == CV_32F || transform.mixes_channels || premultiplied_) return;
    const std::size_t values = file.depth() == CV_8U ? 256 : 65536;
    table_.resize(values);
    for (std::size_t i = 0; i < values; ++i) {
      table_[i] = cv::Vec3f::all(static_cast<float>(i) / static_cast<float>(values - 1));
    }
    ToLinear(table_.data(), values);
  }

  bool has_alpha() const { return channels_.alpha >= 0; }

  template <class Sample>
  void Rows(const cv::Mat& band, int first_row, int begin, int end, Photo* photo) const {
    const int stride = band.channels();
    const auto [r, g, b] = channels_.rgb;
    for (int y = begin; y < end; ++y) {
      const Sample* from = band.ptr<Sample>(y);
      cv::Vec3f* to = photo->pixels[first_row + y];
      float* alpha = has_alpha() ? photo->alpha[first_row + y] : nullptr;
      for (int x = 0; x < band.cols; ++x, from += stride) {
        to[x] = Colour(from[r], from[g], from[b]);
        if (alpha != nullptr) alpha[x] = Unit(from[channels_.alpha]);
      }
      if (table_.empty()) Finish(to, alpha, band.cols);
    }
  }

 private:
  static float Unit(std::uint8_t sample) { return static_cast<float>(sample) / 255.f; }
  static float Unit(std::uint16_t sample) { return static_cast<float>(sample) / 65535.f; }
  static float Unit(float sample) { return sample; }

  template <class Sample>
  cv::Vec3f Colour(Sample r, Sample g, Sample b) const {
    if constexpr (std::is_integral_v<Sample>) {
      if (!table_.empty()) return {table_[r][0], table_[g][1], table_[b][2]};
    }
    return {Unit(r), Unit(g), Unit(b)};
  }

  void Finish(cv::Vec3f* row, const float* alpha, int cols) const {
    if (premultiplied_) {
      for (int x = 0; x < cols; ++x) {
        row[x] = alpha[x] > 0.f ? row[x] / alpha[x] : cv::Vec3f::all(0.f);
      }
    }
    ToLinear(row, static_cast<std::size_t>(cols));
  }

  void ToLinear(cv::Vec3f* pixels, std::size_t count) const {
    float* values = pixels->val;
    if (camera_) {
      for (std::size_t i = 0; i < 3 * count; ++i) {
        values[i] = static_cast<float>(DisplayFromCamera(values[i]));
      }
    }
    if (transform_.apply) transform_.apply(values, count);
  }

  ChannelMap channels_;
  bool premultiplied_;
  const ColorTransform& transform_;
  bool camera_;
  std::vector<cv::Vec3f> table_;
};

// Black for what is no number; alpha within [0, 1]. Returns how many pixels were mended.
std::int64_t MendRow(cv::Vec3f* row, float* alpha, int cols) {
  std::int64_t mended = 0;
  for (int x = 0; x < cols; ++x) {
    const bool finite = std::isfinite(row[x][0]) && std::isfinite(row[x][1]) &&
                        std::isfinite(row[x][2]) &&
                        (alpha == nullptr || std::isfinite(alpha[x]));
    if (!finite) {
      row[x] = cv::Vec3f::all(0.f);
      if (alpha != nullptr && !std::isfinite(alpha[x])) alpha[x] = 0.f;
      ++mended;
    }
    if (alpha != nullptr) alpha[x] = std::clamp(alpha[x], 0.f, 1.f);
  }
  return mended;
}

}  // namespace

Photo ReadPhoto(const std::filesystem::path& path,
                const ReadPhotoOptions& options,
                const Progress& progress) {
  PictureFile file(path);
  file.CheckSize();

  // What its numbers mean
  const bool raw = file.format() == PictureFormat::kRaw;
  const std::optional<std::string> chosen =
      options.color_space.empty() ? std::nullopt : std::optional(options.color_space);
  ColorTransform transform = SceneLinearFromFile(
      {.file_name = path.string(),
       .scene_linear = raw || file.depth() == CV_32F,
       .developed_raw = raw,
       .icc_profile = file.Bytes("ICCProfile"),
       .icc_description = file.Text("ICCProfile:profile_description").value_or(""),
       .chromaticities = file.format() == PictureFormat::kExr
                             ? file.Numbers("chromaticities")
                             : std::vector<double>()},
      chosen);
  const BandConverter converter(file, transform, raw ? Tone::kSrgb : options.tone);

  // Band by band, so that the file's own samples never lie in memory as a whole
  Photo photo;
  photo.notes = transform.notes;
  std::atomic<std::int64_t> mended = 0;
  try {
    photo.pixels.create(file.size());
    if (converter.has_alpha()) photo.alpha.create(file.size());
    file.ReadBands(
        [&](int first_row, const cv::Mat& band) {
          ParallelRanges(band.rows, kRowsAtOnce, [&](int begin, int end) {
            switch (band.depth()) {
              case CV_8U:
                converter.Rows<std::uint8_t>(band, first_row, begin, end, &photo);
                break;
              case CV_16U:
                converter.Rows<std::uint16_t>(band, first_row, begin, end, &photo);
                break;
              default:
                converter.Rows<float>(band, first_row, begin, end, &photo);
            }
            for (int y = first_row + begin; y < first_row + end; ++y) {
              mended += MendRow(photo.pixels[y],
                                converter.has_alpha() ? photo.alpha[y] : nullptr,
                                photo.pixels.cols);
            }
          });
        },
        progress);
    photo.pixels = ApplyOrientation(photo.pixels, file.orientation());
    if (converter.has_alpha()) {
      photo.alpha = ApplyOrientation(photo.alpha, file.orientation());
    }
  } catch (const std::bad_alloc&) {
    file.Refuse("does not fit into the memory; scale it down first");
  } catch (const cv::Exception& e) {
    if (e.code != cv::Error::StsNoMem) throw;
    file.Refuse("does not fit into the memory; scale it down first");
  }
  photo.non_finite_pixels = mended;
  if (mended > 0) {
    photo.notes.push_back(std::to_string(mended) +
                          " pixels held no number (NaN or infinity) and are black now.");
  }
  return photo;
}

}  // namespace relight
