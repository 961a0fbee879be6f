// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/read_photo.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/write_photo.h"
#include "tests/relight/photo/made_files.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <random>

namespace relight {
namespace {

using tests::MakeTiff;
using tests::ShortField;
using tests::TemporaryFolder;
using tests::WithEnvironment;
using tests::WordsOf;

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// TIFF fields of a picture of `bits` per sample.
std::vector<tests::TiffField> PictureFields(int width,
                                            int height,
                                            int photometric,
                                            int channels,
                                            std::uint16_t bits,
                                            int extra = -1) {
  std::vector<tests::TiffField> fields = {
      tests::LongField(256, static_cast<std::uint32_t>(width)),
      tests::LongField(257, static_cast<std::uint32_t>(height)),
      ShortField(258,
                 std::vector<std::uint16_t>(static_cast<std::size_t>(channels), bits)),
      ShortField(259, {1}),
      ShortField(262, {static_cast<std::uint16_t>(photometric)}),
      ShortField(277, {static_cast<std::uint16_t>(channels)}),
      tests::LongField(278, static_cast<std::uint32_t>(height)),
  };
  if (extra >= 0) fields.push_back(ShortField(338, {static_cast<std::uint16_t>(extra)}));
  return fields;
}

constexpr int kGrey = 1, kRgb = 2, kCmyk = 5;      // PhotometricInterpretation
constexpr int kAssociated = 1, kUnassociated = 2;  // ExtraSamples

class ReadPhotoTest : public testing::Test {
 protected:
  // These tests are about our own config, whatever the machine has.
  WithEnvironment no_ocio_{"OCIO", std::nullopt};
  TemporaryFolder folder_;
};

TEST_F(ReadPhotoTest, SixteenBitsAreTheCurveOfTheirValues) {
  std::string samples;
  for (int i = 0; i < 256; ++i) {
    for (int c = 0; c < 3; ++c)
      samples += tests::Bytes(static_cast<std::uint16_t>(256 * i + c));
  }
  const auto path = folder_ / "ramp.tif";
  WriteTextWhole(path, MakeTiff(PictureFields(16, 16, kRgb, 3, 16), {}, {}, samples));
  const Photo photo = ReadPhoto(path);
  EXPECT_TRUE(photo.alpha.empty());
  for (int i = 0; i < 256; ++i) {
    for (int c = 0; c < 3; ++c) {
      const double d = (256 * i + c) / 65535.0;
      const double linear = d <= 0.04045 ? d / 12.92 : std::pow((d + 0.055) / 1.055, 2.4);
      EXPECT_NEAR(
          photo.pixels(i / 16, i % 16)[c], linear, 3e-7 + 1e-6 * linear);  // Floats
    }
  }
}

TEST_F(ReadPhotoTest, GreyBecomesRgbAndKeepsItsAlpha) {
  const auto path = folder_ / "grey.tif";
  WriteTextWhole(path,
                 MakeTiff(PictureFields(2, 1, kGrey, 2, 8, kUnassociated),
                          {},
                          {},
                          std::string("\x80\xFF\x40\x33", 4)));
  const Photo photo = ReadPhoto(path);
  const float expected = LinearFromSrgb(128 / 255.f);
  EXPECT_EQ(photo.pixels(0, 0), cv::Vec3f(expected, expected, expected));
  EXPECT_EQ(photo.alpha(0, 0), 1.f);
  EXPECT_EQ(photo.alpha(0, 1), 0x33 / 255.f);
}

// Of the same numbers on disk an associated alpha means brighter colours.
TEST_F(ReadPhotoTest, TiffSaysWhetherItsAlphaIsPremultiplied) {
  const std::string samples("\x40\x20\x10\x80", 4);
  const auto straight = folder_ / "straight.tif", associated = folder_ / "associated.tif";
  WriteTextWhole(
      straight,
      MakeTiff(PictureFields(1, 1, kRgb, 4, 8, kUnassociated), {}, {}, samples));
  WriteTextWhole(associated,
                 MakeTiff(PictureFields(1, 1, kRgb, 4, 8, kAssociated), {}, {}, samples));
  const float alpha = 128 / 255.f;
  const Photo s = ReadPhoto(straight), a = ReadPhoto(associated);
  EXPECT_EQ(s.alpha(0, 0), alpha);
  EXPECT_EQ(a.alpha(0, 0), alpha);
  const float display[3] = {64 / 255.f, 32 / 255.f, 16 / 255.f};
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(s.pixels(0, 0)[c], LinearFromSrgb(display[c]));
    EXPECT_FLOAT_EQ(a.pixels(0, 0)[c], LinearFromSrgb(display[c] / alpha));
  }
}

TEST_F(ReadPhotoTest, AnExrIsPremultipliedOnDiskAndStraightInside) {
  const auto path = folder_ / "rgba.exr";
  Photo photo = tests::SmoothPhoto(5, 4);
  photo.alpha.create(4, 5);
  photo.alpha = 0.5f;
  photo.alpha(0, 0) = 0.f;
  WritePhoto(path, photo, tests::kTestProvenance);
  const cv::Mat3f on_disk = ReadLinear(path);
  const Photo back = ReadPhoto(path);
  constexpr float kHalf = 1.f / 2048;  // 11 bits of mantissa
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float v = photo.pixels(y, x)[c], alpha = photo.alpha(y, x);
        EXPECT_NEAR(on_disk(y, x)[c], v * alpha, kHalf * v);
        EXPECT_NEAR(back.pixels(y, x)[c], alpha > 0 ? v : 0.f, kHalf * v);
      }
      EXPECT_EQ(back.alpha(y, x), photo.alpha(y, x));
    }
  }
}

