// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light of one moment as one value: the sun and the sky, in one unit.
//
//   [Cabral11]   docs/bibliography.md#cabral11
//   [Preetham99] docs/bibliography.md#preetham99
//
//   [Kasten80]   docs/bibliography.md#kasten80
//
//   cabral2011   sky [Preetham99] at turbidity 4.2, negative R, G, B set to 0; sun of
//                [Cabral11, Eq. 10]
//   preetham     sky [Preetham99] of the given turbidity, clamped in XYZ; sun through the
//                same paper's transmittances, with the same turbidity
//   atmosphere   atmosphere.h; the only one with a twilight
//   cie          cie_sky.h, one of fifteen types, from overcast to clear
//   panorama     panorama.h, of a file
//
// A panorama whose middle is not known to be at an azimuth is turned until its sun stands
// at that of the hour. Its own sun shines from where it stands in the panorama, but from
// the hour's place when that is within 5 degrees and up: the almanac is surer than how
// level a panorama is. Its values are cd/m2 when the file says so, or by panorama_scale;
// else they are scaled so that sun and sky on level ground are as bright as preetham's
// clear day of the turbidity at the sun's height, or what is left of it with N = 1 of
// (K8) when no sun is in it. Below the horizon it is dark, as all the others.
//
// Clouds that cover the share N of the sky leave of the clear day's light on level ground
// G_0 = D_0 + S_0 (sky and sun)
//
//   G(N) = G_0 (1 - 0.75 N^3.4)                                        [Kasten80]
//   S(N) = S_0 (1 - 0.75 N^3.4) (1 - N^2),   D(N) = G(N) - S(N)                    (K8)
//
// where S follows from the paper's D / G = 0.3 + 0.7 N^2, taken relative to its own clear
// day. With `cloud`, the sky is (1 - N) of the clear one and CIE type 1, white as D65,
// for the rest of D(N). A `cie` sky has the D(N) and S(N) of preetham's day of the
// turbidity at the N of its type: 1 for types 1 to 5 (no sun), 0.75 for 6 to 10 (9: no
// sun), 0 for 11 to 15; its colour is white as D65 for N of its light and preetham's for
// the rest.
//
// All colours are linear Rec.709, photometric: lux for the sun, cd/m2 for the sky, so
// that sun + integral of the sky is in one unit. With `preetham` and `atmosphere` a
// channel may be negative (a deep orange sun, a deep blue sky): the conversion to wider
// primaries is linear, so it can still be made afterwards, from these values or from
// anything linear in them.

#include "relight/base/field.h"
#include "relight/sky/atmosphere.h"
#include "relight/sky/cie_sky.h"
#include "relight/sky/panorama.h"
#include "relight/sky/preetham_sky.h"
#include "relight/sky/solar_position.h"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace relight {

inline constexpr double kUsualTurbidity = 3.0;  // Where nothing better is known.

enum class SkyModel { kPreetham, kCabral2011, kAtmosphere, kCie, kPanorama };

struct DaylightOptions {
  SkyModel model = SkyModel::kPreetham;
  // Left out: 3; kCabral2011 has 4.2 only.
  std::optional<double> turbidity = {};
  bool sunset_correction = false;  // Of kCabral2011 only.
  int cie_type = kCieOvercast;     // Of kCie only.
  double cloud = 0.0;              // N of (K8); of kPreetham and kAtmosphere only.
  // Of kAtmosphere only. Left out: AtmosphereOptions'.
  std::optional<double> ground_albedo = {};
  // Of kPanorama only, and there needed.
  std::shared_ptr<const Panorama> panorama = {};
  std::optional<double> panorama_heading_deg = {};  // Left out: as the file says, or by
                                                    // its sun.
  std::optional<double> panorama_scale = {};  // [cd/m2] of a value of 1; left out: as the
                                              // file says, or a day's level.
};

template <class Visitor>
void Describe(DaylightOptions& o, Visitor&& field) {
  field(o.model, {"sky", "", "model of sun and sky"});
  field(o.turbidity,
        {"turbidity", "", "haze of the air: 2 clear, 6 hazy", Between(1.7, 10)});
  field(o.sunset_correction,
        {"sunset-correction", "", "a sun that fades faster when low (cabral2011)"});
  field(o.cie_type, {"cie-type", "", "of a CIE sky", Between(1, 15)});
  field(o.cloud, {"cloud", "", "share of the sky under clouds", Between(0, 1)});
  field(o.ground_albedo,
        {"ground-albedo", "", "light that the ground reflects", Between(0, 1)});
  field(
      o.panorama_heading_deg,
      {"panorama-heading", "deg", "azimuth of a panorama's middle", Between(-360, 360)});
  field(o.panorama_scale,
        {"panorama-scale", "cd/m2", "of a panorama's value of 1", Above(0)});
}

// The same radiance everywhere above the horizon, or everywhere at all.
struct UniformSky {
  Eigen::Array3d radiance = Eigen::Array3d::Zero();  // [cd/m2] per channel.
  bool full_sphere = false;
};

// The air of one moment.
struct AtmosphereSky {
  Atmosphere air;
  Eigen::Vector3d sun = Eigen::Vector3d::UnitZ();  // May be below the horizon.
};

// Clouds, or a whole sky that is known by its luminances.
struct StandardSky {
  CieSky shape;
  double zenith_cd_per_m2 = 0.0;
  double white = 1.0;                // Share of the light that is white as D65.
  std::optional<PreethamSky> color;  // Of the rest.
};

struct Daylight {
  // Unit vector to the sun, ENU, and its irradiance [lx] on a plane that faces it.
  Eigen::Vector3d sun_direction = Eigen::Vector3d::UnitZ();
  Eigen::Array3d sun_irradiance = Eigen::Array3d::Zero();
  std::variant<UniformSky, PreethamSky, AtmosphereSky, StandardSky, PanoramaSky> sky = {};
  double sky_share = 1.0;             // Of `sky`: 1 - N of (K8).
  std::optional<StandardSky> clouds;  // Before it.

  // [cd/m2] from a unit direction; 0 below the horizon (but for a UniformSky of a full
  // sphere). The horizon itself belongs to the sky.
  Eigen::Array3d SkyRadiance(const Eigen::Vector3d& direction_in_world) const;
};

// The elevation that the sun must be above [deg].
double LowestSunOf(SkyModel model);

// Throws InputError when the sun is at or below LowestSunOf(model), or the level of a
// panorama is wanted of a day whose sun is down, and OptionError for a turbidity outside
// 1.7 to 10, another than 4.2 with kCabral2011, and options that belong to another model.
Daylight MakeDaylight(const SolarPosition& sun, const DaylightOptions& options = {});

// What a panorama is taken for at an hour, for its user: how it is turned, where its sun
// stands beside the hour's, its level. Empty for the other models.
std::vector<std::string> PanoramaNotes(const SolarPosition& sun,
                                       const DaylightOptions& options);

// No sun, and the same radiance [cd/m2] from everywhere: for tests and white furnaces.
Daylight UniformDaylight(const Eigen::Array3d& radiance, bool full_sphere = false);

}  // namespace relight
