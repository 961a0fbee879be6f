// SPDX-License-Identifier: Apache-2.0
#pragma once

// What relighting one view takes, whatever the hours: everything is looked up before any
// work, and what is missing is said in one message.

#include "relight/capture/capture.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/photo.h"
#include "relight/sky/solar_position.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// As on the command line; texts are read by the parsers of relight/photo/capture_time.h.
struct ViewRequest {
  std::filesystem::path source;  // Capture folder, or one photo.
  std::optional<std::string> view;
  std::optional<std::filesystem::path> photo;  // In place of the view's own.
  // Pixels in memory, of an editor's layer, in place of a file's: of the view's own
  // photo, or of `source`, which need not be a file then but names the picture.
  std::optional<Photo> picture;
  std::optional<std::string> place, zone, taken, heading;
  std::optional<std::string> lit_from;  // "AZ,EL" [deg] as the camera sees it.
  std::optional<std::filesystem::path> matte;
  std::optional<double> distance_m;            // One photo alone: camera to tree.
  bool force = false;                          // Make every stage again.
  std::map<std::string, std::string> options;  // CaptureOptions by name.
};

// The rest of what the user said, to be repeated in a command that can be run: "relight
// VERB SOURCE … WORDS".
struct CommandWords {
  std::string verb;
  std::vector<std::string> words;

  void Add(const std::string& flag) { words.push_back(flag); }
  template <class Value>
  void Add(const std::string& flag, const std::optional<Value>& value) {
    if (!value) return;
    words.push_back(flag);
    words.push_back(std::filesystem::path(*value).string());
  }
};

// A light of the run: where the sun is, how that is known, and in words.
struct HourLight {
  SolarPosition sun;
  std::optional<LocalTime> time;  // Unset when only a direction was given.
  std::string words;              // As the view's camera sees it.
};

struct PlannedStage {
  std::string name;  // "mattes", "volume", "light", and what the verb does last.
  std::string what;  // "mattes of 12 photos, against the sky".
  double expected_s = 0.0;
};

// Everything looked up; nothing made yet.
struct ViewPlan {
  ViewRequest request;  // Its `matte` is the one found, for a photo alone.
  CaptureOptions options;
  std::optional<Capture> capture;  // Unset: one photo alone.
  std::string name;
  std::filesystem::path photo;      // The view's own; request.photo may stand in for it.
  std::optional<MatteGuide> guide;  // One photo alone without a matte: one is made so.
  double megapixels = 0.0;
  std::optional<double> focal_35mm_mm;  // As the photo says.
  // One photo alone: the camera kept beside it (one_photo_camera.h), turned to the user's
  // heading; its world is ENU with the ground at z = 0.
  std::optional<Camera> camera_beside;
  std::optional<Place> place;
  std::optional<Zone> zone;  // For wanted times: the user's, else the photo's offset.
  double heading_deg = 0.0;  // Of the view's camera.
  HourLight input;
  std::vector<PlannedStage> stages;  // That are not up to date.
  std::vector<std::string> notes;    // What was assumed, one sentence each.

  // The pixels that are relit.
  const std::filesystem::path& PhotoFile() const {
    return request.photo ? *request.photo : photo;
  }
};

// `wants_time`: wanted hours are told by clocks, so that place and date are needed even
// when --lit-from tells the photo's light. Throws InputError with everything that is
// missing and one command that gives it; OptionError for texts that cannot be read.
ViewPlan PlanView(const ViewRequest& request,
                  bool wants_time,
                  const CommandWords& command);

// The picture that is relit: of memory or of PhotoFile(). Throws as ReadPhoto does.
Photo PixelsOf(const ViewPlan& plan);

// The sun at a direction, as no clock knows it.
SolarPosition SunAt(double azimuth_rad, double elevation_rad);

// "AZ,EL" in degrees as the camera sees it; `option` is for the message. Throws
// OptionError.
SolarPosition ParseLight(const std::string& text, const char* option, double heading_deg);

// Throws InputError when the sun of a clock's hour is not above `lowest_deg`, of 0 or
// less, where the model of the light ends: "the sun is 3
// deg below the horizon at the WHICH hour", when it is up, and the remedy.
void RequireSunUp(const HourLight& light,
                  const char* which,
                  const Place& place,
                  double lowest_deg,
                  const std::string& remedy);

// Throws InputError when the file is a result of relight.
void RequireOriginal(const PhotoFacts& facts);

// Files that the plan reads: none of them is ever written over.
std::vector<std::filesystem::path> InputsOf(const ViewPlan& plan);

// Throws InputError when `output` is one of `inputs`.
void RequireNoInput(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& inputs);

// Throws OptionError when the text is none of same, auto, EV.
void RequireExposure(const std::string& exposure);

}  // namespace relight