TEST_F(ReadPhotoTest, StandsUprightInAllEightOrientations) {
  // Blocks of 16 pixels survive a JPEG; corner (0, 0) is bright, the long side horizontal
  Photo photo;
  photo.pixels = cv::Mat3f(32, 64, cv::Vec3f(0.02f, 0.02f, 0.02f));
  photo.pixels(cv::Rect(0, 0, 16, 16)) = cv::Vec3f(1, 1, 1);
  photo.pixels(cv::Rect(48, 0, 16, 16)) = cv::Vec3f(0.3f, 0.3f, 0.3f);
  // Where EXIF says row 0 and column 0 of the stored picture are: top or bottom, left or
  // right, and whether rows became columns
  struct Case {
    std::uint16_t orientation;
    bool bottom, right, turned;
  };
  for (const Case& c : {Case{1, false, false, false},
                        Case{2, false, true, false},
                        Case{3, true, true, false},
                        Case{4, true, false, false},
                        Case{5, false, false, true},
                        Case{6, false, true, true},
                        Case{7, true, true, true},
                        Case{8, true, false, true}}) {
    const auto path = folder_ / "turned.jpg";
    tests::WriteJpegWithExif(path, photo, MakeTiff({ShortField(274, {c.orientation})}));
    const cv::Mat3f upright = ReadPhoto(path).pixels;
    ASSERT_EQ(upright.size(), c.turned ? cv::Size(32, 64) : cv::Size(64, 32));
    const int x = c.right ? upright.cols - 8 : 8, y = c.bottom ? upright.rows - 8 : 8;
    EXPECT_GT(upright(y, x)[1], 0.9f) << c.orientation;
    // The grey block lies along the stored row
    const int gx = c.turned ? x : (c.right ? 8 : upright.cols - 8);
    const int gy = c.turned ? (c.bottom ? 8 : upright.rows - 8) : y;
    EXPECT_NEAR(upright(gy, gx)[1], 0.3f, 0.02f) << c.orientation;  // JPEG
  }
}

TEST_F(ReadPhotoTest, IsToldByItsBytesNotItsName) {
  const Photo photo = tests::SmoothPhoto(20, 10);
  WritePhoto(folder_ / "a.png", photo, tests::kTestProvenance);
  std::filesystem::rename(folder_ / "a.png", folder_ / "a.jpg");
  EXPECT_EQ(ReadPhoto(folder_ / "a.jpg").pixels.size(), cv::Size(20, 10));
}

