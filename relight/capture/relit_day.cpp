// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/relit_day.h"

#include "relight/base/angles.h"
#include "relight/base/child_process.h"
#include "relight/base/content_hash.h"
#include "relight/base/error.h"
#include "relight/base/field_text.h"
#include "relight/base/parallel.h"
#include "relight/base/version.h"
#include "relight/base/write_file.h"
#include "relight/capture/relit_provenance.h"
#include "relight/capture/relit_view.h"
#include "relight/composite/contact_sheet.h"
#include "relight/composite/frame_page.h"
#include "relight/composite/frame_preview.h"
#include "relight/composite/frame_video.h"
#include "relight/composite/montage.h"
#include "relight/photo/color.h"
#include "relight/photo/read_photo.h"
#include "relight/sh/sky_coefficients.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <future>
#include <set>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRunFile = "relight_day.json";
constexpr int kPreview_px = 1920, kPage_px = 1280, kPageQuality = 85;
constexpr int kFramesPerSecond = 5;

fs::path FileOf(const DayPlan& plan, const DayFrame& frame) {
  return plan.folder / (frame.name + "." + plan.request.format);
}

// --- The folder ----------------------------------------------------------------------

std::string_view BytesOf(const cv::Mat& values) {
  Require(values.isContinuous(), "an image in one piece of memory");
  return {reinterpret_cast<const char*>(values.data), values.total() * values.elemSize()};
}

// Of the extinctions of the whole box, x fastest.
std::string HashOfVoxels(const ExtinctionGrid& grid) {
  ContentHash hash;
  std::vector<float> row(static_cast<std::size_t>(grid.cells.x()));
  for (int z = 0; z < grid.cells.z(); ++z) {
    for (int y = 0; y < grid.cells.y(); ++y) {
      std::fill(row.begin(), row.end(), 0.0f);
      for (int x = 0; x < grid.cells.x(); x += BrickVoxels::kEdge) {
        if (grid.BrickOf(x, y, z) < 0) continue;
        std::copy_n(&grid.sigma_per_m[grid.Index(x, y, z)],
                    std::min(BrickVoxels::kEdge, grid.cells.x() - x),
                    row.begin() + x);
      }
      hash.Add({reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float)});
    }
  }
  return hash.Text();
}

// All that a frame depends on besides its hour.
std::string RunHash(const DayPlan& plan,
                    const PreparedView& view,
                    const RunLight& light,
                    double exposure_ev) {
  std::string text = std::string(Version()) + "\n" + FieldsText(plan.view.options) + "\n";
  for (const DaylightOptions& sky : {light.input, light.target}) {
    text += SkyInWords(sky) + " " + FieldText(sky.turbidity) + "\n";
    if (sky.panorama) text += sky.panorama->hash + "\n";
  }
  const auto& sun = plan.view.input.sun;
  for (const double value : {sun.azimuth_rad, sun.elevation_rad, exposure_ev}) {
    text += FieldText(value) + "\n";
  }
  text += plan.request.format + (plan.request.alone ? " alone\n" : "\n");
  const std::string& occluder = plan.view.options.neighbours.occluder;
  if (!occluder.empty()) text += HashOfFile(occluder) + "\n";
  if (plan.request.over) text += HashOfFile(*plan.request.over) + "\n";
  const Camera& camera = view.camera;
  for (const auto& m : {camera.PositionInWorld(), camera.ForwardInWorld()}) {
    for (const double value : m) text += FieldText(value) + " ";
  }
  text += FieldText(camera.focal_px.x()) + " " + FieldText(camera.focal_px.y()) + "\n";
  for (const cv::Mat& image : {cv::Mat(view.photo.pixels),
                               cv::Mat(view.cut.foreground),
                               cv::Mat(view.cut.alpha)}) {
    text += HashOfText(BytesOf(image)) + "\n";
  }
  return HashOfText(text + HashOfVoxels(view.tree.grid));
}

