// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light of one moment as one value: the sun and the sky, in one unit.
//
//   [Cabral11]   docs/bibliography.md#cabral11
//   [Preetham99] docs/bibliography.md#preetham99
//
//   cabral2011   sky [Preetham99] at turbidity 4.2, negative R, G, B set to 0; sun of
//                [Cabral11, Eq. 10]
//   preetham     sky [Preetham99] of the given turbidity, clamped in XYZ; sun through the
//                same paper's transmittances, with the same turbidity
//
// All colours are linear Rec.709, photometric: lux for the sun, cd/m2 for the sky, so
// that sun + integral of the sky is in one unit. With `preetham` a channel may be
// negative (a deep orange sun, a deep blue sky): the conversion to wider primaries is
// linear, so it can still be made afterwards, from these values or from anything linear
// in them.

#include "relight/base/field.h"
#include "relight/sky/preetham_sky.h"
#include "relight/sky/solar_position.h"

#include <Eigen/Core>

#include <optional>
#include <variant>

namespace relight {

enum class SkyModel { kPreetham, kCabral2011 };

struct DaylightOptions {
  SkyModel model = SkyModel::kPreetham;
  // Left out: 3 for kPreetham; kCabral2011 has 4.2 only.
  std::optional<double> turbidity = {};
  bool sunset_correction = false;  // Of kCabral2011 only.
};

template <class Visitor>
void Describe(DaylightOptions& o, Visitor&& field) {
  field(o.model, {"sky", "", "model of sun and sky: preetham or cabral2011"});
  field(o.turbidity,
        {"turbidity", "", "haze of the air: 2 clear, 6 hazy", Between(1.7, 10)});
  field(o.sunset_correction,
        {"sunset-correction", "", "a sun that fades faster when low (cabral2011)"});
}

// The same radiance everywhere above the horizon, or everywhere at all.
struct UniformSky {
  Eigen::Array3d radiance = Eigen::Array3d::Zero();  // [cd/m2] per channel.
  bool full_sphere = false;
};

struct Daylight {
  // Unit vector to the sun, ENU, and its irradiance [lx] on a plane that faces it.
  Eigen::Vector3d sun_direction = Eigen::Vector3d::UnitZ();
  Eigen::Array3d sun_irradiance = Eigen::Array3d::Zero();
  std::variant<UniformSky, PreethamSky> sky = {};

  // [cd/m2] from a unit direction; 0 below the horizon (but for a UniformSky of a full
  // sphere). The horizon itself belongs to the sky.
  Eigen::Array3d SkyRadiance(const Eigen::Vector3d& direction_in_world) const;
};

// Throws InputError when the sun is at or below the horizon, and OptionError for a
// turbidity outside 1.7 to 10, another than 4.2 with kCabral2011, and a sunset correction
// without it.
Daylight MakeDaylight(const SolarPosition& sun, const DaylightOptions& options = {});

// No sun, and the same radiance [cd/m2] from everywhere: for tests and white furnaces.
Daylight UniformDaylight(const Eigen::Array3d& radiance, bool full_sphere = false);

}  // namespace relight