TEST_F(ReadPhotoTest, SaysWhatIsWrongWithAFile) {
  const auto words = [](const std::filesystem::path& path) {
    return WordsOf<InputError>([&] { ReadPhoto(path); });
  };
  const auto missing = folder_ / "missing.jpg";
  EXPECT_TRUE(Contains(words(missing), missing.string() + ": no such file"));
  EXPECT_TRUE(Contains(words(folder_.path()), "is a folder"));
  WriteTextWhole(folder_ / "text.jpg", "This is a letter, not a photograph.");
  EXPECT_TRUE(Contains(words(folder_ / "text.jpg"), "not a picture that relight knows"));
  WriteTextWhole(folder_ / "empty.jpg", "");
  EXPECT_TRUE(Contains(words(folder_ / "empty.jpg"), "is empty"));
  WriteTextWhole(
      folder_ / "cmyk.tif",
      MakeTiff(
          PictureFields(1, 1, kCmyk, 4, 8), {}, {}, std::string("\x01\x02\x03\x04", 4)));
  EXPECT_TRUE(Contains(words(folder_ / "cmyk.tif"), "is CMYK"));
  WriteTextWhole(folder_ / "huge.tif",
                 MakeTiff(PictureFields(70000, 70000, kRgb, 3, 8), {}, {}, "abc"));
  EXPECT_TRUE(Contains(words(folder_ / "huge.tif"), "70000 x 70000"));
  WriteLinear(folder_ / "layers.exr", {{"sun", cv::Mat3f(2, 2, cv::Vec3f(1, 1, 1))}});
  EXPECT_TRUE(Contains(words(folder_ / "layers.exr"), "sun.R"));
}

TEST_F(ReadPhotoTest, NumbersThatAreNoneBecomeBlackAndAreCounted) {
  cv::Mat3f pixels(3, 3, cv::Vec3f(0.5f, 0.25f, -0.125f));
  pixels(0, 1)[1] = std::numeric_limits<float>::quiet_NaN();
  pixels(2, 2)[0] = std::numeric_limits<float>::infinity();
  WriteLinear(folder_ / "nan.exr", {{"", pixels}});
  const Photo photo = ReadPhoto(folder_ / "nan.exr");
  EXPECT_EQ(photo.non_finite_pixels, 2);
  ASSERT_EQ(photo.notes.size(), 1u);
  EXPECT_TRUE(Contains(photo.notes[0], "2 pixels"));
  EXPECT_EQ(photo.pixels(0, 1), cv::Vec3f(0, 0, 0));
  EXPECT_EQ(photo.pixels(1, 1), cv::Vec3f(0.5f, 0.25f, -0.125f));
}

// A file that was cut off is never a picture, wherever it was cut.
TEST_F(ReadPhotoTest, RefusesEveryTruncationOfEveryFormat) {
  Photo photo = tests::SmoothPhoto(97, 61);
  cv::Mat3f noise(photo.pixels.size());
  cv::RNG(5).fill(noise, cv::RNG::UNIFORM, 0.0, 0.2);
  photo.pixels += noise;
  std::mt19937 random(11);
  for (const char* name : {"p.jpg", "p.png", "p.exr", "p.tif"}) {
    const auto whole = folder_ / name;
    WritePhoto(whole, photo, tests::kTestProvenance);
    const std::string bytes = ReadText(whole);
    ASSERT_NO_THROW(ReadPhoto(whole));
    // The last bytes of a TIFF's directory are the pointer to no next one: what it needs
    // ends 4 to 6 bytes before the file
    const bool tiff = std::string(name) == "p.tif";
    std::vector<std::size_t> cuts = {1, 2, 10, 20, bytes.size() / 2, bytes.size() - 100};
    if (!tiff) {
      for (std::size_t n = 1; n <= 12; ++n) cuts.push_back(bytes.size() - n);
    }
    for (int i = 0; i < 60; ++i) cuts.push_back(1 + random() % (bytes.size() - 100));
    const auto cut_file = folder_ / (std::string("cut_") + name);
    for (const std::size_t cut : cuts) {
      WriteTextWhole(cut_file, bytes.substr(0, cut));
      const std::string words = WordsOf<InputError>([&] { ReadPhoto(cut_file); });
      EXPECT_TRUE(Contains(words, cut_file.string())) << name << " cut at " << cut;
    }
  }
}

