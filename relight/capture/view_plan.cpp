// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/view_plan.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/base/field_text.h"
#include "relight/capture/capture_times.h"
#include "relight/capture/one_photo_camera.h"
#include "relight/capture/photo_heading.h"
#include "relight/capture/tree_volume.h"
#include "relight/capture/view_matte.h"
#include "relight/photo/color.h"
#include "relight/photo/photo_facts.h"
#include "relight/photo/read_photo.h"
#include "relight/sky/light_in_words.h"
#include "relight/sky/sun_times.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

// --- What is missing, all at once ----------------------------------------------------

struct Missing {
  std::vector<std::string> what;      // "no place in EXIF"
  std::vector<std::string> examples;  // "--place 48.85,2.35"

  void Add(const std::string& text, const std::string& example) {
    what.push_back(text);
    examples.push_back(example);
  }
};

// A word of a command as a shell reads it.
std::string ShellWord(const std::string& word) {
  const bool plain =
      !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
        return std::isalnum(c) ||
               std::string_view("-_./+,:=@").find(static_cast<char>(c)) !=
                   std::string_view::npos;
      });
  if (plain) return word;
  std::string quoted = "'";
  for (const char c : word)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

void ThrowIfMissing(const Missing& missing,
                    const ViewRequest& r,
                    const CommandWords& command) {
  if (missing.what.empty()) return;
  std::string text = r.source.string() + ": cannot be relit yet";
  for (std::size_t i = 0; i < missing.what.size(); ++i) {
    text += "\n  " + missing.what[i] + "; give " + missing.examples[i];
  }

  // The user's own words, and examples for those that are missing
  CommandWords said{command.verb, {}};
  said.Add("--view", r.view);
  said.Add("--photo", r.photo);
  said.Add("--place", r.place);
  said.Add("--zone", r.zone);
  said.Add("--taken", r.taken);
  said.Add("--heading", r.heading);
  said.Add("--lit-from", r.lit_from);
  said.Add("--matte", r.matte);
  if (r.distance_m) said.Add("--distance", std::optional(FieldText(*r.distance_m)));
  if (r.force) said.Add("--force");
  for (const auto& [name, value] : r.options) {
    said.Add("--" + name);
    if (value != "true") said.words.push_back(value);
  }
  text +=
      "\nwith your own values: relight " + said.verb + " " + ShellWord(r.source.string());
  for (const std::string& word : said.words) text += " " + ShellWord(word);
  for (const std::string& example : missing.examples) {
    if (example.starts_with("--")) text += " " + example;
  }
  for (const std::string& word : command.words) text += " " + ShellWord(word);
  throw InputError(text);
}

double Megapixels(const PhotoFacts& facts) { return 1e-6 * facts.width * facts.height; }

// Seconds on two cores of a desktop of 2020, rounded up: what a user is told before work.
constexpr double kMatteSecondsPerMegapixel = 3.0;
constexpr double kVolumeSecondsPerMegaray = 1.5;  // Of all views, 8 iterations.
constexpr double kLightSeconds = 4.0;

[[noreturn]] void ThrowPhotoIsGone(const Capture& capture, const ViewEntry& view) {
  throw InputError(capture.PhotoOf(view).string() + ": the photo of view " + view.name +
                   " is not there; put it back, or take the view out of " +
                   (capture.folder / "capture.toml").string() + " and the cameras");
}

// Said before the work, not after it.
void RequireSizeOf(const PhotoFacts& photo, const fs::path& file, const char* what) {
  const PhotoFacts facts = ReadPhotoFacts(file);
  if (facts.width == photo.width && facts.height == photo.height) return;
  const auto size = [](const PhotoFacts& f) {
    return std::to_string(f.width) + " x " + std::to_string(f.height);
  };
  throw InputError(file.string() + ": the " + what + " is " + size(facts) +
                   " pixels, the photo " + photo.file + " " + size(photo) +
                   "; make the " + what + " at the photo's size");
}

