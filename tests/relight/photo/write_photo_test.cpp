// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/write_photo.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/read_photo.h"
#include "tests/relight/photo/made_files.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <csignal>
#include <limits>

namespace relight {
namespace {

using tests::TemporaryFolder;
using tests::WordsOf;

class WritePhotoTest : public testing::Test {
 protected:
  tests::WithEnvironment no_ocio_{"OCIO", std::nullopt};
  TemporaryFolder folder_;
};

Photo NoisyPhoto(int width, int height, bool alpha) {
  Photo photo = tests::SmoothPhoto(width, height);
  cv::RNG random(9);
  random.fill(photo.pixels, cv::RNG::UNIFORM, 0.0, 1.0);
  if (alpha) {
    photo.alpha.create(height, width);
    random.fill(photo.alpha, cv::RNG::UNIFORM, 0.0, 1.0);
    photo.alpha(0, 0) = 0.f;
    photo.alpha(0, 1) = 1.f;
  }
  return photo;
}

TEST_F(WritePhotoTest, SixteenBitFormatsComeBackWithinAStep) {
  constexpr double kHalfStep = 0.5 / 65535 + 2e-7;  // And float powers
  for (const char* name : {"a.png", "a.tif", "a.TIFF"}) {
    for (const bool alpha : {false, true}) {
      const Photo photo = NoisyPhoto(33, 21, alpha);
      const WriteSummary summary =
          WritePhoto(folder_ / name, photo, tests::kTestProvenance);
      EXPECT_EQ(summary.clipped_pixels, 0);
      const Photo back = ReadPhoto(folder_ / name);
      // Straight alpha: colours come back even where nothing shows
      EXPECT_LE(cv::norm(DisplayFromLinear(back.pixels),
                         DisplayFromLinear(photo.pixels),
                         cv::NORM_INF),
                kHalfStep)
          << name;
      ASSERT_EQ(back.alpha.empty(), !alpha);
      if (alpha) {
        EXPECT_LE(cv::norm(back.alpha, photo.alpha, cv::NORM_INF), kHalfStep) << name;
      }
      EXPECT_TRUE(back.notes.empty());
    }
  }
}

TEST_F(WritePhotoTest, HalfExrComesBackWithinAStepOfAHalf) {
  Photo photo = NoisyPhoto(33, 21, false);
  photo.pixels *= 40.f;
  WritePhoto(folder_ / "a.exr", photo, tests::kTestProvenance);
  const Photo back = ReadPhoto(folder_ / "a.exr");
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 33; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float v = photo.pixels(y, x)[c];
        EXPECT_NEAR(back.pixels(y, x)[c], v, v / 2048 + 6e-8);  // 11 bits of mantissa
      }
    }
  }
}

TEST_F(WritePhotoTest, JpegIsNearAndTakesNoAlpha) {
  const Photo photo = tests::SmoothPhoto(64, 48);
  WritePhoto(folder_ / "a.jpg", photo, tests::kTestProvenance);
  const Photo back = ReadPhoto(folder_ / "a.jpg");
  // At quality 95 a coefficient is rounded to some 2 of 255, 64 of them add up: half of
  // one step on average; ten at the foot of the curve, where blocks hold high frequencies
  const cv::Mat3f display = DisplayFromLinear(photo.pixels);
  const cv::Mat3f read = DisplayFromLinear(back.pixels);
  EXPECT_LT(cv::norm(read, display, cv::NORM_L1) / (3.0 * display.total()), 1.0 / 255);
  EXPECT_LT(cv::norm(read, display, cv::NORM_INF), 10.0 / 255);
  EXPECT_THROW(
      WritePhoto(folder_ / "b.jpg", NoisyPhoto(8, 8, true), tests::kTestProvenance),
      OptionError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.jpg"));
  EXPECT_THROW(
      WritePhoto(folder_ / "b.jpg", photo, tests::kTestProvenance, {.quality = 0}),
      OptionError);
}

TEST_F(WritePhotoTest, CountsWhatItCuts) {
  Photo photo;
  photo.pixels = cv::Mat3f(2, 3, cv::Vec3f(0.5f, 0.5f, 0.5f));
  photo.pixels(0, 0) = {1.5f, 0.5f, 0.5f};
  photo.pixels(0, 1) = {0.5f, -0.1f, 0.5f};
  photo.pixels(0, 2) = {1e6f, 0.5f, 0.5f};
  photo.pixels(1, 0)[2] = std::numeric_limits<float>::quiet_NaN();
  const WriteSummary display =
      WritePhoto(folder_ / "a.png", photo, tests::kTestProvenance);
  EXPECT_EQ(display.clipped_pixels, 2);
  EXPECT_EQ(display.negative_pixels, 1);
  EXPECT_EQ(display.non_finite_pixels, 1);
  const WriteSummary half = WritePhoto(folder_ / "a.exr", photo, tests::kTestProvenance);
  EXPECT_EQ(half.clipped_pixels, 1);
  const Photo back = ReadPhoto(folder_ / "a.exr");
  EXPECT_EQ(back.pixels(0, 2)[0], 65504.f);  // The largest half
  EXPECT_NEAR(back.pixels(0, 1)[1], -0.1f, 1e-4f);
  EXPECT_EQ(back.non_finite_pixels, 0);

  // What is transparent is not seen, nor counted
  photo.alpha = cv::Mat1f(2, 3, 0.f);
  EXPECT_EQ(WritePhoto(folder_ / "b.png", photo, tests::kTestProvenance).clipped_pixels,
            0);
}

TEST_F(WritePhotoTest, EveryFormatSaysThatItIsOurs) {
  std::string json =
      R"({"sun": {"azimuth_deg": 253.4}, "note": "Stra\u00dfe, Ä, \"quoted\"\n", )"
      R"("inputs": [)";
  while (json.size() < 29000) json += R"("0123456789abcdef0123456789abcdef", )";
  json += "0]}";
  for (const char* name : {"a.exr", "a.png", "a.tif", "a.jpg"}) {
    WritePhoto(folder_ / name, tests::SmoothPhoto(16, 16), {"relight 0.1.0", json});
    const PhotoFacts facts = ReadPhotoFacts(folder_ / name);
    EXPECT_TRUE(facts.made_by_relight) << name;
    EXPECT_EQ(facts.software, "relight 0.1.0") << name;
    EXPECT_EQ(facts.provenance_json, json) << name;
  }
}