TEST_F(ReadPhotoTest, RefusesATiffWhosePixelsAreCutOff) {
  const std::string whole =
      MakeTiff(PictureFields(32, 32, kRgb, 3, 8), {}, {}, std::string(32 * 32 * 3, 'x'));
  WriteTextWhole(folder_ / "whole.tif", whole);
  ASSERT_NO_THROW(ReadPhoto(folder_ / "whole.tif"));
  for (const std::size_t missing : {1u, 100u, 3000u}) {
    WriteTextWhole(folder_ / "cut.tif", whole.substr(0, whole.size() - missing));
    EXPECT_THROW(ReadPhoto(folder_ / "cut.tif"), InputError) << missing;
  }
}

// Bytes changed at random: an error or a picture, but no crash.
TEST_F(ReadPhotoTest, SurvivesDamage) {
  const Photo photo = tests::SmoothPhoto(64, 48);
  std::mt19937 random(23);
  int refused = 0;
  for (const char* name : {"d.jpg", "d.png", "d.exr", "d.tif"}) {
    const auto path = folder_ / name;
    WritePhoto(path, photo, tests::kTestProvenance);
    const std::string bytes = ReadText(path);
    for (int i = 0; i < 40; ++i) {
      std::string damaged = bytes;
      for (int k = 0; k < 8; ++k)
        damaged[random() % damaged.size()] = static_cast<char>(random());
      WriteTextWhole(path, damaged);
      try {
        const Photo read = ReadPhoto(path);
        EXPECT_TRUE(cv::checkRange(read.pixels));
      } catch (const InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 40);  // Checksums of PNG and EXR alone see to a quarter of 160
}

// XYZ by D50 of the primaries, as their own profiles have them.
const cv::Matx33d kAdobeRgb(
    0.60974, 0.20528, 0.14919, 0.31111, 0.62567, 0.06322, 0.01947, 0.06087, 0.74457);
const cv::Matx33d kProPhoto(
    0.79767, 0.13519, 0.03135, 0.28804, 0.71188, 0.00009, 0.00000, 0.00000, 0.82491);
const cv::Matx33d kRec709(
    0.43607, 0.38515, 0.14307, 0.22249, 0.71687, 0.06061, 0.01392, 0.09708, 0.71410);

std::string PowerCurve(double exponent) {
  return "curv" + tests::BigEndian(0, 4) + tests::BigEndian(1, 4) +
         tests::BigEndian(static_cast<std::uint64_t>(std::lround(256 * exponent)), 2) +
         std::string(2, '\0');
}

std::string TableCurve(double exponent) {
  std::string curve = "curv" + tests::BigEndian(0, 4) + tests::BigEndian(1024, 4);
  for (int i = 0; i < 1024; ++i) {
    const double y = std::pow(i / 1023.0, exponent);
    curve += tests::BigEndian(static_cast<std::uint64_t>(std::lround(65535 * y)), 2);
  }
  return curve;
}

std::string SrgbCurve() {
  std::string curve =
      "para" + tests::BigEndian(0, 4) + tests::BigEndian(3, 2) + tests::BigEndian(0, 2);
  for (const double p : {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045}) {
    curve += tests::Fixed16(p);
  }
  return curve;
}

// The same light in files of several profiles, none of which has a name.
TEST_F(ReadPhotoTest, AProfileIsHonouredWhateverItsName) {
  // Colours of leaves and skies: where one channel is nearly black, a step of a wide
  // profile's codes is many of sRGB's
  Photo light = tests::SmoothPhoto(160, 120);
  light.pixels = 0.6f * light.pixels + cv::Scalar::all(0.2);
  WritePhoto(folder_ / "srgb.jpg", light, tests::kTestProvenance);
  const cv::Mat3f srgb = ReadPhoto(folder_ / "srgb.jpg").pixels;
  struct Case {
    const char* name;
    const cv::Matx33d& xyz_from_rgb;
    std::string curve;
    double exponent;  // 0: sRGB's curve
  };
  for (const Case& c : {Case{"adobe", kAdobeRgb, PowerCurve(563 / 256.0), 563 / 256.0},
                        Case{"prophoto", kProPhoto, TableCurve(1.8), 1.8},
                        Case{"rec709", kRec709, SrgbCurve(), 0}}) {
    // Their numbers: WritePhoto does sRGB's curve, so what it is given undoes it
    const cv::Matx33d from_rec709 = c.xyz_from_rgb.inv() * kRec709;
    Photo numbers;
    numbers.pixels = light.pixels.clone();
    for (cv::Vec3f& pixel : numbers.pixels) {
      const cv::Vec3d linear = from_rec709 * cv::Vec3d(pixel);
      for (int i = 0; i < 3; ++i) {
        const double up = std::max(linear[i], 0.0);
        pixel[i] = c.exponent > 0
                       ? LinearFromSrgb(static_cast<float>(std::pow(up, 1 / c.exponent)))
                       : static_cast<float>(up);
      }
    }
    const auto path = folder_ / (std::string(c.name) + ".jpg");
    WritePhoto(path, numbers, tests::kTestProvenance);
    WriteTextWhole(path,
                   tests::JpegWithIcc(ReadText(path),
                                      tests::MakeIccProfile(c.xyz_from_rgb, c.curve)));
    const Photo read = ReadPhoto(path);
    EXPECT_TRUE(read.notes.empty()) << c.name;
    double worst = 0, sum = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        for (int i = 0; i < 3; ++i) {
          const auto code = [](float v) { return 255 * SrgbFromLinear(v); };
          const double off = std::abs(code(read.pixels(y, x)[i]) - code(srgb(y, x)[i]));
          worst = std::max(worst, off);
          sum += off;
        }
      }
    }
    const double mean = sum / (3 * 120 * 160);
    std::cout << c.name << ": " << mean << " steps of 8 bits apart, at most " << worst
              << "\n";
    // JPEG's rounding of both files; a wide profile stretches it by two
    EXPECT_LT(mean, c.exponent > 0 ? 1.0 : 1e-3) << c.name;
    EXPECT_LT(worst, c.exponent > 0 ? 8.0 : 1e-3) << c.name;
  }
}