// Makes the folder ours; throws InputError when it is somebody else's.
void TakeFolder(const DayPlan& plan, const std::string& run_hash) {
  const fs::path& folder = plan.folder;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError(folder.string() + ": this folder cannot be made: " +
                     error.message() + "; choose another with -o");
  }
  RemoveLeftovers(folder);
  const fs::path run_file = folder / kRunFile;
  const std::string remedy =
      "; choose another folder with -o, or --force to make this one anew";
  std::string found;
  if (fs::exists(run_file)) {
    const auto json = nlohmann::json::parse(
        ReadText(run_file, 1 << 20), nullptr, /*allow_exceptions*/ false);
    if (json.is_object() && json.contains("run") && json["run"].is_string())
      found = json["run"].get<std::string>();
  }
  if (found == run_hash && !plan.request.force) return;

  // What is there is neither lost nor mixed with ours
  std::set<std::string> ours;
  for (const DayFrame& frame : plan.frames) ours.insert(FileOf(plan, frame).filename());
  for (const char* name : {"sun.csv", "contact_sheet.png", "index.html", "day.mp4"}) {
    ours.insert(name);
  }
  if (!plan.request.force) {
    if (!found.empty()) {
      throw InputError(folder.string() +
                       ": holds the frames of another run (other photo, options or "
                       "version)" +
                       remedy);
    }
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (ours.contains(name) || name == kRunFile) {
        throw InputError(entry.path().string() +
                         ": is there already, and not from this run" + remedy);
      }
    }
  } else if (!found.empty()) {
    // Frames of the other run that this one does not make would be taken for its own
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      const bool frame = (name.size() == 19 || name.size() == 24) && name[4] == '-' &&
                         name[10] == '_' &&
                         (name.ends_with(".png") || name.ends_with(".exr"));
      if (frame || ours.contains(name)) fs::remove(entry.path(), error);
    }
  } else {
    for (const std::string& name : ours) fs::remove(folder / name, error);
  }
  WriteTextWhole(run_file,
                 nlohmann::json({{"made_by", std::string("relight ") + Version()},
                                 {"view", plan.view.name},
                                 {"run", run_hash}})
                         .dump(1) +
                     "\n");
}

// --- Frames --------------------------------------------------------------------------

// The tree over its shadow, on nothing: the shadow is black, as dense as it darkens a
// white ground in luminance. Editors blend encoded values, an EXR's are linear.
Photo TreeAndShadow(const RelitTree& tree,
                    const cv::Mat1f& alpha,
                    const cv::Mat3f& shadow,
                    bool linear) {
  Photo frame{.pixels = cv::Mat3f(alpha.size()), .alpha = cv::Mat1f(alpha.size())};
  ParallelRanges(alpha.rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < alpha.cols; ++column) {
        const cv::Vec3f& s = shadow(row, column);
        const float left =
            std::clamp(0.2126f * s[0] + 0.7152f * s[1] + 0.0722f * s[2], 0.f, 1.f);
        const float dark = 1 - (linear ? left : SrgbFromLinear(left));
        const float a = alpha(row, column);
        const float both = a + (1 - a) * dark;
        frame.alpha(row, column) = both;
        cv::Vec3f color(0, 0, 0);
        if (a > 0) {
          // Straight: the mean of tree and black, in the values that are blended
          for (int c = 0; c < 3; ++c) {
            const float t = tree.colors(row, column)[c];
            color[c] = linear
                           ? t * a / both
                           : LinearFromSrgb(SrgbFromLinear(std::max(t, 0.f)) * a / both);
          }
        }
        frame.pixels(row, column) = color;
      }
    }
  });
  return frame;
}

// One exposure for all: "auto" makes the tree of the brightest frame as bright as the
// photo's.
double ExposureOf(const DayPlan& plan, RelitView& relit, const Progress& progress) {
  const std::string& exposure = plan.request.exposure;
  if (exposure != "auto") return ExposureStops(exposure, 1.0);
  double brightest = 0;
  for (std::size_t i = 0; i < plan.frames.size(); ++i) {
    const auto count = static_cast<double>(plan.frames.size());
    const Progress part =
        progress.Part(static_cast<double>(i) / count, static_cast<double>(i + 1) / count);
    brightest =
        std::max(brightest, relit.TreeUnder(plan.frames[i].light.sun, part).mean_ratio);
  }
  return ExposureStops(exposure, brightest);
}

struct FrameMaker {
  const DayPlan& plan;
  const PreparedView& view;
  RelitView& relit;
  cv::Mat3f backdrop;
  double exposure_ev = 0.0;

