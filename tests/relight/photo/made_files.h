// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files for the tests of relight/photo, made byte by byte: what they hold is known
// without asking the library that reads them.

#include "relight/base/write_file.h"
#include "relight/photo/write_photo.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace relight::tests {

// A folder of this test's own, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto base = std::filesystem::temp_directory_path() / "relight_test_XXXXXX";
    std::string name = base.string();
    path_ = mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// An environment variable for the length of a test; empty: unset.
class WithEnvironment {
 public:
  WithEnvironment(const char* name, const std::optional<std::string>& value)
      : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    Set(value);
  }
  ~WithEnvironment() { Set(before_); }

 private:
  void Set(const std::optional<std::string>& value) {
    if (value) {
      setenv(name_, value->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  const char* name_;
  std::optional<std::string> before_;
};

// One field of a TIFF directory (EXIF is one, too), little endian.
struct TiffField {
  std::uint16_t tag;
  std::uint16_t type;  // 1 byte, 2 text, 3 short, 4 long, 5 rational, 10 signed rational
  std::uint32_t count;
  std::string data;
};

template <class Integer>
std::string Bytes(Integer value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF);
  }
  return bytes;
}

inline TiffField TextField(std::uint16_t tag, const std::string& text) {
  return {tag, 2, static_cast<std::uint32_t>(text.size() + 1), text + '\0'};
}
inline TiffField ByteField(std::uint16_t tag, const std::vector<int>& values) {
  TiffField field{tag, 1, static_cast<std::uint32_t>(values.size()), ""};
  for (const int v : values) field.data += static_cast<char>(v);
  return field;
}
inline TiffField ShortField(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
  TiffField field{tag, 3, static_cast<std::uint32_t>(values.size()), ""};
  for (const auto v : values) field.data += Bytes(v);
  return field;
}
inline TiffField LongField(std::uint16_t tag, std::uint32_t value) {
  return {tag, 4, 1, Bytes(value)};
}
using Fraction = std::pair<std::uint32_t, std::uint32_t>;
inline TiffField RationalField(std::uint16_t tag,
                               const std::vector<Fraction>& values,
                               std::uint16_t type = 5) {
  TiffField field{tag, type, static_cast<std::uint32_t>(values.size()), ""};
  for (const auto& [above, below] : values) field.data += Bytes(above) + Bytes(below);
  return field;
}

// A TIFF: header, main directory, EXIF and GPS directories, then `pixels` as one strip at
// the very end (so that a cut takes pixels, not the directory).
inline std::string MakeTiff(std::vector<TiffField> main,
                            const std::vector<TiffField>& exif = {},
                            const std::vector<TiffField>& gps = {},
                            const std::string& pixels = "") {
  constexpr std::uint16_t kStripOffsets = 273, kStripByteCounts = 279, kExif = 34665,
                          kGps = 34853;
  if (!pixels.empty()) {
    main.push_back(LongField(kStripOffsets, 0));
    main.push_back(
        LongField(kStripByteCounts, static_cast<std::uint32_t>(pixels.size())));
  }
  if (!exif.empty()) main.push_back(LongField(kExif, 0));
  if (!gps.empty()) main.push_back(LongField(kGps, 0));

  // Where each directory comes to lie
  const auto size_of = [](const std::vector<TiffField>& fields) {
    std::size_t size = 2 + 12 * fields.size() + 4;
    for (const TiffField& field : fields) {
      if (field.data.size() > 4) size += field.data.size() + field.data.size() % 2;
    }
    return size;
  };
  const std::size_t exif_at = 8 + size_of(main);
  const std::size_t gps_at = exif_at + (exif.empty() ? 0 : size_of(exif));
  const std::size_t pixels_at = gps_at + (gps.empty() ? 0 : size_of(gps));
  for (TiffField& field : main) {
    if (field.tag == kExif) field.data = Bytes(static_cast<std::uint32_t>(exif_at));
    if (field.tag == kGps) field.data = Bytes(static_cast<std::uint32_t>(gps_at));
    if (field.tag == kStripOffsets) {
      field.data = Bytes(static_cast<std::uint32_t>(pixels_at));
    }
  }

  std::string bytes = std::string("II*\0", 4) + Bytes(std::uint32_t{8});
  const auto append = [&](const std::vector<TiffField>& fields) {
    std::map<std::uint16_t, TiffField> sorted;
    for (const TiffField& field : fields) sorted[field.tag] = field;
    std::string values;
    std::size_t values_at = bytes.size() + 2 + 12 * fields.size() + 4;
    bytes += Bytes(static_cast<std::uint16_t>(sorted.size()));
    for (const auto& [tag, field] : sorted) {
      bytes += Bytes(tag) + Bytes(field.type) + Bytes(field.count);
      if (field.data.size() <= 4) {
        bytes += field.data + std::string(4 - field.data.size(), '\0');
      } else {
        bytes += Bytes(static_cast<std::uint32_t>(values_at + values.size()));
        values += field.data + std::string(field.data.size() % 2, '\0');
      }
    }
    bytes += Bytes(std::uint32_t{0}) + values;
  };
  append(main);
  if (!exif.empty()) append(exif);
  if (!gps.empty()) append(gps);
  return bytes + pixels;
}

