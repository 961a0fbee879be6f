// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/photo_matte.h"

#include "matting/cluster_matting.h"
#include "matting/foreground_colors.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"

#include <utility>

namespace relight {
namespace fs = std::filesystem;
namespace {

// The colour prior is far surer where relight found the sky itself and leaves keep their
// hue. Trimaps do without, and without brighter leaves: their sure foreground holds them.
constexpr double kPriorBeforeSky = 12;

std::string SizeText(cv::Size size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

void RequireSize(const fs::path& file, const char* what, cv::Size has, cv::Size photo) {
  if (has == photo) return;
  throw InputError(file.string() + ": the " + what + " is " + SizeText(has) +
                   " pixels, the photo " + SizeText(photo) + "; make the " + what +
                   " at the photo's size");
}

// Errors of the matting library know no file.
template <class Body>
auto Naming(const fs::path& file, const Body& body) {
  try {
    return body();
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

void FindTrimap(const Photo& photo,
                const fs::path& file,
                const cv::Mat1b& strokes,
                const MatteOptions& options,
                const ColorModels* like,
                PhotoMatte& matte,
                const Progress& progress) {
  AutomaticTrimap found = Naming(file, [&] {
    return EstimateTrimap(
        DisplayFromLinear(photo.pixels), strokes, like, options.automatic, progress);
  });
  const TrimapCounts counts = CountLabels(found.trimap);
  if (counts.foreground == 0 || counts.background == 0) {
    std::string why;
    for (const std::string& doubt : found.doubts) why += doubt + "; ";
    throw InputError(file.string() + ": no tree against sky was found in it: " + why +
                     "give a matte or a trimap of it, or strokes (relight matte PHOTO "
                     "--scribbles FILE --automatic)");
  }
  matte.trimap = std::move(found.trimap);
  matte.confidence = found.confidence;
  matte.doubts = std::move(found.doubts);
}

}  // namespace

void RequireOneGuide(const MatteGuide& guide) {
  const int given = static_cast<int>(guide.trimap.has_value()) +
                    static_cast<int>(!guide.scribbles.empty()) +
                    static_cast<int>(guide.refine.has_value()) +
                    static_cast<int>(!guide.screen.empty());
  if (given > 1) {
    throw OptionError(
        "--trimap, --scribbles, --refine and --screen say the same thing in four ways; "
        "give one of them");
  }
  if (guide.automatic && given > 0 && guide.scribbles.empty()) {
    throw OptionError("--automatic goes with --scribbles, or with nothing");
  }
}

cv::Mat1b ReadStrokes(const std::vector<fs::path>& files, cv::Size size) {
  if (files.size() == 2) {
    const cv::Mat1f tree = ReadMatte(files[0]), not_tree = ReadMatte(files[1]);
    RequireSize(files[0], "mask", tree.size(), size);
    RequireSize(files[1], "mask", not_tree.size(), size);
    return Naming(files[0], [&] { return StrokesFromMasks(tree, not_tree); });
  }
  const Photo picture = ReadPhoto(files.at(0));
  RequireSize(files[0], "picture of scribbles", picture.pixels.size(), size);
  return Naming(files[0], [&] {
    return StrokesFromPicture(DisplayFromLinear(picture.pixels), picture.alpha);
  });
}

PhotoMatte EstimatePhotoMatte(const Photo& photo,
                              const fs::path& file,
                              const MatteGuide& guide,
                              const MatteOptions& options,
                              const ColorModels* like,
                              const Progress& progress) {
  RequireOneGuide(guide);
  if (photo.non_finite_pixels > 0) {
    throw InputError(file.string() + ": " + std::to_string(photo.non_finite_pixels) +
                     " of its pixels are no numbers (NaN) or infinite; mend them in the "
                     "program that wrote it");
  }
  const cv::Size size = photo.pixels.size();
  const Progress finding = progress.Part(0, 0.3);
  PhotoMatte matte;
  fs::path guided_by = file;
  if (guide.trimap) {
    guided_by = *guide.trimap;
    const cv::Mat1f gray = ReadMatte(guided_by);
    RequireSize(guided_by, "trimap", gray.size(), size);
    matte.trimap = TrimapFromGray(gray);
    matte.made_from = guided_by.string();
    const TrimapCounts counts = CountLabels(matte.trimap);
    if (counts.unknown == 0) {
      matte.doubts.emplace_back(
          std::string("the trimap has no unknown (grey) pixel") +
          (counts.foreground == 0   ? " and no foreground (white)"
           : counts.background == 0 ? " and no background (black)"
                                    : "") +
          ": it is the matte as it stands; a mask cut by hand goes to --refine");
    }
  } else if (guide.refine) {
    guided_by = *guide.refine;
    const cv::Mat1f mask = ReadMatte(guided_by);
    RequireSize(guided_by, "mask", mask.size(), size);
    matte.trimap = Naming(guided_by, [&] {
      return TrimapFromMask(DisplayFromLinear(photo.pixels), mask, options.mask, finding);
    });
    matte.made_from = guided_by.string() + ", its edge and its holes made anew";
  } else if (!guide.screen.empty()) {
    matte.screen = Naming(file, [&] { return FindScreen(photo.pixels, guide.screen); });
    matte.trimap = Naming(
        file, [&] { return TrimapFromScreen(photo.pixels, *matte.screen, finding); });
    matte.made_from =
        std::string("the ") + (matte.screen->channel == 2 ? "blue" : "green") + " screen";
    if (matte.screen->channel == 1) {
      matte.doubts.emplace_back(
          "a green screen takes the green out of leaves; a blue one does not");
    }
  } else if (!guide.scribbles.empty()) {
    guided_by = guide.scribbles.front();
    matte.trimap = ReadStrokes(guide.scribbles, size);
    matte.made_from = "scribbles";
    if (guide.automatic) {
      FindTrimap(photo, file, matte.trimap, options, like, matte, finding);
      matte.made_from = "scribbles and the sky behind the tree";
    }
  } else {
    FindTrimap(photo, file, {}, options, like, matte, finding);
    matte.made_from = "the sky behind the tree";
  }

  const Progress solving = progress.Part(0.3, 1);
  matte.alpha = Naming(guided_by, [&] {
    if (options.method == MatteMethod::kRuzon2000) {
      return EstimateClusterMatte(DisplayFromLinear(photo.pixels), matte.trimap, solving);
    }
    MattingOptions matting = options.closed_form;
    if (options.prior == MattePrior::kNone) matting.prior_weight = 0;
    matting.brightest = options.leaf_brightness;
    const bool found = !matte.screen && (guide.automatic || guided_by == file);
    if (matting.brightest == 0) {
      const bool before_sky =
          found && IsBeforeSky(DisplayFromLinear(photo.pixels), matte.trimap);
      matting.brightest = before_sky ? 4 : 1;
    }
    if (found && matting.brightest > 1) matting.prior_weight *= kPriorBeforeSky;
    return EstimateMatte(options.color == MatteColor::kDisplay
                             ? DisplayFromLinear(photo.pixels)
                             : photo.pixels,
                         matte.trimap,
                         matting,
                         solving)
        .alpha;
  });
  return matte;
}

cv::Mat3f ForegroundOf(const Photo& photo,
                       const cv::Mat1f& alpha,
                       const std::optional<Screen>& screen,
                       const Progress& progress) {
  if (!photo.alpha.empty()) return photo.pixels;
  cv::Mat3f foreground = EstimateForeground(photo.pixels, alpha, {}, progress).foreground;
  if (screen) RemoveSpill(foreground, *screen);
  return foreground;
}

}  // namespace relight
