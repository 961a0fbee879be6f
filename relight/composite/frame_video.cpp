// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/frame_video.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <algorithm>
#include <system_error>

namespace relight {
namespace fs = std::filesystem;

FrameVideo::FrameVideo(const fs::path& ffmpeg,
                       const fs::path& file,
                       cv::Size frame_size,
                       int frames_per_second)
    : file_(file),
      temporary_(TemporaryFor(file)),
      size_(frame_size.width / 2 * 2, frame_size.height / 2 * 2) {
  Require(!size_.empty(), "frames of two pixels or more");
  const std::string size =
      std::to_string(size_.width) + "x" + std::to_string(size_.height);
  ffmpeg_ = std::make_unique<ChildProcess>(
      ffmpeg,
      std::vector<std::string>{
          "-hide_banner",
          "-loglevel",
          "error",
          "-nostats",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          size,
          "-framerate",
          std::to_string(frames_per_second),
          "-i",
          "pipe:0",
          // One thread and no marks of the version: the same frames, the same bytes
          "-c:v",
          "libx264",
          "-threads",
          "1",
          "-crf",
          "18",
          "-preset",
          "medium",
          "-vf",
          "scale=out_color_matrix=bt709:out_range=tv",
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "iec61966-2-1",
          "-color_range",
          "tv",
          "-movflags",
          "+faststart",
          "-fflags",
          "+bitexact",
          "-flags:v",
          "+bitexact",
          "-f",
          "mp4",
          "file:" + temporary_.string()});
}

FrameVideo::~FrameVideo() {
  ffmpeg_.reset();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void FrameVideo::Add(const cv::Mat3b& frame) {
  Require(frame.cols / 2 * 2 == size_.width && frame.rows / 2 * 2 == size_.height,
          "frames of one size");
  for (int row = 0; row < size_.height && reads_; ++row) {
    reads_ = ffmpeg_->Write({reinterpret_cast<const char*>(frame.ptr(row)),
                             static_cast<std::size_t>(3 * size_.width)});
  }
}

std::string FrameVideo::Finish() {
  std::string messages;
  const bool well = ffmpeg_->Finish(&messages);
  ffmpeg_.reset();
  if (!well || !reads_) {
    std::replace(messages.begin(), messages.end(), '\n', ' ');
    return messages.empty() ? "ended without a word" : messages;
  }
  TakeName(temporary_, file_);
  return {};
}

}  // namespace relight