void PlanStages(ViewPlan& plan) {
  if (!plan.capture) {
    if (plan.guide) {
      plan.stages.push_back({"mattes",
                             plan.guide->trimap ? "a matte of the photo"
                                                : "a matte of the photo, against the sky",
                             1 + kMatteSecondsPerMegapixel * plan.megapixels});
    }
    plan.stages.push_back(
        {"volume", "a volume from the silhouette of this photo alone", 1});
    plan.stages.push_back(
        {"light", "transmittance of the volume to the sky", kLightSeconds});
    return;
  }
  const Capture& capture = *plan.capture;
  StageRecords records(capture.folder);
  const CaptureMattes mattes(capture, records, plan.options);
  const bool force = plan.request.force;
  int to_make = 0, posed = 0;
  double matte_mpx = 0;
  int against_sky = 0;
  bool matte_of_volume = false;
  const auto of_volume = VolumeCamerasOf(capture, plan.options);
  for (const auto& [name, camera] : CamerasToMatte(capture, plan.options, {plan.name})) {
    if (of_volume.contains(name)) ++posed;
    const ViewEntry& view = FindView(capture, name);
    if (!fs::exists(capture.PhotoOf(view))) ThrowPhotoIsGone(capture, view);
    if (!mattes.IsStale(view, force)) continue;
    const MatteGuide guide = mattes.GuideOf(view);
    const PhotoFacts facts = ReadPhotoFacts(capture.PhotoOf(view));
    if (guide.trimap) RequireSizeOf(facts, *guide.trimap, "trimap");
    for (const fs::path& strokes : guide.scribbles) {
      RequireSizeOf(facts, strokes, "picture of scribbles");
    }
    if (guide.automatic) ++against_sky;
    ++to_make;
    matte_of_volume |= of_volume.contains(name);
    matte_mpx += 1e-6 * camera.width_px * camera.height_px;
  }
  if (const std::string note = SelectionNote(capture, plan.options); !note.empty())
    plan.notes.push_back(note);
  if (to_make > 0) {
    std::string what = "mattes of " + std::to_string(to_make) + " photos";
    if (against_sky > 0) {
      what += against_sky == to_make
                  ? ", against the sky"
                  : ", " + std::to_string(against_sky) + " of them against the sky";
    }
    plan.stages.push_back({"mattes", what, 1 + kMatteSecondsPerMegapixel * matte_mpx});
  }
  const bool edited = VolumeIsEdited(capture, records);
  const bool volume = (matte_of_volume && !edited) ||
                      VolumeIsStale(capture, records, plan.options, force);
  if (volume) {
    const double rays_per_view =
        std::pow(1e-3 * std::max(600, 6 * plan.options.volume.cells), 2) * 0.8;
    plan.stages.push_back({"volume",
                           "extinction from " + std::to_string(posed) + " mattes",
                           1 + kVolumeSecondsPerMegaray * posed * rays_per_view});
  } else if (edited) {
    plan.notes.push_back((capture.folder / "volume.vdb").string() +
                         " is not as relight made it; used as it is (--force makes it "
                         "again)");
  }
  if (volume || LightIsStale(capture, records, plan.options, force)) {
    plan.stages.push_back(
        {"light", "transmittance of the volume to the sky", kLightSeconds});
  }
}

// The camera kept beside the photo, about its own upright.
void TurnTo(double heading_deg, ViewPlan& plan) {
  Camera& camera = *plan.camera_beside;
  const double turn_rad = RadFromDeg(heading_deg) - AzimuthOf(camera.ForwardInWorld());
  // Azimuths run clockwise
  camera.camera_from_world =
      camera.camera_from_world * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ());
  plan.notes.push_back("--heading turns the camera of " +
                       CameraFolderOf(plan.photo).string());
}

}  // namespace

Photo PixelsOf(const ViewPlan& plan) {
  if (!plan.request.picture) return ReadPhoto(plan.PhotoFile(), plan.options.photo);
  Photo picture = *plan.request.picture;
  if (plan.options.photo.tone == Tone::kCamera) {
    picture.pixels = picture.pixels.clone();
    picture.pixels.forEach([](cv::Vec3f& color, const int*) {
      for (int c = 0; c < 3; ++c) {
        color[c] = LinearFromSrgb(
            static_cast<float>(DisplayFromCamera(SrgbFromLinear(color[c]))));
      }
    });
  }
  return picture;
}

SolarPosition SunAt(double azimuth_rad, double elevation_rad) {
  return {std::fmod(azimuth_rad + 4 * std::numbers::pi, 2 * std::numbers::pi),
          elevation_rad,
          DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)};
}

