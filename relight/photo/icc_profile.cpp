// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/icc_profile.h"

#include "relight/photo/color.h"

#include <opencv2/core.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace relight {
namespace {

constexpr std::size_t kSamples = 4096;

// XYZ by D50, in which profiles count, of the primaries of Rec.709: IEC 61966-2-1,
// brought from D65 by the matrix of Bradford.
const cv::Matx33d kXyzFromRec709(0.4360747,
                                 0.3850649,
                                 0.1430804,
                                 0.2225045,
                                 0.7168786,
                                 0.0606169,
                                 0.0139322,
                                 0.0971045,
                                 0.7141733);

// Big-endian numbers; out_of_range beyond the end.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  std::string_view Part(std::size_t at, std::size_t length) const {
    if (at > bytes_.size() || length > bytes_.size() - at) {
      throw std::out_of_range("profile");
    }
    return bytes_.substr(at, length);
  }
  std::uint32_t Whole(std::size_t at, std::size_t length) const {
    std::uint32_t value = 0;
    for (const char c : Part(at, length)) {
      value = value << 8 | static_cast<unsigned char>(c);
    }
    return value;
  }
  double Fixed16(std::size_t at) const {
    return static_cast<std::int32_t>(Whole(at, 4)) / 65536.0;
  }
  std::optional<Reader> Tag(std::string_view name) const {
    const std::uint32_t count = Whole(128, 4);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::size_t entry = 132 + 12 * static_cast<std::size_t>(i);
      if (Part(entry, 4) == name) {
        return Reader(Part(Whole(entry + 4, 4), Whole(entry + 8, 4)));
      }
    }
    return std::nullopt;
  }

 private:
  std::string_view bytes_;
};

template <class Function>
std::vector<double> Sampled(Function function) {
  std::vector<double> curve(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) {
    curve[i] = function(static_cast<double>(i) / (kSamples - 1));
  }
  return curve;
}

std::vector<double> Power(double exponent) {
  if (!(exponent > 0)) throw std::out_of_range("curve");
  return Sampled([&](double x) { return std::pow(x, exponent); });
}

// parametricCurveType, section 10.16: y = (a x + b)^g + e where x >= d, c x + f below.
std::vector<double> ParametricCurve(const Reader& tag) {
  constexpr std::array<std::size_t, 5> kCounts = {1, 3, 4, 5, 7};
  const std::uint32_t kind = tag.Whole(8, 2);
  if (kind >= kCounts.size()) throw std::out_of_range("curve");
  std::array<double, 7> p{};
  for (std::size_t i = 0; i < kCounts[kind]; ++i) p[i] = tag.Fixed16(12 + 4 * i);
  const double g = p[0], a = p[1], b = p[2];
  double c = p[3], d = p[4], e = p[5], f = p[6];
  if (kind == 0) return Power(g);
  if (kind <= 2) {  // Flat up to where the power begins, and raised by p[3] as a whole
    if (a == 0) throw std::out_of_range("curve");
    e = f = kind == 2 ? p[3] : 0;
    c = 0;
    d = -b / a;
  }
  return Sampled([&](double x) {
    return x >= d ? std::pow(std::max(a * x + b, 0.0), g) + e : c * x + f;
  });
}

// curveType, section 10.6: straight, a power, or a table.
std::vector<double> TabledCurve(const Reader& tag) {
  const std::size_t count = tag.Whole(8, 4);
  if (count == 0) return Power(1);
  if (count == 1) return Power(tag.Whole(12, 2) / 256.0);
  std::vector<double> curve;
  tag.Part(12, 2 * count);  // All there, before memory is taken
  for (std::size_t i = 0; i < count; ++i) {
    curve.push_back(tag.Whole(12 + 2 * i, 2) / 65535.0);
  }
  return curve;
}

std::vector<double> CurveOf(const std::optional<Reader>& tag) {
  if (!tag) throw std::out_of_range("no curve");
  const std::string_view type = tag->Part(0, 4);
  std::vector<double> curve;
  if (type == "curv") {
    curve = TabledCurve(*tag);
  } else if (type == "para") {
    curve = ParametricCurve(*tag);
  } else {
    throw std::out_of_range("no curve");
  }
  const bool holds =
      std::all_of(
          curve.begin(), curve.end(), [](double v) { return std::isfinite(v); }) &&
      std::is_sorted(curve.begin(), curve.end()) && curve.back() > 0.5;
  if (!holds) throw std::out_of_range("no light");
  return curve;
}

cv::Vec3d XyzOf(const std::optional<Reader>& tag) {
  if (!tag || tag->Part(0, 4) != "XYZ ") throw std::out_of_range("no colour");
  return {tag->Fixed16(8), tag->Fixed16(12), tag->Fixed16(16)};
}

IccProfile ProfileOf(const Reader& file) {
  if (file.Part(36, 4) != "acsp" || file.Part(20, 4) != "XYZ ") {
    throw std::out_of_range("no profile by XYZ");
  }
  IccProfile profile;
  cv::Matx33d rec709_from_rgb = cv::Matx33d::eye();
  if (file.Part(16, 4) == "GRAY") {
    profile.curves.fill(CurveOf(file.Tag("kTRC")));
  } else if (file.Part(16, 4) == "RGB ") {
    cv::Matx33d xyz_from_rgb;
    int column = 0;
    for (const char* primary : {"rXYZ", "gXYZ", "bXYZ"}) {
      const cv::Vec3d xyz = XyzOf(file.Tag(primary));
      for (int row = 0; row < 3; ++row) xyz_from_rgb(row, column) = xyz[row];
      ++column;
    }
    if (!(cv::determinant(xyz_from_rgb) > 1e-3)) throw std::out_of_range("one line");
    profile.curves = {
        CurveOf(file.Tag("rTRC")), CurveOf(file.Tag("gTRC")), CurveOf(file.Tag("bTRC"))};
    rec709_from_rgb = kXyzFromRec709.inv() * xyz_from_rgb;
  } else {
    throw std::out_of_range("other colours");
  }
  for (int row = 0; row < 3; ++row) {
    const double white =
        rec709_from_rgb(row, 0) + rec709_from_rgb(row, 1) + rec709_from_rgb(row, 2);
    if (!(white > 0.5 && white < 2)) throw std::out_of_range("no white");
    for (int column = 0; column < 3; ++column) {
      profile.rec709_from_rgb[static_cast<std::size_t>(row)]
                             [static_cast<std::size_t>(column)] =
          rec709_from_rgb(row, column) / white;
    }
  }
  return profile;
}

}  // namespace

double IccProfile::Linear(int channel, double value) const {
  const std::vector<double>& curve = curves[static_cast<std::size_t>(channel)];
  const double at = std::clamp(value, 0.0, 1.0) * static_cast<double>(curve.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(at), curve.size() - 2);
  return curve[low] + (at - static_cast<double>(low)) * (curve[low + 1] - curve[low]);
}

bool IccProfile::IsSrgb() const {
  constexpr double kHalfStep = 0.5 / 255;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const double one = row == column ? 1 : 0;
      if (std::abs(rec709_from_rgb[row][column] - one) > kHalfStep) return false;
    }
  }
  for (int channel = 0; channel < 3; ++channel) {
    for (int code = 0; code < 256; ++code) {
      const double value = code / 255.0;
      const double as_code = SrgbFromLinear(static_cast<float>(Linear(channel, value)));
      if (std::abs(as_code - value) > kHalfStep) return false;
    }
  }
  return true;
}

std::optional<IccProfile> ReadIccProfile(std::string_view bytes) {
  try {
    return ProfileOf(Reader(bytes));
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

}  // namespace relight
