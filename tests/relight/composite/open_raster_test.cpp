// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/open_raster.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/photo/color.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/read_photo.h"
#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace relight {
namespace {

using tests::ScratchFolder;

const Provenance kProvenance{"relight 0.0.0", "{\"photo\":\"a.jpg\"}"};

Montage RandomMontage(cv::Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  Montage montage{cv::Mat3f(size), cv::Mat1f(size), cv::Mat3f(size), cv::Mat3f(size)};
  for (cv::Mat3f* colors : {&montage.tree, &montage.shadow, &montage.backdrop}) {
    for (cv::Vec3f& color : *colors) {
      color = {uniform(random), uniform(random), uniform(random)};
    }
  }
  for (float& alpha : montage.alpha) {
    alpha =
        std::clamp(3 * uniform(random) - 1, 0.f, 1.f);  // A third is opaque, one clear
  }
  return montage;
}

// The entries of a zip archive without compression, read by hand from its local headers.
struct Stored {
  std::string name, bytes;
};
std::vector<Stored> ReadStored(const std::string& zip) {
  const auto number = [&](std::size_t at, int bytes) {
    std::size_t value = 0;
    for (int i = bytes - 1; i >= 0; --i) {
      value = value << 8 |
              static_cast<std::uint8_t>(zip.at(at + static_cast<std::size_t>(i)));
    }
    return value;
  };
  std::vector<Stored> entries;
  std::size_t at = 0;
  while (zip.compare(at, 4, "PK\3\4") == 0) {
    EXPECT_EQ(number(at + 6, 2) & 8, 0u) << "sizes stand before the data";
    EXPECT_EQ(number(at + 8, 2), 0u) << "not compressed";
    EXPECT_EQ(number(at + 10, 2), 0u) << "midnight";
    EXPECT_EQ(number(at + 12, 2), 0x21u) << "of 1980-01-01";
    const std::size_t size = number(at + 18, 4), name = number(at + 26, 2),
                      extra = number(at + 28, 2);
    entries.push_back(
        {zip.substr(at + 30, name), zip.substr(at + 30 + name + extra, size)});
    at += 30 + name + extra + size;
  }
  EXPECT_EQ(zip.compare(at, 4, "PK\1\2"), 0) << "the directory follows";
  return entries;
}

TEST(OpenRaster, IsAnArchiveOfItsLayers) {
  const ScratchFolder folder;
  const Montage montage = RandomMontage({300, 200}, 1);
  WriteOpenRaster(folder / "a.ora", montage, kProvenance);
  const std::string bytes = ReadText(folder / "a.ora");
  // As file(1) and the freedesktop database know the format
  EXPECT_EQ(bytes.substr(30, 24), "mimetypeimage/openraster");
  std::vector<std::string> names;
  std::map<std::string, std::string> files;
  for (const auto& [name, content] : ReadStored(bytes)) {
    names.push_back(name);
    files[name] = content;
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"mimetype",
                                      "stack.xml",
                                      "data/tree.png",
                                      "data/shadow.png",
                                      "data/backdrop.png",
                                      "mergedimage.png",
                                      "Thumbnails/thumbnail.png"}));

  // The top layer first
  const std::string& stack = files["stack.xml"];
  EXPECT_NE(stack.find("<image version=\"0.0.3\" w=\"300\" h=\"200\">"),
            std::string::npos);
  const std::size_t tree =
      stack.find("name=\"tree\" src=\"data/tree.png\" composite-op=\"svg:src-over\"");
  const std::size_t shadow =
      stack.find("name=\"shadow\" src=\"data/shadow.png\" composite-op=\"svg:multiply\"");
  const std::size_t backdrop = stack.find("name=\"backdrop\"");
  ASSERT_NE(tree, std::string::npos);
  ASSERT_NE(shadow, std::string::npos);
  ASSERT_NE(backdrop, std::string::npos);
  EXPECT_LT(tree, shadow);
  EXPECT_LT(shadow, backdrop);

  const auto picture = [&](const std::string& name) {
    WriteTextWhole(folder / "layer.png", files[name]);
    return ReadPhoto(folder / "layer.png");
  };
  const double half_step = 0.5 / 255 + 1e-4;  // 8 bits, and the reader's float table
  const Photo tree_layer = picture("data/tree.png");
  const Photo shadow_layer = picture("data/shadow.png");
  EXPECT_TRUE(shadow_layer.alpha.empty());
  for (int row = 0; row < 200; ++row) {
    for (int column = 0; column < 300; ++column) {
      EXPECT_NEAR(tree_layer.alpha(row, column), montage.alpha(row, column), half_step);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(SrgbFromLinear(shadow_layer.pixels(row, column)[c]),
                    SrgbFromLinear(montage.shadow(row, column)[c]),
                    half_step);
        if (tree_layer.alpha(row, column) == 0) continue;
        EXPECT_NEAR(SrgbFromLinear(tree_layer.pixels(row, column)[c]),
                    SrgbFromLinear(montage.tree(row, column)[c]),
                    half_step);
      }
    }
  }
  EXPECT_EQ(picture("mergedimage.png").pixels.size(), cv::Size(300, 200));
  EXPECT_EQ(picture("Thumbnails/thumbnail.png").pixels.size(), cv::Size(256, 170));
  // A layer taken out of the archive is known as a result
  WriteTextWhole(folder / "layer.png", files["data/tree.png"]);
  EXPECT_TRUE(ReadPhotoFacts(folder / "layer.png").made_by_relight);
}