SolarPosition ParseLight(const std::string& text,
                         const char* option,
                         double heading_deg) {
  double azimuth_deg = 0, elevation_deg = 0;
  const std::size_t comma = text.find(',');
  const auto number = [](std::string_view part, double& value) {
    const auto [end, error] =
        std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size();
  };
  if (comma == std::string::npos ||
      !number(std::string_view(text).substr(0, comma), azimuth_deg) ||
      !number(std::string_view(text).substr(comma + 1), elevation_deg) ||
      !(std::abs(azimuth_deg) <= 360) || !(elevation_deg > 0 && elevation_deg <= 90)) {
    throw OptionError(
        std::string(option) +
        " must be AZ,EL in degrees, the sun as the camera sees it: AZ 0 straight "
        "ahead, 90 from the right, 180 from behind; EL above 0 to 90; got \"" +
        text + "\"");
  }
  return SunAt(RadFromDeg(heading_deg + azimuth_deg), RadFromDeg(elevation_deg));
}

void RequireSunUp(const HourLight& light,
                  const char* which,
                  const Place& place,
                  double lowest_deg,
                  const std::string& remedy) {
  if (DegFromRad(light.sun.elevation_rad) > lowest_deg || !light.time) return;
  std::ostringstream text;
  text.precision(3);
  text << "the sun is " << -DegFromRad(light.sun.elevation_rad)
       << " deg below the horizon at the " << which << " hour "
       << FormatLocal(*light.time);
  const auto local_day = std::chrono::floor<std::chrono::days>(WallClockOf(*light.time));
  const SunTimes times = SunTimesOf(
      std::chrono::year_month_day(std::chrono::sys_days(local_day.time_since_epoch())),
      place);
  const auto clock = [&](Instant at) {
    return FormatLocal({at, light.time->offset}).substr(11, 5);
  };
  if (times.sunrise && times.sunset) {
    text << "; it is up from " << clock(*times.sunrise) << " to " << clock(*times.sunset)
         << " there";
  } else {
    text << "; it does not rise or set there that day";
  }
  if (lowest_deg < 0) {
    text << ", and twilight is known down to " << -lowest_deg << " deg below";
  }
  text << "; " << remedy;
  throw InputError(text.str());
}

void RequireOriginal(const PhotoFacts& facts) {
  if (!facts.made_by_relight) return;
  std::string original;
  const auto json = nlohmann::json::parse(facts.provenance_json, nullptr, false);
  if (json.is_object() && json.contains("photo") && json["photo"].is_string()) {
    original = " (" + json["photo"].get<std::string>() + ")";
  }
  throw InputError(facts.file +
                   ": is a result of relight, and a result is not relit again; relight "
                   "the photo it was made from" +
                   original);
}

std::vector<fs::path> InputsOf(const ViewPlan& plan) {
  std::vector<fs::path> inputs = {plan.photo};
  for (const auto& given : {plan.request.photo, plan.request.matte}) {
    if (given) inputs.push_back(*given);
  }
  if (!plan.capture) return inputs;
  for (const ViewEntry& view : plan.capture->file.views) {
    inputs.push_back(plan.capture->PhotoOf(view));
    for (const char* folder : {"mattes", "trimaps", "scribbles"}) {
      if (const auto file = FileOfView(*plan.capture, folder, view.name))
        inputs.push_back(*file);
    }
  }
  inputs.push_back(plan.capture->folder / "capture.toml");
  inputs.push_back(plan.capture->folder / "volume.vdb");
  return inputs;
}

void RequireNoInput(const fs::path& output, const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs) {
    std::error_code ignored;
    if (fs::equivalent(output, input, ignored) ||
        fs::weakly_canonical(output, ignored) == fs::weakly_canonical(input, ignored)) {
      throw InputError(output.string() +
                       ": is an input; an input is never overwritten; give "
                       "another name with -o");
    }
  }
}

void RequireExposure(const std::string& exposure) {
  double ev = 0;
  const auto [end, error] =
      std::from_chars(exposure.data() + (exposure.starts_with('+') ? 1 : 0),
                      exposure.data() + exposure.size(),
                      ev);
  const bool number = error == std::errc() && end == exposure.data() + exposure.size() &&
                      std::abs(ev) <= 20;
  if (exposure != "same" && exposure != "auto" && !number) {
    throw OptionError(
        "--exposure must be same, auto or a number of stops (-20 to 20), got \"" +
        exposure + "\"");
  }
}