  Photo At(const HourLight& hour, const Progress& progress) const {
    RelitTree tree = relit.TreeUnder(hour.sun, progress.Part(0, 0.4));
    const double gain = std::exp2(exposure_ev);
    if (!plan.request.alone && backdrop.empty()) {
      const cv::Mat3f ground = relit.GroundUnder(hour.sun, progress.Part(0.4, 1));
      Photo frame{.pixels = relit.Whole(ground, tree)};
      if (exposure_ev != 0) frame.pixels *= gain;
      return frame;
    }
    if (exposure_ev != 0) tree.colors *= gain;
    const cv::Mat3f shadow = relit.ShadowUnder(hour.sun, progress.Part(0.4, 1));
    if (plan.request.alone) {
      return TreeAndShadow(tree, view.cut.alpha, shadow, plan.request.format == "exr");
    }
    return {.pixels = FlatPicture({.tree = tree.colors,
                                   .alpha = view.cut.alpha,
                                   .shadow = shadow,
                                   .backdrop = backdrop})};
  }
};

// --- What shows them all --------------------------------------------------------------

std::string LabelOf(const DayFrame& frame) {
  const std::string text = FormatLocal(*frame.light.time);
  return text.substr(0, 10) + " " + text.substr(11, 5);
}

double SunFromHeading(const DayPlan& plan, const DayFrame& frame) {
  return frame.light.sun.azimuth_rad - RadFromDeg(plan.view.heading_deg);
}

std::string SunTable(const DayPlan& plan, const RelitView& relit) {
  std::string table =
      "frame,time,azimuth_deg,elevation_deg,sun_r_lx,sun_g_lx,sun_b_lx,sky_r_lx,sky_g_lx,"
      "sky_b_lx\n";
  for (const DayFrame& frame : plan.frames) {
    const Daylight daylight = relit.DaylightUnder(frame.light.sun);
    const Eigen::Array3d sun = daylight.sun_irradiance;
    const Eigen::Array3d sky = HorizontalSkyIrradiance(daylight);
    char line[256];
    std::snprintf(line,
                  sizeof line,
                  "%s,%s,%.4f,%.4f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n",
                  FileOf(plan, frame).filename().c_str(),
                  FormatLocal(*frame.light.time).c_str(),
                  DegFromRad(frame.light.sun.azimuth_rad),
                  DegFromRad(frame.light.sun.elevation_rad),
                  sun[0],
                  sun[1],
                  sun[2],
                  sky[0],
                  sky[1],
                  sky[2]);
    table += line;
  }
  return table;
}

// Contact sheet, page and video from the frames as they are on the disk, so that a run
// which went on gives what one that was never stopped gives.
void ShowAll(const DayPlan& plan, DayResult& result, const Progress& progress) {
  const Provenance provenance{std::string("relight ") + Version(),
                              nlohmann::json({{"view", plan.view.name}}).dump()};
  std::optional<ContactSheet> sheet;
  std::unique_ptr<FrameVideo> video;
  std::vector<PageFrame> page;
  const fs::path video_file = plan.folder / "day.mp4";
  const auto ffmpeg = FindProgram("ffmpeg");
  if (!ffmpeg) {
    result.notes.push_back(
        "no video: ffmpeg is not installed; install it and run the same command again");
  }
  for (std::size_t i = 0; i < plan.frames.size(); ++i) {
    const DayFrame& frame = plan.frames[i];
    const cv::Mat3b preview = PreviewOf(ReadPhoto(FileOf(plan, frame)), kPreview_px);
    if (!sheet) {
      sheet.emplace(static_cast<int>(plan.frames.size()), preview.size());
      if (ffmpeg) {
        video = std::make_unique<FrameVideo>(
            *ffmpeg, video_file, preview.size(), kFramesPerSecond);
      }
    }
    const double azimuth_rad = SunFromHeading(plan, frame);
    const double elevation_rad = frame.light.sun.elevation_rad;
    sheet->Add(preview, LabelOf(frame), azimuth_rad, elevation_rad);
    page.push_back(
        {.name = frame.name,
         .label = LabelOf(frame),
         .light = frame.light.words,
         .sun_from_heading_rad = azimuth_rad,
         .sun_elevation_rad = elevation_rad,
         .jpeg = JpegOf(Smaller(preview, {kPage_px, kPage_px}), kPageQuality)});
    if (video) video->Add(preview);
    progress.Report(static_cast<double>(i + 1) / static_cast<double>(plan.frames.size()));
  }
  WriteSheet(result.contact_sheet, sheet->picture(), provenance);
  WriteTextWhole(result.page, FramePage(plan.view.name, page));
  if (!video) return;
  const std::string said = video->Finish();
  if (said.empty()) {
    result.video = video_file;
  } else {
    result.notes.push_back("no video: " + ffmpeg->string() + ": " + said);
  }
}

}  // namespace

