// SPDX-License-Identifier: Apache-2.0
#include "plugin_gimp/relighting.h"

#include "relight/base/error.h"
#include "relight/photo/photo_facts.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace relight::gimp {
namespace fs = std::filesystem;
namespace {

std::optional<std::string> Said(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(text);
}

// The image's file tells of the layer when the layer is the picture in it.
bool IsPictureOf(const fs::path& file, cv::Size size) {
  if (file.empty() || !fs::is_regular_file(file)) return false;
  try {
    const PhotoFacts facts = ReadPhotoFacts(file);
    return facts.width == size.width && facts.height == size.height;
  } catch (const InputError&) {
    return false;  // A format of GIMP's own: there is nothing to learn from it
  }
}

// Editors show what is transparent over checks.
cv::Mat3f Checks(cv::Size size) {
  cv::Mat3f checks(size);
  checks.forEach([](cv::Vec3f& color, const int* at) {
    color = cv::Vec3f::all((at[0] / 8 + at[1] / 8) % 2 == 0 ? 0.45f : 0.33f);
  });
  return checks;
}

}  // namespace

Relighting::Relighting(LayerPicture layer) : layer_(std::move(layer)) {
  if (!layer_.file.empty()) found_ = CaptureOfPhoto(layer_.file);
  if (!found_ && !layer_.file.empty())
    found_ = CaptureOfPhoto(layer_.file.parent_path() / layer_.name);
}

Settings Relighting::Completed(Settings settings) const {
  // A cut-out of another size is no photo of the capture that the image lies in
  if (settings.capture.empty() && found_ &&
      (layer_.pixels.alpha.empty() ||
       IsPictureOf(layer_.file, layer_.pixels.pixels.size()))) {
    settings.capture = found_->folder.string();
    if (settings.view.empty()) settings.view = found_->view;
  }
  if (!settings.capture.empty() && settings.view.empty())
    settings.view = fs::path(layer_.name).stem().string();
  if (settings.exposure.empty()) settings.exposure = "same";
  return settings;
}

std::optional<LocalTime> Relighting::TimeOfPhoto() const {
  return plan_ ? plan_->input.time : std::nullopt;
}

void Relighting::Plan(const Settings& settings) {
  const Settings s = Completed(settings);
  std::string texts = s.to.empty() ? "" : "wants time\n";
  for (const TextField& field : kTextFields) {
    if (field.of_photo) texts += s.*field.text + "\n";
  }
  if (!plan_ || texts != planned_for_) {
    plan_.reset();
    relit_.reset();
    small_relit_.reset();
    view_.reset();
    small_view_.reset();
    if (s.capture.empty() && layer_.pixels.alpha.empty()) {
      throw InputError(
          "The layer \xe2\x80\x9c" + layer_.name +
          "\xe2\x80\x9d has no transparency, and no capture is known that it "
          "is a photo of; cut the tree out on a layer with an alpha channel, "
          "or choose the capture's folder");
    }
    ViewRequest request;
    request.source = s.capture.empty() ? fs::path(layer_.name) : fs::path(s.capture);
    if (s.capture.empty() && IsPictureOf(layer_.file, layer_.pixels.pixels.size()))
      request.source = layer_.file;
    if (!s.capture.empty()) {
      static_cast<void>(OpenCapture(request.source));  // Says what is no capture
      request.view = s.view;
    }
    request.picture = layer_.pixels;
    request.place = Said(s.place);
    request.zone = Said(s.zone);
    request.taken = Said(s.taken);
    request.heading = Said(s.heading);
    request.lit_from = Said(s.lit_from);
    plan_ = PlanView(request, !s.to.empty(), {"hour", {}});
    planned_for_ = texts;
  }
  RequireExposure(s.exposure);
  HourRequest wanted;
  wanted.to = Said(s.to);
  wanted.to_light = Said(s.to_light);
  if (!s.like.empty()) wanted.like = s.like;
  notes_ = plan_->notes;
  target_ = PlanTarget(wanted, *plan_, notes_);
}

std::string Relighting::Check(const Settings& settings) {
  Plan(settings);
  std::string text = "Photo: " + plan_->input.words + ". Wanted: " + target_.words + ".";
  for (const std::string& note : notes_) text += " " + note + ".";
  return text;
}

void Relighting::Prepare(const Progress& progress) {
  if (view_) return;
  double expected_s = 0.5, begun_s = 0;
  for (const PlannedStage& stage : plan_->stages) expected_s += stage.expected_s;
  const PreparedView view = PrepareView(*plan_, [&](const PlannedStage& stage) {
    const double from = begun_s;
    begun_s += stage.expected_s;
    return progress.Part(from / expected_s, begun_s / expected_s);
  });
  view_ = view;
}

RelitLayers Relighting::LayersOf(RelitView& relit,
                                 const Settings& s,
                                 const Progress& progress) {
  RelitTree tree = relit.TreeUnder(target_.sun, progress.Part(0, s.shadow ? 0.5 : 1));
  const double stops = ExposureStops(s.exposure, tree.mean_ratio);
  if (stops != 0) tree.colors *= std::exp2(stops);
  RelitLayers result;
  result.layers.tree = tree.colors;
  if (s.shadow)
    result.layers.shadow = relit.ShadowUnder(target_.sun, progress.Part(0.5, 1));
  result.when = target_.words;
  if (target_.time) {
    const std::string time = FormatLocal(*target_.time);
    const bool same_day =
        plan_->input.time &&
        FormatLocal(*plan_->input.time).substr(0, 10) == time.substr(0, 10);
    result.when = (same_day ? "" : time.substr(0, 10) + " ") + time.substr(11, 5);
  }
  return result;
}

RelitLayers Relighting::Relight(const Settings& settings, const Progress& progress) {
  const Settings s = Completed(settings);
  Plan(s);
  Prepare(progress.Part(0, 0.6));
  if (!relit_)
    relit_ = std::make_unique<RelitView>(*view_, plan_->options, plan_->input.sun);
  RelitLayers result = LayersOf(*relit_, s, progress.Part(0.6, 1));
  result.layers.alpha = view_->cut.alpha;
  result.notes = notes_;
  result.notes.insert(result.notes.end(), view_->notes.begin(), view_->notes.end());
  return result;
}

cv::Mat3f Relighting::Preview(const Settings& settings,
                              int longest_px,
                              const Progress& progress) {
  const Settings s = Completed(settings);
  Plan(s);
  Prepare(progress.Part(0, 0.9));
  if (!small_relit_) {
    small_view_ = Smaller(*view_, longest_px);
    small_relit_ =
        std::make_unique<RelitView>(*small_view_, plan_->options, plan_->input.sun);
  }
  Montage montage = LayersOf(*small_relit_, s, progress.Part(0.9, 1)).layers;
  montage.alpha = small_view_->cut.alpha;
  montage.backdrop = Checks(montage.alpha.size());
  return FlatDisplay(montage);
}

}  // namespace relight::gimp
