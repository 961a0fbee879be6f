// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture file as it is stored, of the formats relight reads: JPEG, PNG, TIFF, HEIC,
// RAW and OpenEXR; Radiance .hdr for panoramas alone. Private to this folder; the only
// reader of pixels and metadata.

#include "relight/base/progress.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace relight {

enum class PictureFormat { kJpeg, kPng, kTiff, kHeif, kRaw, kExr, kHdr };

class PictureFile {
 public:
  // Opens the file: its format is told by its first bytes, not by its name. Throws
  // InputError when it is missing, a folder, none of the formats, or damaged; and when it
  // is a .hdr that is not asked for.
  explicit PictureFile(const std::filesystem::path& path, bool takes_hdr = false);
  ~PictureFile();
  PictureFile(const PictureFile&) = delete;
  PictureFile& operator=(const PictureFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  PictureFormat format() const { return format_; }

  // As stored, before ApplyOrientation. An EXR counts with its display window.
  cv::Size size() const { return size_; }
  // 1 to 8, as in EXIF.
  int orientation() const { return orientation_; }
  // Depth of the samples: CV_8U, CV_16U or CV_32F.
  int depth() const { return depth_; }
  const std::vector<std::string>& channels() const { return channels_; }
  int alpha_channel() const { return alpha_channel_; }  // -1: none.
  bool is_premultiplied() const { return is_premultiplied_; }
  bool is_cmyk() const { return is_cmyk_; }

  // Metadata by OpenImageIO's names; nothing when absent or of another kind.
  std::optional<std::string> Text(const std::string& name) const;
  std::vector<double> Numbers(const std::string& name) const;
  std::string Bytes(const std::string& name) const;  // "ICCProfile"; empty when absent.
  std::vector<std::string> TextNames() const;

  // Throws InputError for sizes no photo has: 0, or more than 1e9 pixels.
  void CheckSize() const;

  // All samples as stored, in bands of rows from top to bottom: depth(), one channel a
  // name of channels(). Throws InputError when the file is cut off or damaged.
  void ReadBands(const std::function<void(int first_row, const cv::Mat& band)>& take,
                 const Progress& progress = {});

  [[noreturn]] void Refuse(const std::string& why) const;

 private:
  struct Input;
  void RefuseDamaged(const std::string& detail) const;

  std::filesystem::path path_;
  PictureFormat format_ = PictureFormat::kJpeg;
  std::unique_ptr<Input> input_;
  cv::Size size_;
  int orientation_ = 1;
  int depth_ = CV_8U;
  std::vector<std::string> channels_;
  int alpha_channel_ = -1;
  bool is_premultiplied_ = false;
  bool is_cmyk_ = false;
};

// The stored picture turned and mirrored so that it stands upright.
cv::Mat ApplyOrientation(const cv::Mat& stored, int orientation);
cv::Size UprightSize(cv::Size stored, int orientation);

}  // namespace relight
