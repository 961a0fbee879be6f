// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/relit_provenance.h"

#include "relight/base/angles.h"
#include "relight/base/content_hash.h"
#include "relight/base/field_text.h"
#include "relight/base/version.h"

#include <nlohmann/json.hpp>

namespace relight {
namespace {

nlohmann::json LightJson(const HourLight& light) {
  nlohmann::json json = {{"sun_azimuth_deg", DegFromRad(light.sun.azimuth_rad)},
                         {"sun_elevation_deg", DegFromRad(light.sun.elevation_rad)},
                         {"words", light.words}};
  if (light.time) json["time"] = FormatLocal(*light.time);
  return json;
}

}  // namespace

InputHashes HashInputs(const ViewPlan& view) {
  InputHashes hashes{HashOfFile(view.PhotoFile()), {}};
  if (view.capture) hashes.volume = HashOfFile(view.capture->folder / "volume.vdb");
  return hashes;
}

Provenance ProvenanceOf(const ViewPlan& view,
                        const InputHashes& hashes,
                        const HourLight& target,
                        const PictureKind& kind) {
  const std::string software = std::string("relight ") + Version();
  nlohmann::json json = {{"program", software},
                         {"photo", view.PhotoFile().filename().string()},
                         {"photo_hash", hashes.photo},
                         {"view", view.name},
                         {"options", FieldsText(view.options)},
                         {"input", LightJson(view.input)},
                         {"target", LightJson(target)},
                         {"heading_deg", view.heading_deg},
                         {"whole", kind.whole},
                         {"keep_shadow", kind.keep_shadow},
                         {"over", kind.over},
                         {"exposure_ev", kind.exposure_ev},
                         {"input_sky", SkyInWords(kind.light.input)},
                         {"sky", SkyInWords(kind.light.target)}};
  for (const auto& [name, sky] : {std::pair("input_sky_hash", &kind.light.input),
                                  std::pair("sky_hash", &kind.light.target)}) {
    if (sky->panorama) json[name] = sky->panorama->hash;
  }
  if (!view.options.neighbours.occluder.empty()) {
    json["occluder_hash"] = HashOfFile(view.options.neighbours.occluder);
  }
  if (kind.light.target.turbidity) json["turbidity"] = *kind.light.target.turbidity;
  if (!hashes.volume.empty()) json["volume_hash"] = hashes.volume;
  if (view.place) {
    json["place"] = {
        view.place->latitude_deg, view.place->longitude_deg, view.place->altitude_m};
  }
  return {software, json.dump()};
}

}  // namespace relight