TEST_F(ReadPhotoTest, AProfileThatCannotBeReadIsSaid) {
  WritePhoto(folder_ / "a.jpg", tests::SmoothPhoto(20, 10), tests::kTestProvenance);
  const std::string jpeg = ReadText(folder_ / "a.jpg");
  const cv::Mat3f plain = ReadPhoto(folder_ / "a.jpg").pixels;
  const std::string whole = tests::MakeIccProfile(kAdobeRgb, PowerCurve(2.2));
  cv::Matx33d in_one_line = kAdobeRgb;
  for (int row = 0; row < 3; ++row) in_one_line(row, 1) = in_one_line(row, 0);
  std::string by_lab = whole;
  by_lab.replace(20, 4, "Lab ");
  for (const std::string& profile : {by_lab,
                                     whole.substr(0, whole.size() - 10),
                                     tests::MakeIccProfile(in_one_line, PowerCurve(2.2)),
                                     tests::MakeIccProfile(kAdobeRgb, PowerCurve(0))}) {
    WriteTextWhole(folder_ / "b.jpg", tests::JpegWithIcc(jpeg, profile));
    const Photo read = ReadPhoto(folder_ / "b.jpg");
    ASSERT_EQ(read.notes.size(), 1u);
    EXPECT_TRUE(Contains(read.notes[0], "--color-space")) << read.notes[0];
    EXPECT_EQ(cv::norm(read.pixels, plain, cv::NORM_INF), 0);
  }
  // Cut or changed anywhere: a photo, and no crash
  std::mt19937 random(7);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(random());
    WriteTextWhole(folder_ / "b.jpg", tests::JpegWithIcc(jpeg, changed));
    EXPECT_TRUE(cv::checkRange(ReadPhoto(folder_ / "b.jpg").pixels));
  }
}