ViewPlan PlanView(const ViewRequest& request,
                  bool wants_time,
                  const CommandWords& command) {
  ViewPlan plan;
  plan.request = request;
  Missing missing;

  // The photo, alone or of a capture
  const bool in_memory = request.picture.has_value();
  if (!in_memory && !fs::exists(request.source)) {
    throw InputError(request.source.string() +
                     ": not there; give a photo or a capture folder");
  }
  CaptureFile of_capture;
  const ViewEntry* entry = nullptr;
  if (fs::is_directory(request.source)) {
    plan.capture = OpenCapture(request.source);
    of_capture = plan.capture->file;
    if (of_capture.views.empty()) {
      throw InputError((request.source / "capture.toml").string() +
                       ": no [[view]] in it; add photos with: relight init " +
                       request.source.string() + " PHOTO…");
    }
    if (!request.view && of_capture.views.size() > 1) {
      plan.notes.push_back("no --view given; the first is taken: " +
                           of_capture.views[0].name);
    }
    entry = &FindView(*plan.capture, request.view.value_or(of_capture.views[0].name));
    plan.name = entry->name;
    plan.photo = plan.capture->PhotoOf(*entry);
    if (!fs::exists(plan.photo)) ThrowPhotoIsGone(*plan.capture, *entry);
  } else {
    if (request.view)
      throw OptionError("--view belongs to a capture folder, not to one photo");
    if (request.photo)
      throw OptionError("--photo belongs to a capture folder; name the photo itself");
    plan.photo = request.source;
    plan.name = plan.photo.stem().string();
  }
  plan.options = OptionsFrom(of_capture, request.options);
  // Says now what does not go together
  static_cast<void>(
      LightOfRun(plan.options.light, RadFromDeg(45), plan.options.transport.bounce));
  static_cast<void>(TransportOf(plan.options.light.method, plan.options.transport));
  static_cast<void>(OccluderOf(plan.options));
  PhotoFacts facts;
  facts.file = plan.photo.string();
  if (!in_memory || fs::is_regular_file(plan.photo)) facts = ReadPhotoFacts(plan.photo);
  RequireOriginal(facts);
  if (in_memory) {
    facts.width = request.picture->pixels.cols;
    facts.height = request.picture->pixels.rows;
  }
  if (request.photo) RequireOriginal(ReadPhotoFacts(*request.photo));
  plan.notes.insert(plan.notes.end(), facts.notes.begin(), facts.notes.end());
  plan.megapixels = Megapixels(facts);
  plan.focal_35mm_mm = facts.focal_35mm_mm;

  // Where, as far as the user or the photo says it
  if (request.place || of_capture.place) {
    facts.place = ParsePlace(request.place ? *request.place : *of_capture.place);
  }
  plan.place = facts.place;

  // When: the user's word, the view's in capture.toml, EXIF, the capture's
  std::optional<CaptureTime> when;
  const auto zone_text = request.zone ? request.zone : of_capture.zone;
  plan.request.zone = zone_text;
  std::optional<std::string> taken = request.taken;
  if (!taken && entry != nullptr) taken = entry->taken;
  if (!taken && !facts.local_time && !facts.gps_time) taken = of_capture.taken;
  const bool needs_input_time = !request.lit_from;
  if (needs_input_time || wants_time) {
    try {
      when = ResolveCaptureTime(facts, zone_text, taken);
      plan.notes.insert(plan.notes.end(), when->notes.begin(), when->notes.end());
      plan.input.time = when->time;
      plan.zone = when->zone;
    } catch (const OptionError& error) {
      if (request.taken || !taken || !plan.capture) throw;
      if (request.zone) static_cast<void>(ParseZone(*request.zone));  // The user's own
      throw InputError((plan.capture->folder / "capture.toml").string() + ": " +
                       error.what());
    } catch (const InputError&) {
      const bool timeless = !facts.local_time && !taken;
      if (timeless) missing.Add("no capture time in EXIF", "--taken 2011-07-22T13:00");
      if (!zone_text) {
        if (!timeless) ResolveCaptureTime(facts, "UTC", taken);  // What no zone mends
        missing.Add(timeless ? "no time zone" : "the time has no zone",
                    "--zone Europe/Paris");
      }
      if (missing.what.empty()) throw;
    }
  }

  if (!plan.place && when) plan.place = when->approximate_place;  // Its notes say so
  const bool needs_place = needs_input_time || wants_time;
  if (needs_place && !plan.place) missing.Add("no place in EXIF", "--place 48.85,2.35");

  // Which way the camera looks
  const bool has_cameras =
      plan.capture && fs::exists(plan.capture->folder / "cameras" / "images.txt");
  const bool is_alone =
      !has_cameras && (!plan.capture || plan.capture->file.views.size() == 1);
  if (is_alone && !in_memory)
    plan.camera_beside = CameraBeside(plan.photo, facts.width, facts.height);
  std::optional<Instant> utc;
  if (plan.input.time) utc = plan.input.time->utc;
  bool one_photo = !has_cameras;
  if (has_cameras) {
    const auto cameras = CamerasOf(*plan.capture);
    one_photo = cameras.size() == 1;
    const auto found = cameras.find(plan.name);
    if (found == cameras.end()) {
      throw InputError(plan.photo.string() +
                       ": a photo without camera; import the cameras again "
                       "with one of this name, or choose another --view");
    }
    const double heading_rad = AzimuthOf(found->second.ForwardInWorld());
    plan.heading_deg = DegFromRad(heading_rad);
    for (const std::string& doubt :
         DoubtsOfCapture(*plan.capture, request.zone, heading_rad)) {
      const bool said =
          std::find(plan.notes.begin(), plan.notes.end(), doubt) != plan.notes.end();
      if (!said) plan.notes.push_back(doubt);
    }
  } else if (plan.capture && plan.capture->file.views.size() > 1) {
    static_cast<void>(CamerasOf(*plan.capture));  // Says how to import them
  } else if (request.heading) {
    plan.heading_deg = ParseHeading(*request.heading);
    if (plan.camera_beside) TurnTo(plan.heading_deg, plan);
  } else if (plan.camera_beside) {
    plan.heading_deg = DegFromRad(AzimuthOf(plan.camera_beside->ForwardInWorld()));
  } else if (of_capture.heading_deg) {
    plan.heading_deg = *of_capture.heading_deg;
  } else if (const auto heading = HeadingFromExif(facts, plan.place, utc)) {
    plan.heading_deg = heading->heading_deg;
    if (!heading->note.empty()) plan.notes.push_back(heading->note);
    plan.notes.push_back(
        "north is by the photo's compass: on rendered trees 5 deg off cost up to 0.5 dB, "
        "10 deg up to 1.3; --heading tells better");
  } else if (needs_input_time || wants_time) {
    missing.Add("no heading in EXIF (which way the camera looked)", "--heading SW");
  }

  // Mattes, and what has to be made
  if (plan.capture && one_photo) {
    // A capture of one view, or of one camera, is one photo alone; its matte is looked
    // for in the folder
    if (!plan.request.matte) {
      if (const auto matte = FileOfView(*plan.capture, "mattes", plan.name)) {
        plan.request.matte = *matte;
      } else if (FileOfView(*plan.capture, "trimaps", plan.name) ||
                 FileOfView(*plan.capture, "scribbles", plan.name)) {
        StageRecords records(plan.capture->folder);
        plan.guide = CaptureMattes(*plan.capture, records, plan.options).GuideOf(*entry);
      }
    }
    plan.capture.reset();
  }
  if (!plan.capture && !plan.request.matte) {
    if (PixelsOf(plan).alpha.empty() && !plan.guide) plan.guide = MatteGuide();
  }
  const PhotoFacts of_relit = request.photo ? ReadPhotoFacts(*request.photo) : facts;
  if (plan.request.matte) {
    RequireSizeOf(of_relit, *plan.request.matte, "matte");
  } else if (plan.capture) {
    const auto matte = FileOfView(*plan.capture, "mattes", plan.name);
    if (matte && !request.photo && !in_memory) RequireSizeOf(of_relit, *matte, "matte");
  }
  PlanStages(plan);
  ThrowIfMissing(missing, request, command);

  // The photo's own light
  plan.input.sun = request.lit_from
                       ? ParseLight(*request.lit_from, "--lit-from", plan.heading_deg)
                       : SolarPositionAt(plan.input.time->utc, *plan.place);
  RequireSunUp(
      plan.input,
      "photo's",
      plan.place.value_or(Place{}),
      LowestInputSun(plan.options.light),
      "relight needs a photo taken in daylight; if it was, give its own --taken, "
      "--zone and --place");
  plan.input.words =
      LightInWords(plan.input.sun.azimuth_rad - RadFromDeg(plan.heading_deg),
                   plan.input.sun.elevation_rad);
  return plan;
}

}  // namespace relight
