// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/image_file.h"

#include "relight/base/error.h"
#include "relight/photo/write_photo.h"
#include "tests/relight/photo/made_files.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace relight {
namespace {

using tests::TemporaryFolder;

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(ImageFile, LinearLayersComeBackToTheBit) {
  const TemporaryFolder folder;
  cv::Mat3f sun(31, 17);
  cv::Mat1f confidence(31, 17);
  cv::RNG random(2);
  random.fill(sun, cv::RNG::UNIFORM, -1e4, 1e5);
  random.fill(confidence, cv::RNG::UNIFORM, 0.0, 1.0);
  sun(3, 4)[1] = std::numeric_limits<float>::quiet_NaN();
  sun(5, 4)[2] = 1e-40f;  // Not normal
  const std::map<std::string, std::string> metadata = {{"relight:options", "{\"a\": 1}"},
                                                       {"relight:hash", "0123"}};
  const auto path = folder / "light.exr";
  WriteLinear(
      path, {{"sun", sun}, {"", sun * 2.f}, {"confidence", confidence}}, metadata);
  const LinearFile back = ReadLinearFile(path);
  ASSERT_EQ(back.layers.size(), 3u);
  EXPECT_EQ(back.layers[1].name, "confidence");
  EXPECT_TRUE(SameBits(back.layers[1].values, confidence));
  EXPECT_EQ(back.layers[2].name, "sun");
  EXPECT_TRUE(SameBits(back.layers[2].values, sun));
  EXPECT_EQ(back.metadata, metadata);
  EXPECT_TRUE(SameBits(ReadLinear(path, "sun"), sun));
  EXPECT_TRUE(SameBits(ReadLinear(path), cv::Mat3f(sun * 2.f)));
  EXPECT_EQ(ReadLinear(path, "confidence")(7, 7)[2], confidence(7, 7));
  const std::string words = tests::WordsOf<InputError>([&] { ReadLinear(path, "moon"); });
  EXPECT_NE(words.find("\"sun\""), std::string::npos) << words;
}

TEST(ImageFile, LinearFilesAreTheSameBytesASecondLater) {
  const TemporaryFolder folder;
  const cv::Mat1f values(20, 30, 0.5f);
  WriteLinear(folder / "a.exr", {{"", values}});
  const timespec second{.tv_sec = 1, .tv_nsec = 50000000};
  nanosleep(&second, nullptr);
  WriteLinear(folder / "b.exr", {{"", values}});
  EXPECT_EQ(ReadText(folder / "a.exr"), ReadText(folder / "b.exr"));
}

TEST(ImageFile, MattesComeBackWithinHalfAStepOf16Bits) {
  const TemporaryFolder folder;
  cv::Mat1f matte(40, 30);
  cv::RNG(4).fill(matte, cv::RNG::UNIFORM, 0.0, 1.0);
  matte(0, 0) = 0.f;
  matte(0, 1) = 1.f;
  matte(0, 2) = 1.25f;
  matte(0, 3) = -0.5f;
  WriteMatte(folder / "m.png", matte);
  const cv::Mat1f back = ReadMatte(folder / "m.png");
  EXPECT_EQ(back(0, 0), 0.f);
  EXPECT_EQ(back(0, 1), 1.f);
  EXPECT_EQ(back(0, 2), 1.f);
  EXPECT_EQ(back(0, 3), 0.f);
  matte(0, 2) = 1.f;
  matte(0, 3) = 0.f;
  EXPECT_LE(cv::norm(back, matte, cv::NORM_INF),
            0.5 / 65535 + 6e-8);  // And a float's step
  matte(0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(WriteMatte(folder / "n.png", matte), std::logic_error);
}

TEST(ImageFile, AMatteIsTheAlphaWhereItSaysSomethingElseTheGrey) {
  const TemporaryFolder folder;
  Photo photo = tests::SmoothPhoto(8, 8);
  photo.alpha = cv::Mat1f(8, 8, 0.25f);
  WritePhoto(folder / "alpha.png", photo, tests::kTestProvenance);
  EXPECT_NEAR(ReadMatte(folder / "alpha.png")(3, 3), 0.25, 1.0 / 65535);

  // Opaque and grey, as an editor saves a mask
  photo.pixels = cv::Mat3f(8, 8, cv::Vec3f(1, 1, 1));
  photo.pixels.colRange(0, 4) = cv::Vec3f(0, 0, 0);
  photo.alpha = 1.f;
  WritePhoto(folder / "mask.png", photo, tests::kTestProvenance);
  EXPECT_EQ(ReadMatte(folder / "mask.png")(3, 1), 0.f);
  EXPECT_EQ(ReadMatte(folder / "mask.png")(3, 6), 1.f);

  // A photo is no matte
  WritePhoto(folder / "photo.png", tests::SmoothPhoto(8, 8), tests::kTestProvenance);
  const std::string words =
      tests::WordsOf<InputError>([&] { ReadMatte(folder / "photo.png"); });
  EXPECT_NE(words.find("in colour"), std::string::npos);

  // No curve is undone: half is half
  WriteTextWhole(folder / "half.tif",
                 tests::MakeTiff({tests::LongField(256, 1),
                                  tests::LongField(257, 1),
                                  tests::ShortField(258, {8}),
                                  tests::ShortField(259, {1}),
                                  tests::ShortField(262, {1}),
                                  tests::ShortField(277, {1}),
                                  tests::LongField(278, 1)},
                                 {},
                                 {},
                                 "\x80"));
  EXPECT_EQ(ReadMatte(folder / "half.tif")(0, 0), static_cast<float>(128 / 255.0));
}

TEST(ImageFile, FloatMattesOutsideTheirRangeAreRefused) {
  const TemporaryFolder folder;
  WriteLinear(folder / "m.exr", {{"", cv::Mat1f(4, 4, 255.f)}});
  EXPECT_THROW(ReadMatte(folder / "m.exr"), InputError);
  WriteLinear(folder / "n.exr", {{"", cv::Mat1f(4, 4, std::nanf(""))}});
  EXPECT_THROW(ReadMatte(folder / "n.exr"), InputError);
  WriteLinear(folder / "o.exr", {{"", cv::Mat1f(4, 4, 1.01f)}});
  EXPECT_EQ(ReadMatte(folder / "o.exr")(0, 0), 1.f);
}

}  // namespace
}  // namespace relight