// A JPEG without its EXIF, with `exif` (a TIFF) instead when there is one.
inline std::string JpegWithExif(const std::string& jpeg, const std::string& exif) {
  std::string out = jpeg.substr(0, 2);
  if (!exif.empty()) {
    const std::string segment = std::string("Exif\0\0", 6) + exif;
    const std::size_t length = segment.size() + 2;
    out += "\xFF\xE1";
    out += static_cast<char>(length >> 8);
    out += static_cast<char>(length & 0xFF);
    out += segment;
  }
  std::size_t at = 2;
  while (static_cast<unsigned char>(jpeg[at + 1]) != 0xDA) {
    const std::size_t size =
        2 + (static_cast<std::size_t>(static_cast<unsigned char>(jpeg[at + 2])) << 8 |
             static_cast<unsigned char>(jpeg[at + 3]));
    const auto marker = static_cast<unsigned char>(jpeg[at + 1]);
    const bool metadata = marker == 0xE1 || marker == 0xED || marker == 0xFE;
    if (!metadata) out += jpeg.substr(at, size);
    at += size;
  }
  return out + jpeg.substr(at);
}

// Big endian, as ICC profiles and HEIC files count.
inline std::string BigEndian(std::uint64_t value, unsigned bytes) {
  std::string out;
  for (unsigned i = bytes; i-- > 0;) out += static_cast<char>(value >> (8 * i) & 0xFF);
  return out;
}

inline std::string Fixed16(double value) {
  return BigEndian(
      static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536))),
      4);
}

// A display's ICC profile: XYZ of its red, green and blue by D50, and the tag of one
// curve for all three.
inline std::string MakeIccProfile(const cv::Matx33d& xyz_from_rgb,
                                  const std::string& curve) {
  std::vector<std::pair<std::string, std::string>> tags = {
      {"rTRC", curve}, {"gTRC", curve}, {"bTRC", curve}};
  for (int column = 0; column < 3; ++column) {
    std::string xyz = "XYZ " + BigEndian(0, 4);
    for (int row = 0; row < 3; ++row) xyz += Fixed16(xyz_from_rgb(row, column));
    tags.emplace_back(std::string(1, "rgb"[column]) + "XYZ", xyz);
  }
  const std::size_t first = 132 + 12 * tags.size();
  std::string table = BigEndian(tags.size(), 4), data;
  for (const auto& [name, content] : tags) {
    table += name + BigEndian(first + data.size(), 4) + BigEndian(content.size(), 4);
    data += content;
  }
  std::string head = BigEndian(first + data.size(), 4) + BigEndian(0, 4) +
                     BigEndian(0x04300000, 4) + "mntrRGB XYZ " + std::string(12, '\0') +
                     "acsp";
  head.resize(128, '\0');
  return head + table + data;
}

// A JPEG with a profile in it.
inline std::string JpegWithIcc(const std::string& jpeg, const std::string& profile) {
  const std::string segment = std::string("ICC_PROFILE\0\1\1", 14) + profile;
  return jpeg.substr(0, 2) + "\xFF\xE2" + BigEndian(segment.size() + 2, 2) + segment +
         jpeg.substr(2);
}

inline const Provenance kTestProvenance{.software = "relight 0.1.0", .json = "{}"};

// Smooth colours in [0, 1] that no two pixels share.
inline Photo SmoothPhoto(int width, int height) {
  Photo photo;
  photo.pixels.create(height, width);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(width);
      const float v = static_cast<float>(y) / static_cast<float>(height);
      photo.pixels(y, x) = {u, v, 0.25f + 0.5f * u * v};
    }
  }
  return photo;
}

inline void WriteJpegWithExif(const std::filesystem::path& path,
                              const Photo& photo,
                              const std::string& exif) {
  WritePhoto(path, photo, kTestProvenance);
  WriteTextWhole(path, JpegWithExif(ReadText(path), exif));
}

// The words of an exception, "" when there is none.
template <class Exception, class Function>
std::string WordsOf(Function function) {
  try {
    function();
  } catch (const Exception& e) {
    return e.what();
  }
  ADD_FAILURE() << "no exception of the kind";
  return "";
}

}  // namespace relight::tests
