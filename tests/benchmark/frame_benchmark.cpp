// SPDX-License-Identifier: Apache-2.0

// A frame of `relight day` at 1 and 8 megapixels: made and written as the program does,
// against encoding and writing it alone as a 16-bit PNG of zlib level 6. Read the ratio:
// below 2 a day costs little more than its files.

#include "relight/capture/relit_view.h"
#include "relight/photo/write_photo.h"

#include <OpenImageIO/imageio.h>
#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include <cmath>
#include <filesystem>
#include <future>
#include <map>

namespace relight {
namespace {
namespace fs = std::filesystem;

const Provenance kProvenance{"relight benchmark", "{}"};

fs::path WorkFolder() { return fs::temp_directory_path() / "relight_frame_benchmark"; }

// The sample's first view, enlarged, with a noise that a camera's photo has: an enlarged
// picture alone would be written faster than a photo.
struct Prepared {
  ViewPlan plan;
  PreparedView view;
};
const Prepared& ViewOf(int megapixels) {
  static std::map<int, Prepared> prepared;
  const auto found = prepared.find(megapixels);
  if (found != prepared.end()) return found->second;
  const fs::path capture = WorkFolder() / "maple";
  if (!fs::exists(capture)) {
    fs::create_directories(WorkFolder());
    fs::copy(
        fs::path(RELIGHT_SAMPLES_DIR) / "maple", capture, fs::copy_options::recursive);
  }
  ViewRequest request;
  request.source = capture;
  Prepared& made = prepared[megapixels];
  made.plan = PlanView(request, true, {"day", {}});
  made.view = PrepareView(made.plan);
  PreparedView& view = made.view;
  const double scale = std::sqrt(megapixels * 1e6 / (480.0 * 600.0));
  const cv::Size size(static_cast<int>(480 * scale), static_cast<int>(600 * scale));
  for (cv::Mat* image : {static_cast<cv::Mat*>(&view.photo.pixels),
                         static_cast<cv::Mat*>(&view.cut.foreground),
                         static_cast<cv::Mat*>(&view.cut.alpha)}) {
    cv::Mat large;
    cv::resize(*image, large, size, 0, 0, cv::INTER_LINEAR);
    *image = large;
  }
  cv::Mat noise(size, CV_32FC3);
  cv::RNG(1).fill(noise, cv::RNG::NORMAL, 1.0, 0.02);
  cv::multiply(view.photo.pixels, noise, view.photo.pixels);
  cv::multiply(view.cut.foreground, noise, view.cut.foreground);
  view.camera = view.camera.Resized(size.width, size.height);
  return made;
}

SolarPosition SunAtHour(int hour, const ViewPlan& plan) {
  return SolarPositionAt(plan.input.time->utc + std::chrono::hours(hour - 13),
                         *plan.place);
}

Photo MakeFrame(RelitView& relit, const SolarPosition& sun) {
  const RelitTree tree = relit.TreeUnder(sun);
  return {.pixels = relit.Whole(relit.GroundUnder(sun), tree)};
}

void MakeAndWrite(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  MakeFrame(relit, SunAtHour(9, prepared.plan));  // What is computed once
  // One is written while the next is made, as RunDay does
  int hour = 0;
  std::future<void> writing;
  for (auto _ : state) {
    Photo frame = MakeFrame(relit, SunAtHour(14 + hour++ % 4, prepared.plan));
    if (writing.valid()) writing.get();
    writing = std::async(std::launch::async, [frame = std::move(frame)] {
      WritePhoto(WorkFolder() / "frame.png", frame, kProvenance);
    });
  }
  writing.get();
}
BENCHMARK(MakeAndWrite)
    ->Arg(1)
    ->Arg(8)
    ->Iterations(8)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void Make(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  MakeFrame(relit, SunAtHour(9, prepared.plan));
  int hour = 0;
  for (auto _ : state) MakeFrame(relit, SunAtHour(14 + hour++ % 4, prepared.plan));
}
BENCHMARK(Make)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

// The parts of Make
void PartTree(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  const SolarPosition sun = SunAtHour(16, prepared.plan);
  relit.TreeUnder(sun);
  for (auto _ : state) relit.TreeUnder(sun);
}
BENCHMARK(PartTree)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

// PartTree less this is what the learned correction costs.
void PartTreeUncorrected(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  auto options = prepared.plan.options;
  options.correction.no_correction = true;
  RelitView relit(prepared.view, options, prepared.plan.input.sun);
  const SolarPosition sun = SunAtHour(16, prepared.plan);
  relit.TreeUnder(sun);
  for (auto _ : state) relit.TreeUnder(sun);
}
BENCHMARK(PartTreeUncorrected)
    ->Arg(1)
    ->Arg(8)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void PartGround(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  const SolarPosition sun = SunAtHour(16, prepared.plan);
  relit.GroundUnder(sun);
  for (auto _ : state) relit.GroundUnder(sun);
}
BENCHMARK(PartGround)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

void PartWrite(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  const Photo frame = MakeFrame(relit, SunAtHour(16, prepared.plan));
  for (auto _ : state) WritePhoto(WorkFolder() / "frame.png", frame, kProvenance);
}
BENCHMARK(PartWrite)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

void EncodeAndWriteLevel6(benchmark::State& state) {
  const Prepared& prepared = ViewOf(static_cast<int>(state.range(0)));
  RelitView relit(prepared.view, prepared.plan.options, prepared.plan.input.sun);
  const fs::path file = WorkFolder() / "frame.png";
  WritePhoto(file, MakeFrame(relit, SunAtHour(16, prepared.plan)), kProvenance);
  const auto input = OIIO::ImageInput::open(file.string());
  const OIIO::ImageSpec read = input->spec();
  std::vector<std::uint16_t> pixels(read.image_pixels() *
                                    static_cast<std::size_t>(read.nchannels));
  input->read_image(0, 0, 0, read.nchannels, OIIO::TypeDesc::UINT16, pixels.data());
  for (auto _ : state) {
    const auto output = OIIO::ImageOutput::create("png");
    OIIO::ImageSpec spec(read.width, read.height, 3, OIIO::TypeDesc::UINT16);
    spec.attribute("png:compressionLevel", 6);
    output->open((WorkFolder() / "level6.png").string(), spec);
    output->write_image(OIIO::TypeDesc::UINT16, pixels.data());
    output->close();
  }
}
BENCHMARK(EncodeAndWriteLevel6)
    ->Arg(1)
    ->Arg(8)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace relight