TEST_F(ReadPhotoTest, SpacesOfOurOwnConfigKeepWhiteAndTheirPrimaries) {
  // Linear Rec.2020 green (0, 1, 0) in Rec.709, from the two standards' primaries
  WriteLinear(folder_ / "p.exr", {{"", cv::Mat3f(1, 2, cv::Vec3f(0, 1, 0))}});
  const cv::Vec3f green =
      ReadPhoto(folder_ / "p.exr", {.color_space = "Linear Rec.2020"}).pixels(0, 0);
  EXPECT_NEAR(green[0], -0.5876, 1e-4);  // Four digits, as ITU-R BT.2087 prints them
  EXPECT_NEAR(green[1], 1.1329, 1e-4);
  EXPECT_NEAR(green[2], -0.1006, 1e-4);
  WriteLinear(folder_ / "w.exr", {{"", cv::Mat3f(1, 2, cv::Vec3f(1, 1, 1))}});
  for (const std::string& space : ColorSpaceNames()) {
    const cv::Vec3f white =
        ReadPhoto(folder_ / "w.exr", {.color_space = space}).pixels(0, 1);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(white[c], 1.f, 2e-6) << space;  // Ten digits, floats
  }
  const std::string words = WordsOf<OptionError>(
      [&] { ReadPhoto(folder_ / "w.exr", {.color_space = "Kodak"}); });
  EXPECT_TRUE(Contains(words, "Kodak") && Contains(words, "ACEScg")) << words;
}

// A config whose scene_linear is Rec.709 at half the value, so that its use shows.
std::string ConfigText(bool interchange) {
  std::string text =
      "ocio_profile_version: 2\nstrictparsing: true\nroles:\n  scene_linear: Half\n"
      "  default: Half\n";
  if (interchange) text += "  aces_interchange: AP0\n";
  return text +
         "file_rules:\n"
         "  - !<Rule> {name: tiffs, colorspace: Film, pattern: \"*\", extension: tif}\n"
         "  - !<Rule> {name: Default, colorspace: Half}\n"
         "displays:\n  sRGB:\n    - !<View> {name: Raw, colorspace: Half}\n"
         "active_displays: []\nactive_views: []\n"
         "colorspaces:\n"
         "  - !<ColorSpace>\n    name: Half\n    isdata: false\n"
         "  - !<ColorSpace>\n    name: Film\n    isdata: false\n"
         "    to_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, "
         "0, 0, "
         "0, 0.5, 0, 0, 0, 0, 1]}\n"
         "  - !<ColorSpace>\n    name: AP0\n    isdata: false\n"
         "    to_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, "
         "0, 0, 2, "
         "0, 0, 0, 0, 1]}\n";
}

TEST_F(ReadPhotoTest, FollowsTheConfigThatOcioNames) {
  const auto photo = folder_ / "photo.tif";
  WriteTextWhole(photo,
                 MakeTiff(PictureFields(1, 1, kRgb, 3, 8), {}, {}, "\xFF\xFF\xFF"));
  const auto config = folder_ / "config.ocio";

  // Without interchange: Film is half of Half, and Half is taken as it is
  WriteTextWhole(config, ConfigText(false));
  {
    const WithEnvironment ocio("OCIO", config.string());
    const Photo read = ReadPhoto(photo);
    EXPECT_NEAR(read.pixels(0, 0)[0], 0.5f, 1e-6f);
    ASSERT_EQ(read.notes.size(), 2u);
    EXPECT_TRUE(Contains(read.notes[0], "Film"));
    EXPECT_TRUE(Contains(read.notes[1], "aces_interchange"));
  }
  // With it: a half of Half is a quarter of AP0, and white stays grey in Rec.709
  WriteTextWhole(config, ConfigText(true));
  {
    const WithEnvironment ocio("OCIO", config.string());
    const Photo read = ReadPhoto(photo);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(read.pixels(0, 0)[c], 0.25f, 1e-6f);
    EXPECT_EQ(read.notes.size(), 1u);
  }
}

