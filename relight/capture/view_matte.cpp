// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/view_matte.h"

#include "matting/closed_form_matting.h"
#include "matting/foreground_colors.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/capture/capture_folder.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"

#include <string>

namespace relight {
namespace fs = std::filesystem;
namespace {

std::string StageOf(const ViewEntry& view) { return "matte " + view.name; }
fs::path MatteFile(const ViewEntry& view) {
  return fs::path("mattes") / (view.name + ".png");
}
fs::path ForegroundFile(const ViewEntry& view) {
  return fs::path("cache") / "foreground" / (view.name + ".exr");
}

std::string KeyFromTrimap(const Capture& capture,
                          const ViewEntry& view,
                          const fs::path& trimap,
                          const ReadPhotoOptions& options) {
  return StageKey("matte 2")
      .Add(FieldsText(options))
      .AddFile(capture.PhotoOf(view))
      .AddFile(trimap)
      .Hash();
}

std::string ForegroundStageOf(const ViewEntry& view) { return "foreground " + view.name; }

std::string ForegroundKey(const Capture& capture,
                          const ViewEntry& view,
                          const fs::path& matte,
                          const ReadPhotoOptions& options) {
  return StageKey("foreground 1")
      .Add(FieldsText(options))
      .AddFile(capture.PhotoOf(view))
      .AddFile(matte)
      .Hash();
}

std::string SizeText(cv::Size size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

bool HasAlpha(const Photo& photo) { return !photo.alpha.empty(); }

}  // namespace

cv::Mat3f ForegroundOf(const Photo& photo,
                       const cv::Mat1f& alpha,
                       const Progress& progress) {
  if (HasAlpha(photo)) return photo.pixels;
  return EstimateForeground(photo.pixels, alpha, {}, progress).foreground;
}

cv::Mat1f MatteFromTrimap(const Photo& photo,
                          const fs::path& trimap,
                          const Progress& progress) {
  const cv::Mat1f gray = ReadMatte(trimap);
  if (gray.size() != photo.pixels.size()) {
    throw InputError(trimap.string() + ": is " + SizeText(gray.size()) +
                     " pixels, the photo " + SizeText(photo.pixels.size()) +
                     "; make the trimap at the photo's size");
  }
  try {
    return EstimateMatte(photo.pixels, TrimapFromGray(gray), {}, progress).alpha;
  } catch (const InputError& error) {
    throw InputError(trimap.string() + ": " + error.what());
  }
}

cv::Mat1f ReadMatteFor(const fs::path& file, cv::Size size, const fs::path& photo) {
  cv::Mat1f matte = ReadMatte(file);
  if (matte.size() != size) {
    throw InputError(file.string() + ": the matte is " + SizeText(matte.size()) +
                     " pixels, the photo " + photo.string() + " " + SizeText(size) +
                     "; make the matte at the photo's size");
  }
  return matte;
}

MatteNeed NeedOf(const Capture& capture,
                 const ViewEntry& view,
                 const StageRecords& records,
                 const ReadPhotoOptions& options,
                 bool force) {
  const auto trimap = FileOfView(capture, "trimaps", view.name);
  const auto matte = FileOfView(capture, "mattes", view.name);
  if (matte && !records.IsOurs(fs::relative(*matte, capture.folder))) {
    return MatteNeed::kNone;  // The user's own, or edited
  }
  if (trimap) {
    if (force) return MatteNeed::kMatte;
    const auto state =
        records.StateOf(StageOf(view), KeyFromTrimap(capture, view, *trimap, options));
    return state == StageRecords::State::kMissing || state == StageRecords::State::kStale
               ? MatteNeed::kMatte
               : MatteNeed::kNone;
  }
  if (matte) return MatteNeed::kNone;
  return HasAlpha(ReadPhoto(capture.PhotoOf(view), options)) ? MatteNeed::kNone
                                                             : MatteNeed::kMissing;
}

bool MakeMatte(const Capture& capture,
               const ViewEntry& view,
               StageRecords& records,
               const ReadPhotoOptions& options,
               bool force,
               const Progress& progress) {
  if (NeedOf(capture, view, records, options, force) != MatteNeed::kMatte) return false;
  const auto trimap = FileOfView(capture, "trimaps", view.name);
  const Photo photo = ReadPhoto(capture.PhotoOf(view), options);
  const cv::Mat1f alpha = MatteFromTrimap(photo, *trimap, progress.Part(0, 0.7));
  MakeFolderOf(capture.folder, "mattes");
  MakeFolderOf(capture.folder, ForegroundFile(view).parent_path());
  WriteMatte(capture.folder / MatteFile(view), alpha);

  // Colours of the matte as it is on the disk, so that making them later gives the same
  const cv::Mat3f foreground = ForegroundOf(
      photo, ReadMatte(capture.folder / MatteFile(view)), progress.Part(0.7, 1));
  WriteLinear(capture.folder / ForegroundFile(view), {{"", foreground}});
  records.Remember(
      StageOf(view), KeyFromTrimap(capture, view, *trimap, options), {MatteFile(view)});
  records.Remember(
      ForegroundStageOf(view),
      ForegroundKey(capture, view, capture.folder / MatteFile(view), options),
      {ForegroundFile(view)});
  return true;
}

cv::Mat1f MatteOf(const Capture& capture, const ViewEntry& view) {
  if (const auto file = FileOfView(capture, "mattes", view.name)) return ReadMatte(*file);
  Photo photo = ReadPhoto(capture.PhotoOf(view));
  if (HasAlpha(photo)) return photo.alpha;
  throw InputError(capture.folder.string() + ": view " + view.name +
                   " has neither matte nor trimap; put one of the photo's size at " +
                   (capture.folder / "mattes" / (view.name + ".png")).string() + " or " +
                   (capture.folder / "trimaps" / (view.name + ".png")).string());
}

CutOut CutOutOf(const Capture& capture,
                const ViewEntry& view,
                const Photo& photo,
                StageRecords& records,
                const ReadPhotoOptions& options,
                const Progress& progress) {
  const auto matte = FileOfView(capture, "mattes", view.name);
  if (!matte) {
    if (HasAlpha(photo)) return {photo.pixels, photo.alpha, "the photo's alpha"};
    return {{}, MatteOf(capture, view), ""};  // Says what is missing
  }
  CutOut cut{{},
             ReadMatteFor(*matte, photo.pixels.size(), capture.PhotoOf(view)),
             fs::relative(*matte, capture.folder).string()};

  const fs::path cached = capture.folder / ForegroundFile(view);
  const std::string stage = ForegroundStageOf(view);
  const std::string key = ForegroundKey(capture, view, *matte, options);
  if (records.StateOf(stage, key) == StageRecords::State::kUpToDate) {
    cut.foreground = ReadLinear(cached);
    return cut;
  }
  cut.foreground = ForegroundOf(photo, cut.alpha, progress);
  MakeFolderOf(capture.folder, ForegroundFile(view).parent_path());
  WriteLinear(cached, {{"", cut.foreground}});
  records.Remember(stage, key, {ForegroundFile(view)});
  return cut;
}

}  // namespace relight
