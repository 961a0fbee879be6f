// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/open_raster.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/photo/color.h"
#include "relight/photo/picture_bytes.h"

#include <opencv2/imgproc.hpp>

#include <zip.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace relight {
namespace {

constexpr int kThumbnail_px = 256;

// --- Pictures ------------------------------------------------------------------------

std::uint8_t Byte(float display) {
  return static_cast<std::uint8_t>(std::clamp(display, 0.f, 1.f) * 255 + 0.5f);
}

std::uint8_t DisplayByte(float linear) {
  return Byte(SrgbFromLinear(std::clamp(linear, 0.f, 1.f)));
}

cv::Mat OpaqueBytes(const cv::Mat3f& linear) {
  cv::Mat3b bytes(linear.size());
  for (int row = 0; row < linear.rows; ++row) {
    for (int column = 0; column < linear.cols; ++column) {
      for (int c = 0; c < 3; ++c) {
        bytes(row, column)[c] = DisplayByte(linear(row, column)[c]);
      }
    }
  }
  return bytes;
}

// Straight RGBA; where nothing is seen the colour is black, and what is not finite too.
cv::Mat TreeBytes(const Montage& montage, WriteSummary* summary) {
  cv::Mat4b bytes(montage.tree.size(), cv::Vec4b(0, 0, 0, 0));
  for (int row = 0; row < bytes.rows; ++row) {
    for (int column = 0; column < bytes.cols; ++column) {
      const float alpha = montage.alpha(row, column);
      if (!(alpha > 0)) continue;
      const cv::Vec3f& color = montage.tree(row, column);
      const auto [low, high] = std::minmax({color[0], color[1], color[2]});
      cv::Vec4b& out = bytes(row, column);
      out[3] = Byte(alpha);
      if (!std::isfinite(color[0] + color[1] + color[2])) {
        ++summary->non_finite_pixels;
        continue;
      }
      summary->clipped_pixels += high > 1;
      summary->negative_pixels += low < 0;
      for (int c = 0; c < 3; ++c) out[c] = DisplayByte(color[c]);
    }
  }
  return bytes;
}

std::string Png(cv::Mat samples,
                const Provenance& provenance,
                const std::filesystem::path& path) {
  PictureToEncode picture{.samples = std::move(samples), .channels = {"R", "G", "B"}};
  if (picture.samples.channels() == 4) {
    picture.channels.push_back("A");
    picture.alpha_channel = 3;
  }
  picture.metadata = {{"Software", provenance.software},
                      {"ImageDescription", provenance.json}};
  return EncodePicture(PictureFormat::kPng, picture, path);
}

cv::Mat Thumbnail(const cv::Mat& picture) {
  const double shrink = std::max(
      1.0, static_cast<double>(std::max(picture.cols, picture.rows)) / kThumbnail_px);
  const cv::Size size(std::max(1, static_cast<int>(picture.cols / shrink)),
                      std::max(1, static_cast<int>(picture.rows / shrink)));
  cv::Mat small;
  cv::resize(picture, small, size, 0, 0, cv::INTER_AREA);
  return small;
}

// --- The archive ---------------------------------------------------------------------

struct Entry {
  std::string name, bytes;
};

std::string Layer(const char* name, const char* blend) {
  return std::string("  <layer name=\"") + name + "\" src=\"data/" + name +
         ".png\" composite-op=\"" + blend +
         "\" opacity=\"1.0\" visibility=\"visible\" x=\"0\" y=\"0\"/>\n";
}

// The entries in their order, none compressed (pictures are already), all of one date, so
// that the bytes depend on nothing else.
std::string Zip(const std::vector<Entry>& entries, const std::filesystem::path& path) {
  constexpr zip_uint16_t kFirstDay = (1 << 5) | 1;  // 1980-01-01 in MS-DOS's way
  zip_error_t error;
  zip_error_init(&error);
  const auto check = [&](bool done, zip_t* archive) {
    if (done) return;
    const std::string why =
        archive != nullptr ? zip_strerror(archive) : zip_error_strerror(&error);
    throw InputError(path.string() + ": the archive cannot be made: " + why);
  };

  // An archive in memory; the source outlives it
  zip_source_t* memory = zip_source_buffer_create(nullptr, 0, 0, &error);
  check(memory != nullptr, nullptr);
  const std::unique_ptr<zip_source_t, void (*)(zip_source_t*)> keep(memory,
                                                                    zip_source_free);
  zip_source_keep(memory);
  zip_t* opened = zip_open_from_source(memory, ZIP_TRUNCATE, &error);
  if (opened == nullptr) zip_source_free(memory);
  check(opened != nullptr, nullptr);
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(opened, zip_discard);
  for (const Entry& entry : entries) {
    zip_source_t* bytes =
        zip_source_buffer(opened, entry.bytes.data(), entry.bytes.size(), 0);
    check(bytes != nullptr, opened);
    const zip_int64_t index = zip_file_add(opened, entry.name.c_str(), bytes, 0);
    if (index < 0) zip_source_free(bytes);
    check(index >= 0, opened);
    const auto i = static_cast<zip_uint64_t>(index);
    check(zip_set_file_compression(opened, i, ZIP_CM_STORE, 0) == 0, opened);
    check(zip_file_set_dostime(opened, i, 0, kFirstDay, 0) == 0, opened);
  }
  check(zip_close(opened) == 0, opened);
  static_cast<void>(archive.release());

  // Read it back
  zip_stat_t stat;
  check(zip_source_stat(memory, &stat) == 0 && zip_source_open(memory) == 0, nullptr);
  std::string bytes(stat.size, '\0');
  const zip_int64_t read = zip_source_read(memory, bytes.data(), bytes.size());
  zip_source_close(memory);
  check(read == static_cast<zip_int64_t>(bytes.size()), nullptr);
  return bytes;
}

}  // namespace

WriteSummary WriteOpenRaster(const std::filesystem::path& path,
                             const Montage& montage,
                             const Provenance& provenance) {
  const cv::Mat3f flat = FlatDisplay(montage);
  cv::Mat merged;
  flat.convertTo(merged, CV_8UC3, 255.0);

  WriteSummary summary;
  const std::string tree = Png(TreeBytes(montage, &summary), provenance, path);
  std::string stack =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<image version=\"0.0.3\" w=\"" +
      std::to_string(merged.cols) + "\" h=\"" + std::to_string(merged.rows) +
      "\">\n <stack>\n" + Layer("tree", "svg:src-over");
  std::vector<Entry> data = {{"data/tree.png", tree}};
  if (!montage.shadow.empty()) {
    stack += Layer("shadow", "svg:multiply");
    data.push_back(
        {"data/shadow.png", Png(OpaqueBytes(montage.shadow), provenance, path)});
  }
  if (!montage.backdrop.empty()) {
    stack += Layer("backdrop", "svg:src-over");
    data.push_back(
        {"data/backdrop.png", Png(OpaqueBytes(montage.backdrop), provenance, path)});
  }
  stack += " </stack>\n</image>\n";

  std::vector<Entry> entries = {{"mimetype", "image/openraster"}, {"stack.xml", stack}};
  entries.insert(entries.end(), data.begin(), data.end());
  entries.push_back({"mergedimage.png", Png(merged, provenance, path)});
  entries.push_back(
      {"Thumbnails/thumbnail.png", Png(Thumbnail(merged), provenance, path)});
  WriteTextWhole(path, Zip(entries, path));
  return summary;
}

}  // namespace relight