TEST_F(ReadPhotoTest, NamesABrokenConfigAndTheRemedy) {
  const auto photo = folder_ / "photo.png";
  WritePhoto(photo, tests::SmoothPhoto(4, 4), tests::kTestProvenance);
  WriteTextWhole(folder_ / "broken.ocio", "ocio_profile_version: 2\nroles: [\n");
  for (const char* name : {"broken.ocio", "missing.ocio"}) {
    const auto config = folder_ / name;
    const WithEnvironment ocio("OCIO", config.string());
    const std::string words = WordsOf<InputError>([&] { ReadPhoto(photo); });
    EXPECT_TRUE(Contains(words, config.string()) && Contains(words, "unset OCIO"))
        << words;
  }
}

// A camera's RAW: a mosaic of R, G, B cells behind a grey card, with the white balance
// that makes it grey again. The left half is as bright again as the right one, its lower
// quarter is red: twice the red cells.
std::string GreyCardDng(std::uint16_t orientation) {
  constexpr int kWidth = 64, kHeight = 48;
  constexpr std::uint16_t kRed = 8192, kGreen = 16384, kBlue = 4096;  // Of 65535
  std::string cells;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool even_x = x % 2 == 0, even_y = y % 2 == 0;
      const bool left = x < kWidth / 2, red = left && y >= kHeight / 2;
      const int cell = even_x && even_y     ? (red ? 2 * kRed : kRed)
                       : !even_x && !even_y ? kBlue
                                            : kGreen;
      cells += tests::Bytes(static_cast<std::uint16_t>(left ? cell : cell / 2));
    }
  }
  constexpr int kCfa = 32803;
  std::vector<tests::TiffField> fields = PictureFields(kWidth, kHeight, kCfa, 1, 16);
  fields.push_back(tests::TextField(271, "relight"));
  fields.push_back(tests::TextField(272, "Grey Card"));
  fields.push_back(ShortField(274, {orientation}));
  fields.push_back(ShortField(33421, {2, 2}));                     // CFARepeatPatternDim
  fields.push_back(tests::ByteField(33422, {0, 1, 1, 2}));         // CFAPattern
  fields.push_back(tests::ByteField(50706, {1, 4, 0, 0}));         // DNGVersion
  fields.push_back(tests::TextField(50708, "relight Grey Card"));  // UniqueCameraModel
  fields.push_back(ShortField(50717, {65535}));                    // WhiteLevel
  // ColorMatrix1: XYZ to camera, here that of linear Rec.709
  std::vector<tests::Fraction> matrix;
  for (const int v : {32405, -15371, -4985, -9693, 18760, 416, 556, -2040, 10572}) {
    matrix.emplace_back(static_cast<std::uint32_t>(v), 10000u);
  }
  fields.push_back(tests::RationalField(50721, matrix, 10));
  fields.push_back(ShortField(50778, {21}));  // CalibrationIlluminant1: D65
  fields.push_back(
      tests::RationalField(50728, {{1, 2}, {1, 1}, {1, 4}}));  // AsShotNeutral
  return MakeTiff(fields, {}, {}, cells);
}

TEST_F(ReadPhotoTest, DevelopsARawLinearWithTheCamerasWhiteBalance) {
  const auto path = folder_ / "card.dng";
  WriteTextWhole(path, GreyCardDng(1));
  const Photo photo = ReadPhoto(path);
  EXPECT_EQ(photo.pixels.size(), cv::Size(64, 48));
  // Linear: green cells hold a quarter and an eighth of white; 16 bits and fixed-point
  // matrices
  constexpr float kRounding = 0.003f;
  const cv::Vec3f grey(0.25f, 0.25f, 0.25f), red(0.5f, 0.25f, 0.25f);
  const auto is = [&](const cv::Mat3f& picture, int x, int y, const cv::Vec3f& color) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(picture(y, x)[c], color[c], kRounding) << x << ", " << y << ": " << c;
    }
  };
  is(photo.pixels, 16, 12, grey);
  is(photo.pixels, 48, 12, grey / 2);
  is(photo.pixels, 16, 36, red);

  // Once, though LibRaw turns it as well: the stored lower left corner stays the red one
  WriteTextWhole(path, GreyCardDng(6));  // A quarter clockwise
  const cv::Mat3f quarter = ReadPhoto(path).pixels;
  ASSERT_EQ(quarter.size(), cv::Size(48, 64));
  is(quarter, 12, 16, red);
  is(quarter, 36, 16, grey);
  is(quarter, 36, 48, grey / 2);
  WriteTextWhole(path, GreyCardDng(8));
  is(ReadPhoto(path).pixels, 36, 48, red);
  WriteTextWhole(path, GreyCardDng(3));
  is(ReadPhoto(path).pixels, 48, 12, red);
}

