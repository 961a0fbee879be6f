// SPDX-License-Identifier: Apache-2.0
#pragma once

// Frames as an H.264 video in an .mp4, by the ffmpeg that is installed.

#include "relight/base/child_process.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <memory>
#include <string>

namespace relight {

// The same frames give the same bytes of one version of ffmpeg. The file is there, whole,
// after Finish; till then, and after an error, it is as it was.
class FrameVideo {
 public:
  // Throws InputError when the folder cannot be written to, or ffmpeg not started.
  FrameVideo(const std::filesystem::path& ffmpeg,
             const std::filesystem::path& file,
             cv::Size frame_size,
             int frames_per_second);
  ~FrameVideo();
  FrameVideo(const FrameVideo&) = delete;
  FrameVideo& operator=(const FrameVideo&) = delete;

  // A frame of that size, 8-bit sRGB.
  void Add(const cv::Mat3b& frame);

  // Answers nothing when all went well, else what ffmpeg says.
  std::string Finish();

 private:
  std::filesystem::path file_, temporary_;
  cv::Size size_;  // Even: H.264 halves its colours.
  bool reads_ = true;
  std::unique_ptr<ChildProcess> ffmpeg_;
};

}  // namespace relight