// Layers blended as GIMP 2.10 does in 8 bits (legacy modes), on the bytes of the file.
TEST(OpenRaster, ItsLayersMakeTheFlatPicture) {
  const ScratchFolder folder;
  const Montage montage = RandomMontage({97, 64}, 2);
  WriteOpenRaster(folder / "a.ora", montage, kProvenance);
  std::map<std::string, Photo> pictures;
  for (const auto& [name, content] : ReadStored(ReadText(folder / "a.ora"))) {
    if (!name.ends_with(".png")) continue;
    WriteTextWhole(folder / "layer.png", content);
    pictures[name] = ReadPhoto(folder / "layer.png");
  }
  const auto byte = [](float linear) {
    return static_cast<int>(255 * SrgbFromLinear(linear) + 0.5f);
  };
  const cv::Mat3f flat = FlatPicture(montage);
  const Photo& tree = pictures["data/tree.png"];
  int worst_flat = 0, worst_merged = 0;
  for (int row = 0; row < flat.rows; ++row) {
    for (int column = 0; column < flat.cols; ++column) {
      const int alpha = static_cast<int>(255 * tree.alpha(row, column) + 0.5f);
      for (int c = 0; c < 3; ++c) {
        const int b = byte(pictures["data/backdrop.png"].pixels(row, column)[c]);
        const int s = byte(pictures["data/shadow.png"].pixels(row, column)[c]);
        const int below = (b * s + 127) / 255;
        const int t = alpha == 0 ? 0 : byte(tree.pixels(row, column)[c]);
        const int blended = (alpha * t + (255 - alpha) * below + 127) / 255;
        worst_flat = std::max(worst_flat, std::abs(blended - byte(flat(row, column)[c])));
        worst_merged = std::max(
            worst_merged,
            std::abs(blended - byte(pictures["mergedimage.png"].pixels(row, column)[c])));
      }
    }
  }
  // Half a step each of two layers, of their product and of the blend
  EXPECT_LE(worst_flat, 2);
  EXPECT_LE(worst_merged, 2);
}

TEST(OpenRaster, HasTheSameBytesForTheSameMontage) {
  const ScratchFolder folder;
  Montage montage = RandomMontage({40, 30}, 3);
  montage.backdrop.release();
  WriteOpenRaster(folder / "a.ora", montage, kProvenance);
  ASSERT_EQ(setenv("TZ", "Pacific/Auckland", 1), 0);
  tzset();
  WriteOpenRaster(folder / "b.ora", montage, kProvenance);
  ASSERT_EQ(unsetenv("TZ"), 0);
  tzset();
  EXPECT_EQ(ReadText(folder / "a.ora"), ReadText(folder / "b.ora"));
  EXPECT_EQ(ReadStored(ReadText(folder / "a.ora")).size(), 6u);  // No backdrop
}

TEST(OpenRaster, CountsWhatEightBitsCannotHold) {
  const ScratchFolder folder;
  Montage montage{cv::Mat3f(2, 2, cv::Vec3f(0.5f, 0.5f, 0.5f)), cv::Mat1f(2, 2, 1.f)};
  montage.tree(0, 0)[1] = 1.5f;
  montage.tree(0, 1)[2] = -0.1f;
  montage.tree(1, 0)[0] = std::numeric_limits<float>::quiet_NaN();
  montage.tree(1, 1)[0] = 9.f;
  montage.alpha(1, 1) = 0.f;  // Not seen, not counted
  const WriteSummary summary = WriteOpenRaster(folder / "a.ora", montage, kProvenance);
  EXPECT_EQ(summary.clipped_pixels, 1);
  EXPECT_EQ(summary.negative_pixels, 1);
  EXPECT_EQ(summary.non_finite_pixels, 1);
}

TEST(OpenRaster, SaysWhichFileCannotBeWritten) {
  const ScratchFolder folder;
  const Montage montage = RandomMontage({4, 4}, 5);
  try {
    WriteOpenRaster(folder / "no_such_folder" / "a.ora", montage, kProvenance);
    FAIL() << "written into a folder that is not there";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no_such_folder"), std::string::npos);
  }
}

}  // namespace
}  // namespace relight