TEST_F(ReadPhotoTest, RefusesARawWhosePixelsAreCutOff) {
  const std::string whole = GreyCardDng(1);
  const auto path = folder_ / "cut.dng";
  for (const std::size_t missing : {2u, 500u, 5000u}) {
    WriteTextWhole(path, whole.substr(0, whole.size() - missing));
    EXPECT_THROW(ReadPhoto(path), InputError) << missing;
  }
}

TEST_F(ReadPhotoTest, IsTheSameForAnyNumberOfThreads) {
  const auto path = folder_ / "a.jpg";
  WritePhoto(path, tests::SmoothPhoto(200, 300), tests::kTestProvenance);
  const ReadPhotoOptions options{.tone = Tone::kCamera, .color_space = "Display P3"};
  SetThreadCount(1);
  const Photo one = ReadPhoto(path, options);
  SetThreadCount(4);
  const Photo four = ReadPhoto(path, options);
  SetThreadCount(0);
  EXPECT_EQ(std::memcmp(one.pixels.data, four.pixels.data, one.pixels.total() * 12), 0);
}

TEST_F(ReadPhotoTest, TheMaplesJpegIsItsLinearPhotoTimesItsGain) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/photos/view_00.jpg");
  const cv::Mat3f jpeg =
      ReadPhoto(tests::SharedPath("data/maple/photos/view_00.jpg")).pixels;
  const cv::Mat3f linear =
      ReadPhoto(tests::SharedPath("data/maple/linear/view_00.exr")).pixels;
  constexpr double kJpegGain = 1.7300950369588175;  // capture_truth.json
  const cv::Scalar a = cv::mean(jpeg), b = cv::mean(linear * kJpegGain);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(a[c] / b[c], 1.0, 0.02) << c;  // JPEG, clipped lights
}

// 24 megapixels, to be turned: the peak of the memory held while reading.
TEST_F(ReadPhotoTest, NeedsNoMoreThanThreeCopiesInMemory) {
  const auto path = folder_ / "large.jpg";
  constexpr int kWidth = 6000, kHeight = 4000;
  constexpr double kCopy = 12.0 * kWidth * kHeight;
  {
    Photo photo;
    photo.pixels = cv::Mat3f(kHeight, kWidth, cv::Vec3f(0.2f, 0.4f, 0.1f));
    tests::WriteJpegWithExif(path, photo, MakeTiff({ShortField(274, {6})}));
  }
  const auto kilobytes = [](const char* what) {
    const std::string status = ReadText("/proc/self/status");
    return std::atof(status.c_str() + status.find(what) + std::strlen(what));
  };
  if (FILE* reset = std::fopen("/proc/self/clear_refs", "w")) {
    std::fputs("5", reset);  // The peak is now what is held
    std::fclose(reset);
  }
  const double before_kb = kilobytes("VmRSS:");
  const Photo photo = ReadPhoto(path);
  const double grown = (kilobytes("VmHWM:") - before_kb) * 1024.0;
  EXPECT_EQ(photo.pixels.size(), cv::Size(kHeight, kWidth));
  EXPECT_LT(grown, 3.0 * kCopy);
  EXPECT_GT(grown, 1.0 * kCopy);  // Else the measurement measures nothing
}

}  // namespace
}  // namespace relight
