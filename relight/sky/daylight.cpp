// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/daylight.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/cabral2011_sun.h"
#include "relight/sky/preetham_sun.h"

#include <iomanip>
#include <sstream>

namespace relight {
namespace {

constexpr double kCabral2011Turbidity = 4.2;
constexpr double kDefaultTurbidity = 3.0;

void CheckOptions(const DaylightOptions& options) {
  if (options.turbidity.has_value()) {
    CheckFields(PreethamSkyOptions{.turbidity = *options.turbidity});
  }
  const bool cabral2011 = options.model == SkyModel::kCabral2011;
  if (cabral2011 &&
      options.turbidity.value_or(kCabral2011Turbidity) != kCabral2011Turbidity) {
    std::ostringstream text;
    text << "turbidity must be 4.2 with the sky cabral2011, whose sun is made for that, "
            "got "
         << *options.turbidity << "; leave it out or take the sky preetham";
    throw OptionError(text.str());
  }
  if (!cabral2011 && options.sunset_correction) {
    throw OptionError(
        "sunset-correction belongs to the sky cabral2011, got preetham; leave it "
        "out or take the sky cabral2011");
  }
}

}  // namespace

Eigen::Array3d Daylight::SkyRadiance(const Eigen::Vector3d& direction) const {
  if (const auto* uniform = std::get_if<UniformSky>(&sky)) {
    const bool shines = uniform->full_sphere || direction.z() >= 0.0;
    return shines ? uniform->radiance : Eigen::Array3d::Zero();
  }
  return std::get<PreethamSky>(sky)(direction);
}

Daylight MakeDaylight(const SolarPosition& sun, const DaylightOptions& options) {
  CheckOptions(options);
  const Eigen::Vector3d direction = sun.direction.normalized();
  if (!(direction.z() > 0.0)) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(2) << "the sun is at "
         << DegFromRad(ElevationOf(direction))
         << " degrees, and the model of the daylight ends at the horizon; choose an hour "
            "between sunrise and sunset";
    throw InputError(text.str());
  }

  if (options.model == SkyModel::kCabral2011) {
    return {
        .sun_direction = direction,
        .sun_irradiance = Cabral2011SunIrradiance(
            direction, {.sunset_correction = options.sunset_correction}),
        .sky = PreethamSky(
            direction, {.turbidity = kCabral2011Turbidity, .clamp = SkyClamp::kRec709})};
  }
  const double turbidity = options.turbidity.value_or(kDefaultTurbidity);
  return {
      .sun_direction = direction,
      .sun_irradiance = PreethamSunIrradiance(direction, {.turbidity = turbidity}).rgb_lx,
      .sky = PreethamSky(direction, {.turbidity = turbidity})};
}

Daylight UniformDaylight(const Eigen::Array3d& radiance, bool full_sphere) {
  Daylight daylight;
  daylight.sky = UniformSky{.radiance = radiance, .full_sphere = full_sphere};
  return daylight;
}

}  // namespace relight
