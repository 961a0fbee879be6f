// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/heif_metadata.h"

#include "relight/photo/color.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/read_photo.h"
#include "tests/relight/photo/made_files.h"

#include <gtest/gtest.h>

#include <string>

namespace relight {
namespace {

std::string Big(std::uint64_t value, unsigned bytes) {
  return tests::BigEndian(value, bytes);
}

std::string Box(const std::string& type, const std::string& content) {
  return Big(8 + content.size(), 4) + type + content;
}

std::string FromHex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

// 64 x 64 pixels by x265: the left 24 columns (204, 77, 51), the others (51, 153, 77).
const std::string kDecoder = FromHex(
    "0103700000000000000000001ef000fcfdf8f800000f03200001001840010c01ffff03700000030090"
    "000003000003001eba0240210001002a42010103700000030090000003000003001ea020810596eae4"
    "a6b9b8101030200000030020000003002122000100064401c173c089");
const std::string kPixels = FromHex(
    "000000382801af09e0c71935797ff32ffffb1e721deccd32274e9f4397ff283ca8f120737b46d28315"
    "c9f9371588568bc3dc6a9bb1170e0c25c27c07");

// A HEIC of that picture, with an EXIF item and a colour box when they are not empty. The
// item lies in the file, or in the box of items' data. To be shown, it is turned against
// the clock by `quarter_turns`.
std::string MakeHeic(const std::string& exif_item,
                     const std::string& color,
                     bool in_idat = false,
                     int quarter_turns = 0) {
  const std::string file_type = Box("ftyp", "heic" + Big(0, 4) + "mif1heic");
  const auto meta = [&](std::size_t pixels_at) {
    const auto entry = [](int id, const std::string& type) {
      return Box(
          "infe",
          Big(2, 1) + Big(0, 3) + Big(id, 2) + Big(0, 2) + type + std::string(1, 0));
    };
    // Offsets and lengths of 4 bytes; version 1 says where to count from
    const auto location = [&](int id, int where, std::size_t at, std::size_t length) {
      return Big(id, 2) + Big(where, 2) + Big(0, 2) + Big(1, 2) + Big(at, 4) +
             Big(length, 4);
    };
    const int items = exif_item.empty() ? 1 : 2;
    std::string info = Big(0, 4) + Big(items, 2) + entry(1, "hvc1");
    std::string places = Big(1, 1) + Big(0, 3) + Big(0x4400, 2) + Big(items, 2) +
                         location(1, 0, pixels_at, kPixels.size());
    if (items == 2) {
      info += entry(2, "Exif");
      places += location(
          2, in_idat ? 1 : 0, in_idat ? 0 : pixels_at + kPixels.size(), exif_item.size());
    }
    std::string properties =
        Box("hvcC", kDecoder) + Box("ispe", Big(0, 4) + Big(64, 4) + Big(64, 4));
    std::string of_picture = FromHex("8102");  // Of those above; 80: not to be ignored
    int count = 2;
    const auto add = [&](const std::string& property, int flag) {
      properties += property;
      of_picture += static_cast<char>(flag | ++count);
    };
    if (!color.empty()) add(Box("colr", color), 0);
    if (quarter_turns > 0) add(Box("irot", Big(quarter_turns, 1)), 0x80);
    const std::string of_primary =
        Big(0, 4) + Big(1, 4) + Big(1, 2) + Big(count, 1) + of_picture;
    return Box("meta",
               Big(0, 4) + Box("hdlr", Big(0, 8) + "pict" + Big(0, 8) + Big(0, 5)) +
                   Box("pitm", Big(0, 4) + Big(1, 2)) + Box("iloc", places) +
                   Box("iinf", info) +
                   Box("iprp", Box("ipco", properties) + Box("ipma", of_primary)) +
                   (in_idat ? Box("idat", exif_item) : ""));
  };
  const std::size_t pixels_at = file_type.size() + meta(0).size() + 8;
  return file_type + meta(pixels_at) + Box("mdat", kPixels + (in_idat ? "" : exif_item));
}

std::string TakenAtNoon() {
  return tests::MakeTiff(
      {},
      {tests::TextField(36867, "2024:06:21 12:34:56"), tests::TextField(36881, "+02:00")},
      {tests::TextField(1, "N"),
       tests::RationalField(2, {{48, 1}, {51, 1}, {0, 1}}),
       tests::TextField(3, "E"),
       tests::RationalField(4, {{2, 1}, {21, 1}, {0, 1}})});
}

std::string ToExif(std::uint32_t bytes_between) {
  return Big(bytes_between, 4) + std::string("Exif\0\0", 6).substr(0, bytes_between) +
         TakenAtNoon();
}

// Phones write "Exif\0\0" before the TIFF, converters do not.
TEST(HeifMetadata, FindsExifWhereverItsItemSaysThatItBegins) {
  const tests::TemporaryFolder folder;
  const auto path = folder / "tree.heic";
  for (const std::uint32_t between : {6u, 0u}) {
    for (const bool in_idat : {false, true}) {
      WriteTextWhole(path, MakeHeic(ToExif(between), "", in_idat));
      EXPECT_EQ(ReadHeifMetadata(path).exif, TakenAtNoon());
      const PhotoFacts facts = ReadPhotoFacts(path);
      EXPECT_EQ(facts.width, 64);
      ASSERT_TRUE(facts.local_time && facts.offset && facts.place);
      EXPECT_EQ(facts.offset->count(), 120);
      EXPECT_NEAR(facts.place->latitude_deg, 48.85, 1e-9);
    }
  }
  WriteTextWhole(path, MakeHeic("", ""));
  EXPECT_EQ(ReadHeifMetadata(path).exif, "");
  EXPECT_FALSE(ReadPhotoFacts(path).local_time);
}

TEST(HeifMetadata, PixelsAreDisplayCodesOfTheProfileThatTheFileNames) {
  const tests::TemporaryFolder folder;
  const auto path = folder / "tree.heic";
  WriteTextWhole(path, MakeHeic("", ""));
  const Photo plain = ReadPhoto(path);
  ASSERT_EQ(plain.pixels.size(), cv::Size(64, 64));
  // Of 8 bits, at some 30 dB less than lossless: within 3 codes of what was written
  const auto code = [](float linear) { return 255 * SrgbFromLinear(linear); };
  EXPECT_NEAR(code(plain.pixels(16, 8)[0]), 204, 3);
  EXPECT_NEAR(code(plain.pixels(16, 40)[1]), 153, 3);

  // The same codes are other colours by Display P3's primaries: a red of P3 has more
  // red than Rec.709's, a green less red
  const std::string display_p3 =
      "nclx" + Big(12, 2) + Big(13, 2) + Big(6, 2) + Big(128, 1);
  WriteTextWhole(path, MakeHeic("", display_p3));
  EXPECT_EQ(ReadHeifMetadata(path).primaries, 12);
  const Photo wide = ReadPhoto(path);
  EXPECT_GT(wide.pixels(16, 8)[0], 1.1f * plain.pixels(16, 8)[0]);
  EXPECT_LT(wide.pixels(16, 40)[0], plain.pixels(16, 40)[0]);

  WriteTextWhole(path, MakeHeic("", "profwhatever a profile holds"));
  EXPECT_EQ(ReadHeifMetadata(path).icc, "whatever a profile holds");
  EXPECT_EQ(ReadPhoto(path).pixels(16, 8), plain.pixels(16, 8));
}

// Phones write the turn twice: for decoders, and in EXIF.
TEST(HeifMetadata, IsTurnedUprightOnce) {
  const tests::TemporaryFolder folder;
  const auto path = folder / "turned.heic";
  const std::string exif_6 = tests::MakeTiff({tests::ShortField(274, {6})});
  WriteTextWhole(path, MakeHeic(Big(0, 4) + exif_6, "", false, 3));
  const cv::Mat3f turned = ReadPhoto(path).pixels;
  ASSERT_EQ(turned.size(), cv::Size(64, 64));
  // Its red left 24 columns come to the top, by three quarters against the clock
  EXPECT_GT(turned(8, 8)[0], 2 * turned(8, 8)[1]);
  EXPECT_GT(turned(8, 56)[0], 2 * turned(8, 56)[1]);
  EXPECT_GT(turned(56, 8)[1], 2 * turned(56, 8)[0]);
  WriteTextWhole(path, MakeHeic(Big(0, 4) + exif_6, "", false, 1));
  EXPECT_GT(ReadPhoto(path).pixels(56, 8)[0], 2 * turned(8, 8)[1]);
}

// Apple's phones embed the profile whole; OpenImageIO passes it over.
TEST(HeifMetadata, ItsProfileIsHonoured) {
  const tests::TemporaryFolder folder;
  const auto named = folder / "named.heic", embedded = folder / "embedded.heic";
  WriteTextWhole(
      named, MakeHeic("", "nclx" + Big(12, 2) + Big(13, 2) + Big(6, 2) + Big(128, 1)));
  std::string curve = "para" + Big(0, 4) + Big(3, 2) + Big(0, 2);
  for (const double p : {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045}) {
    curve += tests::Fixed16(p);
  }
  // Display P3 by D50, as its profiles have it
  const cv::Matx33d display_p3(
      0.51512, 0.29198, 0.15710, 0.24120, 0.69225, 0.06657, -0.00105, 0.04189, 0.78407);
  WriteTextWhole(embedded,
                 MakeHeic("", "prof" + tests::MakeIccProfile(display_p3, curve)));
  const Photo by_name = ReadPhoto(named), by_profile = ReadPhoto(embedded);
  EXPECT_TRUE(by_profile.notes.empty());
  for (const int x : {8, 40}) {
    for (int c = 0; c < 3; ++c) {
      // Profiles have five digits
      EXPECT_NEAR(by_profile.pixels(16, x)[c], by_name.pixels(16, x)[c], 2e-4);
    }
  }
}

TEST(HeifMetadata, SurvivesAFileCutOrChangedAtEveryByte) {
  const tests::TemporaryFolder folder;
  const auto path = folder / "broken.heic";
  const std::string whole = MakeHeic(ToExif(6), "nclx" + Big(12, 2) + Big(13, 2));
  const std::size_t length = ReadHeifMetadata(path).exif.size();
  EXPECT_EQ(length, 0u);  // No such file
  for (std::size_t at = 0; at < whole.size(); ++at) {
    WriteTextWhole(path, whole.substr(0, at));
    EXPECT_LE(ReadHeifMetadata(path).exif.size(), whole.size());
    for (const char value : {'\0', '\x7F', '\xFF'}) {
      std::string changed = whole;
      changed[at] = value;
      WriteTextWhole(path, changed);
      EXPECT_LE(ReadHeifMetadata(path).exif.size(), whole.size());
    }
  }
}

}  // namespace
}  // namespace relight
