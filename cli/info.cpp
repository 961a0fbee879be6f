// SPDX-License-Identifier: Apache-2.0
#include "cli/verbs.h"
#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/capture/capture.h"
#include "relight/capture/capture_times.h"
#include "relight/capture/tree_volume.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/photo_facts.h"
#include "relight/sky/light_in_words.h"
#include "relight/sky/solar_position.h"
#include "relight/volume/vdb_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

namespace relight::cli {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// "front light": from behind the camera; "side", "back": against the light.
const char* LightKind(double sun_from_heading_deg) {
  const double apart = std::abs(WrapDeg180(sun_from_heading_deg));
  return apart > 135 ? "front light" : apart > 45 ? "side light" : "back light";
}

json OfPhoto(const fs::path& file) {
  const PhotoFacts facts = ReadPhotoFacts(file);
  json j = {{"file", file.string()},
            {"kind", "photo"},
            {"width", facts.width},
            {"height", facts.height},
            {"made_by_relight", facts.made_by_relight}};
  std::vector<std::string> lacks, notes = facts.notes;
  try {
    const CaptureTime taken = ResolveCaptureTime(facts);
    j["taken"] = FormatLocal(taken.time);
    notes.insert(notes.end(), taken.notes.begin(), taken.notes.end());
  } catch (const InputError&) {
    lacks.push_back(facts.local_time ? "a time zone (--zone)"
                                     : "a capture time (--taken)");
  }
  if (facts.place) {
    j["place"] = {
        facts.place->latitude_deg, facts.place->longitude_deg, facts.place->altitude_m};
  } else {
    lacks.push_back("a place (--place)");
  }
  if (facts.heading_deg) {
    j["heading_deg"] = *facts.heading_deg;
    j["heading_is_magnetic"] = facts.heading_is_magnetic;
  } else {
    lacks.push_back("a heading (--heading)");
  }
  if (facts.focal_35mm_mm) j["focal_35mm_mm"] = *facts.focal_35mm_mm;
  if (facts.made_by_relight) {
    j["kind"] = "result of relight";
    const json made = json::parse(facts.provenance_json, nullptr, false);
    if (!made.is_discarded()) j["made"] = made;
    lacks.clear();
  }
  j["lacks"] = lacks;
  j["notes"] = notes;
  return j;
}

json OfVolume(const fs::path& file) {
  const ExtinctionGrid grid = ReadVolume(file);
  double sum = 0;
  ForEachVoxel(grid,
               [&](int, int, int, std::size_t index) { sum += grid.sigma_per_m[index]; });
  json noted = ReadMetadata(file);
  noted.erase("objective");  // A curve: relight volume --report draws it
  return {{"file", file.string()},
          {"mean_per_m", sum / static_cast<double>(grid.Count())},
          {"noted", noted},
          {"kind", "volume of extinction [1/m]"},
          {"cells", {grid.cells.x(), grid.cells.y(), grid.cells.z()}},
          {"cell_m", grid.cell_m},
          {"occupied_voxels", FindOccupied(grid).cell.size()},
          {"lower_corner_m", {grid.origin_m.x(), grid.origin_m.y(), grid.origin_m.z()}}};
}

json OfCapture(const fs::path& folder) {
  const Capture capture = OpenCapture(folder);
  json j = {{"file", folder.string()}, {"kind", "capture"}, {"views", json::array()}};
  std::vector<std::string> lacks;
  const bool posed = fs::exists(folder / "cameras" / "images.txt");
  std::map<std::string, Camera> cameras;
  if (posed) {
    cameras = CamerasOf(capture);
  } else {
    lacks.push_back("cameras: relight cameras " + folder.string());
  }
  int without_matte = 0;
  for (const ViewEntry& view : capture.file.views) {
    json v = {{"name", view.name}, {"photo", view.photo.string()}};
    if (!fs::exists(capture.PhotoOf(view))) {
      v["lacks"] = "its photo";
      j["views"].push_back(v);
      continue;
    }
    const PhotoFacts facts = ReadPhotoFacts(capture.PhotoOf(view));
    std::optional<double> heading_deg = facts.heading_deg;
    if (const auto found = cameras.find(view.name); found != cameras.end()) {
      heading_deg = DegFromRad(AzimuthOf(found->second.ForwardInWorld()));
      v["camera"] = true;
    }
    if (heading_deg) v["heading_deg"] = *heading_deg;
    const auto matte = FileOfView(capture, "mattes", view.name);
    const auto trimap = FileOfView(capture, "trimaps", view.name);
    v["matte"] = matte ? "matte" : trimap ? "trimap" : "none";
    without_matte += !matte && !trimap;
    try {
      const auto taken = view.taken         ? view.taken
                         : facts.local_time ? std::nullopt
                                            : capture.file.taken;
      const LocalTime time = ResolveCaptureTime(facts, capture.file.zone, taken).time;
      v["taken"] = FormatLocal(time);
      std::optional<Place> place = facts.place;
      if (capture.file.place) place = ParsePlace(*capture.file.place);
      if (place && heading_deg) {
        const SolarPosition sun = SolarPositionAt(time.utc, *place);
        const double apart_deg = DegFromRad(sun.azimuth_rad) - *heading_deg;
        v["light"] = LightKind(apart_deg);
        v["light_in_words"] = LightInWords(RadFromDeg(apart_deg), sun.elevation_rad);
      } else if (!place) {
        v["lacks"] = "a place: write place = \"LAT,LON\" into capture.toml";
      }
    } catch (const Error& error) {
      v["lacks"] = error.what();
    }
    j["views"].push_back(v);
  }
  if (without_matte > 0) {
    lacks.push_back(fmt::format("mattes or trimaps of {} photos, in {} or {}",
                                without_matte,
                                (folder / "mattes").string(),
                                (folder / "trimaps").string()));
  }
  if (fs::exists(folder / "volume.vdb")) j["volume"] = OfVolume(folder / "volume.vdb");
  if (const std::optional<LightCache> cache = LightCacheOf(capture)) {
    j["cache"] = {{"file", cache->file.string()},
                  {"megabytes", std::round(1e-5 * double(cache->bytes)) / 10},
                  {"made_by_relight", cache->is_ours}};
  }
  j["lacks"] = lacks;
  j["notes"] = DoubtsOfCapture(capture);
  return j;
}

std::string TextOf(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const json& part : value) text += (text.empty() ? "" : ", ") + TextOf(part);
  return text;
}

