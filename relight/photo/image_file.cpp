// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/image_file.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/base/write_file.h"
#include "relight/photo/picture_bytes.h"
#include "relight/photo/picture_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr int kRowsAtOnce = 32;
constexpr char kMetadataPrefix[] = "relight:";

// All samples as floats, upright; integers divided by the largest of their type.
cv::Mat ReadSamples(PictureFile& file) {
  cv::Mat samples;
  file.CheckSize();
  samples.create(file.size(), CV_32FC(static_cast<int>(file.channels().size())));
  const double scale = file.depth() == CV_8U    ? 1.0 / 255.0
                       : file.depth() == CV_16U ? 1.0 / 65535.0
                                                : 1.0;
  file.ReadBands([&](int first_row, const cv::Mat& band) {
    band.convertTo(samples.rowRange(first_row, first_row + band.rows), CV_32F, scale);
  });
  return ApplyOrientation(samples, file.orientation());
}

cv::Mat1f Channel(const cv::Mat& samples, int index) {
  cv::Mat1f channel;
  cv::extractChannel(samples, channel, index);
  return channel;
}

// "sun.R" is R of the layer "sun".
std::pair<std::string, std::string> LayerAndChannel(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos) return {"", name};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

std::vector<std::string> ChannelNames(const LinearLayer& layer) {
  const std::string prefix = layer.name.empty() ? "" : layer.name + ".";
  if (layer.values.channels() == 1) return {prefix + "Y"};
  return {prefix + "R", prefix + "G", prefix + "B"};
}

}  // namespace

cv::Mat1f ReadMatte(const fs::path& path) {
  PictureFile file(path);
  if (file.is_cmyk()) file.Refuse("is CMYK; a matte is grey");
  const int count = static_cast<int>(file.channels().size());
  const int alpha = file.alpha_channel();
  const cv::Mat samples = ReadSamples(file);

  // The alpha channel, if it says anything
  cv::Mat1f matte;
  double low = 1.0;
  if (alpha >= 0) {
    matte = Channel(samples, alpha);
    cv::minMaxLoc(matte, &low);
  }
  const int colors = alpha >= 0 ? count - 1 : count;
  if ((alpha < 0 || low >= 1.0) && colors > 0) {
    const int first = alpha == 0 ? 1 : 0;
    matte = Channel(samples, first);
    for (int c = first + 1; c < first + std::min(colors, 3); ++c) {
      // A JPEG's grey may be off by a step of 8 bits between its channels
      constexpr double kSameGrey = 2.5 / 255.0;
      if (cv::norm(matte, Channel(samples, c), cv::NORM_INF) > kSameGrey) {
        file.Refuse(
            "is in colour and not transparent anywhere; a matte is grey, white where the "
            "tree "
            "is, or an alpha channel");
      }
    }
  }
  if (!cv::checkRange(matte, true, nullptr, -1e30, 1.5)) {
    file.Refuse("holds values that no matte has (NaN, or above 1); scale it to 0 to 1");
  }
  cv::min(matte, 1.0, matte);
  cv::max(matte, 0.0, matte);
  return matte;
}

void WriteMatte(const fs::path& path, const cv::Mat1f& matte) {
  cv::Mat samples(matte.size(), CV_16UC1);
  ParallelRanges(matte.rows, kRowsAtOnce, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < matte.cols; ++x) {
        Require(!std::isnan(matte(y, x)),
                "a matte that is written has no unknown pixels");
        const float value = std::clamp(matte(y, x), 0.f, 1.f);
        samples.at<std::uint16_t>(y, x) =
            static_cast<std::uint16_t>(std::lround(value * 65535.f));
      }
    }
  });
  WriteTextWhole(
      path,
      EncodePicture(PictureFormat::kPng,
                    {.samples = samples, .channels = {"Y"}, .display_encoded = false},
                    path));
}

void WriteLinear(const fs::path& path,
                 const std::vector<LinearLayer>& layers,
                 const std::map<std::string, std::string>& metadata,
                 LinearDepth depth) {
  Require(!layers.empty(), "a linear file has a layer");

  // All channels side by side
  PictureToEncode picture{.half = depth == LinearDepth::kHalf, .display_encoded = false};
  std::vector<cv::Mat> planes;
  for (const LinearLayer& layer : layers) {
    Require(layer.values.type() == CV_32FC1 || layer.values.type() == CV_32FC3,
            "a layer is cv::Mat1f or cv::Mat3f");
    Require(layer.values.size() == layers.front().values.size(), "layers of one size");
    std::vector<cv::Mat> channels;
    cv::split(layer.values, channels);
    planes.insert(planes.end(), channels.begin(), channels.end());
    for (const std::string& name : ChannelNames(layer)) {
      Require(std::find(picture.channels.begin(), picture.channels.end(), name) ==
                  picture.channels.end(),
              "layers of distinct names");
      picture.channels.push_back(name);
    }
  }
  cv::merge(planes, picture.samples);
  if (picture.half) {
    constexpr double kLargestHalf = 65504;
    picture.samples = cv::max(cv::min(picture.samples, kLargestHalf), -kLargestHalf);
  }
  for (const auto& [name, value] : metadata) {
    Require(name.rfind(kMetadataPrefix, 0) == 0, "metadata named relight:…");
    picture.metadata.emplace_back(name, value);
  }
  WriteTextWhole(path, EncodePicture(PictureFormat::kExr, picture, path));
}

LinearFile ReadLinearFile(const fs::path& path) {
  PictureFile file(path);
  if (file.format() != PictureFormat::kExr) {
    file.Refuse("is not OpenEXR, which linear layers are kept in");
  }
  const cv::Mat samples = ReadSamples(file);
  std::map<std::string, std::map<std::string, int>> indices;  // layer, channel
  const std::vector<std::string>& names = file.channels();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [layer, channel] = LayerAndChannel(names[i]);
    indices[layer][channel] = static_cast<int>(i);
  }

  LinearFile read;
  for (const auto& [name, channels] : indices) {
    const auto has = [&channels = channels](const char* channel) {
      return channels.count(channel) > 0;
    };
    if (has("R") && has("G") && has("B")) {
      cv::Mat3f rgb;
      cv::merge(std::vector<cv::Mat>{Channel(samples, channels.at("R")),
                                     Channel(samples, channels.at("G")),
                                     Channel(samples, channels.at("B"))},
                rgb);
      read.layers.push_back({name, rgb});
    } else if (has("Y")) {
      read.layers.push_back({name, Channel(samples, channels.at("Y"))});
    }
  }
  for (const std::string& name : file.TextNames()) {
    if (name.rfind(kMetadataPrefix, 0) == 0) read.metadata[name] = *file.Text(name);
  }
  return read;
}

cv::Mat3f ReadLinear(const fs::path& path, const std::string& name) {
  const LinearFile read = ReadLinearFile(path);
  std::string known;
  for (const LinearLayer& layer : read.layers) {
    if (layer.name == name) {
      if (layer.values.channels() == 3) return layer.values;
      cv::Mat3f rgb;
      cv::merge(std::vector<cv::Mat>(3, layer.values), rgb);
      return rgb;
    }
    known += (known.empty() ? "" : ", ") + ("\"" + layer.name + "\"");
  }
  throw InputError(
      path.string() + ": has no layer \"" + name + "\"" +
      (known.empty() ? ", nor any other that relight knows" : "; it has " + known));
}

}  // namespace relight