DayResult RunDay(const DayPlan& plan, const StageStart& start) {
  DayResult result;
  const PreparedView view = PrepareView(plan.view, start);
  result.notes = view.notes;
  const std::string photo = plan.view.PhotoFile().string();
  const bool on_photo = !plan.request.alone && !plan.request.over;
  if (on_photo && !view.photo.alpha.empty()) {
    throw InputError(photo +
                     ": has no background to keep (it has an alpha channel); give "
                     "--alone, or a backdrop with --over PHOTO");
  }
  if (!view.ground_fault.empty()) {
    if (!on_photo) throw InputError(photo + ": " + view.ground_fault);
    result.notes.push_back(view.ground_fault +
                           "; the photo's own ground is left as it is");
  } else if (on_photo) {
    result.notes.push_back(
        "the tree's shadow is moved on the ground around it, approximately: all below "
        "the horizon is taken as level ground");
  }
  double lowest_sun_rad = plan.view.input.sun.elevation_rad;
  for (const DayFrame& frame : plan.frames) {
    lowest_sun_rad = std::min(lowest_sun_rad, frame.light.sun.elevation_rad);
  }
  RelitView relit(view, plan.view.options, plan.view.input.sun, lowest_sun_rad);
  result.light = relit.light();
  const std::vector<std::string> of_panoramas =
      relit.NotesOfPanoramas(plan.frames.front().light.sun);
  result.notes.insert(result.notes.end(), of_panoramas.begin(), of_panoramas.end());
  if (result.light.target.panorama && plan.frames.size() > 1) {
    result.notes.push_back(
        result.light.target.panorama->file.string() +
        ": one moment's sky lights all frames; what is said of its sun is of the first");
  }
  result.notes.insert(
      result.notes.end(), result.light.notes.begin(), result.light.notes.end());
  FrameMaker maker{plan, view, relit, {}};
  if (plan.request.over) {
    maker.backdrop = ReadBackdrop(
        *plan.request.over, view.photo.pixels.size(), plan.view.options.photo);
  }
  const bool two_passes = plan.request.exposure == "auto";
  result.exposure_ev =
      ExposureOf(plan, relit, view.progress.Part(0, two_passes ? 0.3 : 0));
  maker.exposure_ev = result.exposure_ev;
  TakeFolder(plan, RunHash(plan, view, result.light, result.exposure_ev));

  // Each frame is written while the next one is made
  const Progress making = view.progress.Part(two_passes ? 0.3 : 0, 1);
  const InputHashes hashes = HashInputs(plan.view);
  std::future<void> writing;
  for (std::size_t i = 0; i < plan.frames.size(); ++i) {
    const auto count = static_cast<double>(plan.frames.size());
    const Progress part =
        making.Part(static_cast<double>(i) / count, static_cast<double>(i + 1) / count);
    const DayFrame& frame = plan.frames[i];
    const fs::path file = FileOf(plan, frame);
    result.frames.push_back(file);
    if (fs::exists(file)) {
      ++result.kept;
      part.Report(1);
      continue;
    }
    Photo picture = maker.At(frame.light, part);
    const Provenance provenance = ProvenanceOf(
        plan.view,
        hashes,
        frame.light,
        {.whole = on_photo,
         .over = plan.request.over ? plan.request.over->filename().string() : "",
         .exposure_ev = result.exposure_ev,
         .light = result.light});
    if (writing.valid()) writing.get();
    writing =
        std::async(std::launch::async, [picture = std::move(picture), file, provenance] {
          WritePhoto(file, picture, provenance);
        });
    ++result.made;
    part.Report(1);
  }
  if (writing.valid()) writing.get();
  if (relit.fit()) result.notes.push_back(FitInWords(*relit.fit()));

  // The table, and what shows all frames
  result.sun_table = plan.folder / "sun.csv";
  result.contact_sheet = plan.folder / "contact_sheet.png";
  result.page = plan.folder / "index.html";
  WriteTextWhole(result.sun_table, SunTable(plan, relit));
  Progress showing;
  for (const PlannedStage& stage : plan.view.stages) {
    if (start && stage.name == "page") showing = start(stage);
  }
  ShowAll(plan, result, showing);
  return result;
}

}  // namespace relight
