// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/contact_sheet.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/composite/frame_preview.h"
#include "relight/photo/picture_bytes.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace relight {
namespace {

constexpr int kThumbnail_px = 320;  // The longer side.
constexpr int kGap_px = 12, kLabel_px = 44;
const cv::Scalar kPaper(250, 250, 248), kInk(40, 40, 40), kSun(232, 150, 20);

// Where the sun stands and how its light falls, in a circle that is the horizon.
void DrawCompass(cv::Mat3b& picture,
                 cv::Point2d center,
                 double radius,
                 double azimuth_rad,
                 double elevation_rad) {
  constexpr int kShift = 4;  // Sixteenths of a pixel, so that it turns evenly
  const auto at = [&](double x, double y) {
    return cv::Point(static_cast<int>(std::lround((center.x + x) * (1 << kShift))),
                     static_cast<int>(std::lround((center.y + y) * (1 << kShift))));
  };
  const auto length = [](double px) { return static_cast<int>(px * (1 << kShift)); };
  cv::circle(picture, at(0, 0), length(radius), kInk, 1, cv::LINE_AA, kShift);
  const double out = radius * (1 - elevation_rad / (std::numbers::pi / 2));
  const double x = std::sin(azimuth_rad), y = -std::cos(azimuth_rad);
  const double tip = -0.8 * radius, barb = 0.3 * radius;
  cv::line(
      picture, at(out * x, out * y), at(tip * x, tip * y), kInk, 1, cv::LINE_AA, kShift);
  for (const double side : {-0.5, 0.5}) {
    const double back = azimuth_rad + side;
    cv::line(picture,
             at(tip * x, tip * y),
             at(tip * x + barb * std::sin(back), tip * y - barb * std::cos(back)),
             kInk,
             1,
             cv::LINE_AA,
             kShift);
  }
  cv::circle(
      picture, at(out * x, out * y), length(4), kSun, cv::FILLED, cv::LINE_AA, kShift);
}

PictureToEncode ToEncode(const cv::Mat3b& picture) {
  PictureToEncode encode;
  encode.samples = picture.isContinuous() ? picture : picture.clone();
  encode.channels = {"R", "G", "B"};
  return encode;
}

}  // namespace

ContactSheet::ContactSheet(int frames, cv::Size frame_size) : frames_(frames) {
  Require(frames > 0 && !frame_size.empty(), "a sheet of some frames");
  const double scale = std::min(
      1.0,
      static_cast<double>(kThumbnail_px) / std::max(frame_size.width, frame_size.height));
  thumbnail_ = {std::max(1, static_cast<int>(std::lround(frame_size.width * scale))),
                std::max(1, static_cast<int>(std::lround(frame_size.height * scale)))};
  cell_ = {std::max(thumbnail_.width, 170) + kGap_px,
           thumbnail_.height + kLabel_px + kGap_px};

  // About as wide as a screen
  const double wanted = std::sqrt(1.5 * frames * cell_.height / cell_.width);
  columns_ = std::clamp(static_cast<int>(std::lround(wanted)), 1, frames);
  const int rows = (frames + columns_ - 1) / columns_;
  picture_ = cv::Mat3b(rows * cell_.height + kGap_px, columns_ * cell_.width + kGap_px);
  picture_.setTo(kPaper);
}

void ContactSheet::Add(const cv::Mat3b& preview,
                       const std::string& label,
                       double sun_from_heading_rad,
                       double sun_elevation_rad) {
  const cv::Point corner(kGap_px + added_ % columns_ * cell_.width,
                         kGap_px + added_ / columns_ * cell_.height);
  Require(added_ < frames_, "no more frames than were announced");
  ++added_;
  cv::Mat3b small;
  cv::resize(preview, small, thumbnail_, 0, 0, cv::INTER_AREA);
  small.copyTo(picture_(cv::Rect(corner, thumbnail_)));
  cv::putText(picture_,
              label,
              corner + cv::Point(2, thumbnail_.height + 27),
              cv::FONT_HERSHEY_SIMPLEX,
              0.45,
              kInk,
              1,
              cv::LINE_AA);
  DrawCompass(
      picture_,
      corner + cv::Point(std::max(thumbnail_.width, 170) - 18, thumbnail_.height + 22),
      15,
      sun_from_heading_rad,
      sun_elevation_rad);
}

void WriteSheet(const std::filesystem::path& path,
                const cv::Mat3b& picture,
                const Provenance& provenance) {
  PictureToEncode encode = ToEncode(picture);
  encode.metadata = {{"Software", provenance.software},
                     {"ImageDescription", provenance.json}};
  const bool jpeg = path.extension() == ".jpg";
  WriteTextWhole(
      path,
      EncodePicture(jpeg ? PictureFormat::kJpeg : PictureFormat::kPng, encode, path));
}

std::string JpegOf(const cv::Mat3b& picture, int quality) {
  PictureToEncode encode = ToEncode(picture);
  encode.quality = quality;
  return EncodePicture(PictureFormat::kJpeg, encode, "preview.jpg");
}

}  // namespace relight