void Print(const json& j, const std::string& indent = "") {
  for (const auto& [key, value] : j.items()) {
    if (value.empty() && !value.is_number() && !value.is_boolean()) continue;
    if (key == "views" && value.is_array()) {
      fmt::print("views\n");
      for (const json& v : value) {
        fmt::print("  {:16} {}{}{}{}\n",
                   v.value("name", ""),
                   v.contains("heading_deg") ? fmt::format("heading {:5.1f} deg, ",
                                                           v["heading_deg"].get<double>())
                                             : std::string(),
                   v.contains("light") ? v["light"].get<std::string>() + ", " : "",
                   v.value("matte", "no photo"),
                   v.contains("lacks") ? ", lacks " + TextOf(v["lacks"]) : "");
      }
    } else if (value.is_object()) {
      fmt::print("{}{}\n", indent, key);
      Print(value, indent + "  ");
    } else {
      fmt::print("{}{:20} {}\n", indent, key, TextOf(value));
    }
  }
}

}  // namespace

Verb AddInfo(CLI::App& program, const ConsoleOptions&) {
  CLI::App* app =
      program.add_subcommand("info", "What a photo, volume or capture is and lacks");
  auto file = std::make_shared<fs::path>();
  auto as_json = std::make_shared<bool>(false);
  app->add_option("file", *file, "photo, volume.vdb or capture folder")
      ->required()
      ->type_name("FILE|DIR");
  app->add_flag("--json", *as_json, "print as JSON");
  return {app, [file, as_json] {
            if (!fs::exists(*file)) throw InputError(file->string() + ": not there");
            const json j = fs::is_directory(*file)       ? OfCapture(*file)
                           : file->extension() == ".vdb" ? OfVolume(*file)
                                                         : OfPhoto(*file);
            if (*as_json) {
              fmt::print("{}\n", j.dump(1));
            } else {
              Print(j);
            }
            return 0;
          }};
}

}  // namespace relight::cli
