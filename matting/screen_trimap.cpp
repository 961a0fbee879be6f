// SPDX-License-Identifier: Apache-2.0
#include "matting/screen_trimap.h"

#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

namespace relight {
namespace {

constexpr float kDark = 0.004f;      // Linear; one step of 8 bits is a tenth of it.
constexpr float kStandsOut = 0.35f;  // k of what may be a screen; a clear sky has 0.3.

float Largest(const cv::Vec3f& color, int but_channel) {
  return std::max(color[(but_channel + 1) % 3], color[(but_channel + 2) % 3]);
}

// k of (M8).
float StandingOut(const cv::Vec3f& color, int channel) {
  if (color[channel] < kDark) return 0;
  return (color[channel] - Largest(color, channel)) / color[channel];
}

float MedianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The median colour of what stands out in a channel; nothing when that is little.
std::optional<Screen> ScreenOf(const cv::Mat3f& linear, int channel) {
  std::array<std::vector<float>, 3> values;
  for (const cv::Vec3f& color : linear) {
    if (StandingOut(color, channel) < kStandsOut) continue;
    for (int c = 0; c < 3; ++c) values[c].push_back(color[c]);
  }
  if (values[0].size() < linear.total() / 20) return {};
  return Screen{{MedianOf(values[0]), MedianOf(values[1]), MedianOf(values[2])}, channel};
}

Screen ParseScreen(const std::string& words) {
  cv::Vec3f display;
  std::string_view rest = words;
  for (int c = 0; c < 3; ++c) {
    const std::string_view part = rest.substr(0, rest.find(','));
    const auto [end, error] =
        std::from_chars(part.data(), part.data() + part.size(), display[c]);
    const bool last = rest.size() == part.size();
    if (error != std::errc() || end != part.data() + part.size() || last != (c == 2) ||
        !(display[c] >= 0 && display[c] <= 255)) {
      throw OptionError("screen must be auto, blue, green, or R,G,B of 0 to 255, got \"" +
                        words + "\"");
    }
    if (!last) rest.remove_prefix(part.size() + 1);
  }
  Screen screen;
  for (int c = 0; c < 3; ++c) screen.color[c] = std::pow(display[c] / 255, 2.2f);
  screen.channel = screen.color[2] > screen.color[1] ? 2 : 1;
  if (StandingOut(screen.color, screen.channel) < kStandsOut) {
    throw OptionError("screen: " + words +
                      " is neither blue nor green enough to tell from what is before it");
  }
  return screen;
}

}  // namespace

Screen FindScreen(const cv::Mat3f& linear, const std::string& words) {
  if (words != "auto" && words != "blue" && words != "green") return ParseScreen(words);
  std::optional<Screen> best;
  std::size_t most = 0;
  for (const int channel : {2, 1}) {
    if (words != "auto" && (words == "blue") != (channel == 2)) continue;
    const auto screen = ScreenOf(linear, channel);
    if (!screen) continue;
    const auto count = static_cast<std::size_t>(
        std::count_if(linear.begin(), linear.end(), [&](const cv::Vec3f& color) {
          return StandingOut(color, channel) >= kStandsOut;
        }));
    if (count > most) best = screen;
    most = std::max(most, count);
  }
  if (!best) {
    throw InputError("no " + (words == "auto" ? std::string("blue or green") : words) +
                     " screen is in the photo (a twentieth of it at least); give its "
                     "colour with --screen R,G,B, or a trimap");
  }
  return *best;
}

cv::Mat1b TrimapFromScreen(const cv::Mat3f& linear,
                           const Screen& screen,
                           const Progress& progress) {
  const float own = StandingOut(screen.color, screen.channel);
  cv::Mat1b trimap(linear.size(), kTrimapUnknown);
  ParallelRanges(
      linear.rows,
      64,
      [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
          for (int x = 0; x < linear.cols; ++x) {
            const cv::Vec3f& color = linear(y, x);
            if (*std::max_element(color.val, color.val + 3) < kDark) continue;
            const float share = StandingOut(color, screen.channel) / own;
            if (share > 0.9f) trimap(y, x) = kTrimapBackground;
            if (share < 0.1f) trimap(y, x) = kTrimapForeground;
          }
        }
      },
      progress.Part(0, 0.8));
  cv::Mat1b sure;
  for (const std::uint8_t label : {kTrimapForeground, kTrimapBackground}) {
    cv::erode(trimap == label, sure, cv::Mat::ones(5, 5, CV_8U));
    trimap.setTo(kTrimapUnknown, (trimap == label) & ~sure);
  }
  CheckTrimap(trimap);
  progress.Report(1);
  return trimap;
}

void RemoveSpill(cv::Mat3f& foreground, const Screen& screen) {
  foreground.forEach([&](cv::Vec3f& color, const int*) {
    color[screen.channel] =
        std::min(color[screen.channel], Largest(color, screen.channel));
  });
}

}  // namespace relight
