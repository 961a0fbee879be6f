// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/view_matte.h"

#include "matting/automatic_trimap.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/capture/capture_folder.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <string>

namespace relight {
namespace fs = std::filesystem;
namespace {

std::string StageOf(const ViewEntry& view) { return "matte " + view.name; }
fs::path MatteFile(const ViewEntry& view) {
  return fs::path("mattes") / (view.name + ".png");
}
fs::path ReportFile(const ViewEntry& view) {
  return fs::path("cache") / "mattes" / (view.name + ".json");
}
fs::path ForegroundFile(const ViewEntry& view) {
  return fs::path("cache") / "foreground" / (view.name + ".exr");
}

std::string ForegroundStageOf(const ViewEntry& view) { return "foreground " + view.name; }

std::string ForegroundKey(const Capture& capture,
                          const ViewEntry& view,
                          const fs::path& matte,
                          const ReadPhotoOptions& options) {
  return StageKey("foreground 2")
      .Add(FieldsText(options))
      .AddFile(capture.PhotoOf(view))
      .AddFile(matte)
      .Hash();
}

bool HasAlpha(const Photo& photo) { return !photo.alpha.empty(); }

}  // namespace

cv::Mat1f ReadMatteFor(const fs::path& file, cv::Size size, const fs::path& photo) {
  cv::Mat1f matte = ReadMatte(file);
  if (matte.size() != size) {
    const auto text = [](cv::Size s) {
      return std::to_string(s.width) + " x " + std::to_string(s.height);
    };
    throw InputError(file.string() + ": the matte is " + text(matte.size()) +
                     " pixels, the photo " + photo.string() + " " + text(size) +
                     "; make the matte at the photo's size");
  }
  return matte;
}

CaptureMattes::CaptureMattes(const Capture& capture,
                             StageRecords& records,
                             const CaptureOptions& options)
    : capture_(capture), records_(records), options_(options) {}

MatteGuide CaptureMattes::GuideOf(const ViewEntry& view) const {
  MatteGuide guide;
  guide.trimap = FileOfView(capture_, "trimaps", view.name);
  if (guide.trimap) return guide;
  guide.automatic = true;
  if (const auto strokes = FileOfView(capture_, "scribbles", view.name)) {
    guide.scribbles = {*strokes};
  }
  return guide;
}

// The view whose strokes teach this one's colours, when it has nothing of its own.
const ViewEntry* CaptureMattes::Teacher(const ViewEntry& view) const {
  const MatteGuide own = GuideOf(view);
  if (own.trimap || !own.scribbles.empty()) return nullptr;
  for (const ViewEntry& other : capture_.file.views) {
    if (!GuideOf(other).scribbles.empty()) return &other;
  }
  return nullptr;
}

std::string CaptureMattes::KeyOf(const ViewEntry& view) const {
  StageKey key("matte 5");
  key.Add(FieldsText(options_.photo)).Add(FieldsText(options_.matte));
  const auto add = [&](const ViewEntry& of) {
    key.AddFile(capture_.PhotoOf(of));
    const MatteGuide guide = GuideOf(of);
    if (guide.trimap) key.AddFile(*guide.trimap);
    for (const fs::path& strokes : guide.scribbles) key.AddFile(strokes);
  };
  add(view);
  if (const ViewEntry* teacher = Teacher(view)) add(*teacher);
  return key.Hash();
}

bool CaptureMattes::IsStale(const ViewEntry& view, bool force) const {
  const auto matte = FileOfView(capture_, "mattes", view.name);
  if (matte && !records_.IsOurs(fs::relative(*matte, capture_.folder))) {
    return false;  // The user's own, or edited
  }
  const MatteGuide guide = GuideOf(view);
  if (!guide.trimap && guide.scribbles.empty() && !matte &&
      HasAlpha(ReadPhoto(capture_.PhotoOf(view), options_.photo))) {
    return false;
  }
  if (force) return true;
  const auto state = records_.StateOf(StageOf(view), KeyOf(view));
  return state == StageRecords::State::kMissing || state == StageRecords::State::kStale;
}

const ColorModels* CaptureMattes::ModelsFor(const ViewEntry& view) {
  const ViewEntry* teacher = Teacher(view);
  if (teacher == nullptr) return nullptr;
  if (!models_) {
    const Photo photo = ReadPhoto(capture_.PhotoOf(*teacher), options_.photo);
    const cv::Mat1b strokes =
        ReadStrokes(GuideOf(*teacher).scribbles, photo.pixels.size());
    models_ =
        EstimateTrimap(
            DisplayFromLinear(photo.pixels), strokes, nullptr, options_.matte.automatic)
            .models;
  }
  return models_->Empty() ? nullptr : &*models_;
}

bool CaptureMattes::Make(const ViewEntry& view, bool force, const Progress& progress) {
  if (!IsStale(view, force)) return false;
  const Photo photo = ReadPhoto(capture_.PhotoOf(view), options_.photo);
  const PhotoMatte matte = EstimatePhotoMatte(photo,
                                              capture_.PhotoOf(view),
                                              GuideOf(view),
                                              options_.matte,
                                              ModelsFor(view),
                                              progress.Part(0, 0.8));
  MakeFolderOf(capture_.folder, "mattes");
  MakeFolderOf(capture_.folder, ReportFile(view).parent_path());
  MakeFolderOf(capture_.folder, ForegroundFile(view).parent_path());
  WriteMatte(capture_.folder / MatteFile(view), matte.alpha);

  // Colours of the matte as it is on the disk, so that making them later gives the same
  const cv::Mat1f alpha = ReadMatte(capture_.folder / MatteFile(view));
  WriteLinear(capture_.folder / ForegroundFile(view),
              {{"", ForegroundOf(photo, alpha, matte.screen, progress.Part(0.8, 1))}});
  std::string made_from = matte.made_from;
  if (const MatteGuide guide = GuideOf(view); guide.trimap) {
    made_from = fs::relative(*guide.trimap, capture_.folder).string();
  }
  const nlohmann::json report = {{"made_from", made_from},
                                 {"confidence", matte.confidence},
                                 {"doubts", matte.doubts}};
  WriteTextWhole(capture_.folder / ReportFile(view), report.dump(1) + "\n");
  records_.Remember(StageOf(view), KeyOf(view), {MatteFile(view)});
  records_.Remember(
      ForegroundStageOf(view),
      ForegroundKey(capture_, view, capture_.folder / MatteFile(view), options_.photo),
      {ForegroundFile(view)});
  return true;
}

MatteReport CaptureMattes::ReportOf(const ViewEntry& view) const {
  MatteReport report;
  report.view = view.name;
  const auto matte = FileOfView(capture_, "mattes", view.name);
  if (!matte) return report;
  report.file = fs::relative(*matte, capture_.folder).string();
  if (!records_.IsOurs(report.file)) return report;
  std::ifstream file(capture_.folder / ReportFile(view));
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object()) return report;
  try {
    report.made_from = json.value("made_from", "");
    report.confidence = json.value("confidence", 1.0);
    report.doubts = json.value("doubts", std::vector<std::string>());
  } catch (const nlohmann::json::exception&) {
    // Somebody's own file: the matte is there all the same
  }
  return report;
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
  cut.foreground = ForegroundOf(photo, cut.alpha, {}, progress);
  MakeFolderOf(capture.folder, ForegroundFile(view).parent_path());
  WriteLinear(cached, {{"", cut.foreground}});
  records.Remember(stage, key, {ForegroundFile(view)});
  return cut;
}

}  // namespace relight