TEST_F(WritePhotoTest, SamePhotoSameBytesWhateverTheThreadsAndTheHour) {
  for (const char* name : {"a.exr", "a.png", "a.tif", "a.jpg"}) {
    const Photo photo = NoisyPhoto(70, 50, std::string(name) != "a.jpg");
    SetThreadCount(1);
    WritePhoto(folder_ / name, photo, tests::kTestProvenance);
    const std::string first = ReadText(folder_ / name);
    SetThreadCount(4);
    const timespec second{.tv_sec = 1, .tv_nsec = 50000000};  // Time stamps count seconds
    nanosleep(&second, nullptr);
    WritePhoto(folder_ / name, photo, tests::kTestProvenance);
    SetThreadCount(0);
    EXPECT_EQ(ReadText(folder_ / name), first) << name;
  }
}

TEST_F(WritePhotoTest, UnknownExtensionsListTheKnown) {
  const std::string words = WordsOf<OptionError>([&] {
    WritePhoto(folder_ / "a.bmp", tests::SmoothPhoto(4, 4), tests::kTestProvenance);
  });
  for (const std::string& known : WritableExtensions()) {
    EXPECT_NE(words.find(known), std::string::npos) << words;
  }
}

// Whatever fills up or forbids: an error in words, no partial file, what was there stays.
void ExpectNothingIsWritten(const std::filesystem::path& folder) {
  const Photo photo =
      NoisyPhoto(300, 200, false);  // Noise: 100 kB and more in any format
  for (const char* name : {"a.exr", "a.png", "a.tif", "a.jpg"}) {
    std::string words;
    try {
      WritePhoto(folder / name, photo, tests::kTestProvenance);
    } catch (const InputError& e) {
      words = e.what();
    }
    EXPECT_NE(words.find((folder / name).string()), std::string::npos) << name << words;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(WritePhotoTest, WritesNothingPastTheLimitOfAFile) {
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{.rlim_cur = 20000, .rlim_max = limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  ExpectNothingIsWritten(folder_.path());
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, before);
}

TEST_F(WritePhotoTest, WritesNothingOnAFullDisk) {
  const auto disk = folder_ / "disk";
  std::filesystem::create_directory(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=16k") != 0) {
    GTEST_SKIP() << "mounting a small disk is not allowed here";
  }
  ExpectNothingIsWritten(disk);
  umount(disk.c_str());
}

TEST_F(WritePhotoTest, NamesAFolderThatIsNotThere) {
  const auto path = folder_ / "no/a.png";
  const std::string words = WordsOf<InputError>(
      [&] { WritePhoto(path, tests::SmoothPhoto(4, 4), tests::kTestProvenance); });
  EXPECT_NE(words.find(path.string()), std::string::npos);
}

}  // namespace
}  // namespace relight
