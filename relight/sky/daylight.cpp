// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/daylight.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/cabral2011_sun.h"
#include "relight/sky/preetham_sun.h"

#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace relight {
namespace {

constexpr double kCabral2011Turbidity = 4.2;

const char* NameOf(SkyModel model) {
  switch (model) {
    case SkyModel::kPreetham:
      return "preetham";
    case SkyModel::kCabral2011:
      return "cabral2011";
    case SkyModel::kAtmosphere:
      return "atmosphere";
    case SkyModel::kCie:
      return "cie";
    case SkyModel::kPanorama:
      return "panorama";
  }
  return "";
}

void CheckOptions(const DaylightOptions& options) {
  CheckFields(options);
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
        std::string("sunset-correction belongs to the sky cabral2011, got ") +
        NameOf(options.model) + "; leave it out or take the sky cabral2011");
  }
  if (options.cloud > 0 && options.model != SkyModel::kPreetham &&
      options.model != SkyModel::kAtmosphere) {
    throw OptionError(
        std::string("cloud belongs to the skies preetham and atmosphere, got ") +
        NameOf(options.model) + "; leave it out or take one of these");
  }
  if (options.ground_albedo && options.model != SkyModel::kAtmosphere) {
    throw OptionError(std::string("ground-albedo belongs to the sky atmosphere, got ") +
                      NameOf(options.model) +
                      "; leave it out or take the sky atmosphere");
  }
  const bool panorama = options.model == SkyModel::kPanorama;
  Require(panorama == (options.panorama != nullptr), "a panorama where it is the sky");
  if (!panorama && (options.panorama_heading_deg || options.panorama_scale)) {
    throw OptionError(std::string("panorama-heading and panorama-scale belong to the sky "
                                  "panorama:FILE, got ") +
                      NameOf(options.model) + "; leave them out or take such a sky");
  }
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Illuminance on level ground of the luminance of each direction; the midpoints of 48 x
// 96 equal steps in the squared sine of the elevation and in azimuth, which weighs them
// all alike.
template <class Function>
double OnGround(const Function& luminance) {
  constexpr int kHeights = 48, kAzimuths = 96;
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    const double sine = std::sqrt((i + 0.5) / kHeights);
    for (int j = 0; j < kAzimuths; ++j) {
      sum += luminance(DirectionFromAzimuthElevation(
          (j + 0.5) * 2 * std::numbers::pi / kAzimuths, std::asin(sine)));
    }
  }
  return sum * std::numbers::pi / (kHeights * kAzimuths);
}

// What clouds leave of sun and sky.                                             (K8)
struct UnderClouds {
  double sun = 1.0;     // Of the clear day's sun.
  double sky_lx = 0.0;  // D(N).
};
UnderClouds Under(double cloud, double clear_sky_lx, double clear_sun_lx) {
  const double global = 1 - 0.75 * std::pow(cloud, 3.4);
  const double sun = global * (1 - cloud * cloud);
  return {sun, global * (clear_sky_lx + clear_sun_lx) - sun * clear_sun_lx};
}

StandardSky Standard(const Eigen::Vector3d& sun, int type, double ground_lx) {
  const CieSky shape(sun, type);
  return {.shape = shape, .zenith_cd_per_m2 = ground_lx / OnGround(shape), .color = {}};
}

double CloudOfType(int type) { return type <= 5 ? 1.0 : type <= 10 ? 0.75 : 0.0; }

Eigen::Array3d RadianceOf(const StandardSky& sky, const Eigen::Vector3d& direction) {
  const double luminance = sky.zenith_cd_per_m2 * sky.shape(direction);
  Eigen::Array3d color = Eigen::Array3d::Constant(sky.white);
  if (sky.color && luminance > 0) {
    const Eigen::Array3d clear = (*sky.color)(direction);
    color += (1 - sky.white) * clear / Luminance(clear);
  }
  return luminance * color;
}

// Sun and sky without clouds.
Daylight ClearDaylight(const Eigen::Vector3d& sun, const DaylightOptions& options) {
  Daylight day;
  day.sun_direction = sun;
  const double turbidity = options.turbidity.value_or(kUsualTurbidity);
  if (options.model == SkyModel::kAtmosphere) {
    AtmosphereOptions of_air{.turbidity = turbidity};
    if (options.ground_albedo) of_air.ground_albedo = *options.ground_albedo;
    const Atmosphere air(of_air);
    day.sun_direction = SeenPartOfSun(sun);
    day.sun_irradiance = air.SunIrradiance(sun);
    day.sky = AtmosphereSky{air, sun};
  } else {
    day.sun_irradiance = PreethamSunIrradiance(sun, {.turbidity = turbidity}).rgb_lx;
    day.sky = PreethamSky(sun, {.turbidity = turbidity});
  }
  return day;
}

// How a panorama stands over the place: its azimuths, and the sun's direction.
struct PlacedPanorama {
  double heading_rad = 0;
  bool heading_is_known = false;  // By the user or the file; else turned to the sun.
  double sun_apart_rad = 0;       // Of the panorama's sun from the hour's.
  Eigen::Vector3d own_sun;        // The panorama's; the hour's where it has none.
  Eigen::Vector3d sun;            // The one to light with.
};

constexpr double kSameSun_rad = RadFromDeg(5), kSunIsUp_rad = RadFromDeg(0.5);

PlacedPanorama PlacePanorama(const Eigen::Vector3d& sun, const DaylightOptions& options) {
  const Panorama& panorama = *options.panorama;
  PlacedPanorama placed;
  placed.own_sun = placed.sun = sun;
  placed.heading_is_known =
      options.panorama_heading_deg.has_value() || panorama.heading_rad.has_value();
  if (options.panorama_heading_deg) {
    placed.heading_rad = RadFromDeg(*options.panorama_heading_deg);
  } else if (panorama.heading_rad) {
    placed.heading_rad = *panorama.heading_rad;
  } else if (panorama.sun) {
    placed.heading_rad = AzimuthOf(sun) - AzimuthOf(panorama.sun->direction);
  }
  if (!panorama.sun) return placed;
  const Eigen::Vector3d& found = panorama.sun->direction;
  placed.own_sun = DirectionFromAzimuthElevation(AzimuthOf(found) + placed.heading_rad,
                                                 ElevationOf(found));
  placed.sun_apart_rad = AngleBetween(placed.own_sun, sun);
  const bool hour =
      placed.sun_apart_rad <= kSameSun_rad && ElevationOf(sun) > kSunIsUp_rad;
  placed.sun = hour ? sun : placed.own_sun;
  return placed;
}

// [cd/m2] of a value of 1, and the daylight in it.
Daylight PanoramaDaylight(const Eigen::Vector3d& sun, const DaylightOptions& options) {
  const Panorama& panorama = *options.panorama;
  const PlacedPanorama placed = PlacePanorama(sun, options);
  Daylight day;
  day.sun_direction = placed.sun;
  double cd_per_m2 = options.panorama_scale.value_or(1.0);
  if (!options.panorama_scale && !panorama.absolute) {
    // The level of the clear day, or of the covered one
    const std::string remedy =
        ", and the level of " + panorama.file.string() +
        " is not known; give the luminance of its value of 1 as --panorama-scale";
    if (!(ElevationOf(placed.sun) > 0)) {
      throw InputError("the sun is below the horizon" + remedy);
    }
    const Daylight clear = ClearDaylight(placed.sun, {.turbidity = options.turbidity});
    const double clear_lx = Luminance(clear.sun_irradiance) * placed.sun.z() +
                            OnGround([&](const Eigen::Vector3d& at) {
                              return Luminance(clear.SkyRadiance(at));
                            });
    double own = Luminance(panorama.Integral(
        [](const Eigen::Vector3d& direction) { return direction.z(); }));
    if (panorama.sun) own += Luminance(panorama.sun->irradiance) * placed.sun.z();
    if (!(own > 0)) {
      throw InputError(panorama.file.string() +
                       ": is black above the horizon; give a panorama with a sky");
    }
    cd_per_m2 = (panorama.sun ? 1.0 : 0.25) * clear_lx / own;
  }
  if (panorama.sun) day.sun_irradiance = cd_per_m2 * panorama.sun->irradiance;
  day.sky = PanoramaSky{options.panorama, placed.heading_rad, cd_per_m2};
  return day;
}

}  // namespace

Eigen::Array3d Daylight::SkyRadiance(const Eigen::Vector3d& direction) const {
  Eigen::Array3d radiance = Eigen::Array3d::Zero();
  if (const auto* uniform = std::get_if<UniformSky>(&sky)) {
    const bool shines = uniform->full_sphere || direction.z() >= 0.0;
    if (shines) radiance = uniform->radiance;
  } else if (const auto* preetham = std::get_if<PreethamSky>(&sky)) {
    radiance = (*preetham)(direction);
  } else if (const auto* atmosphere = std::get_if<AtmosphereSky>(&sky)) {
    radiance = atmosphere->air.SkyRadiance(atmosphere->sun, direction);
  } else if (const auto* panorama = std::get_if<PanoramaSky>(&sky)) {
    radiance = (*panorama)(direction);
  } else {
    radiance = RadianceOf(std::get<StandardSky>(sky), direction);
  }
  if (!clouds) return radiance;
  return sky_share * radiance + RadianceOf(*clouds, direction);
}

double LowestSunOf(SkyModel model) {
  if (model == SkyModel::kPanorama) return -91.0;  // It has a light of its own
  return model == SkyModel::kAtmosphere ? kLowestTwilight_deg : 0.0;
}

Daylight MakeDaylight(const SolarPosition& sun, const DaylightOptions& options) {
  CheckOptions(options);
  const Eigen::Vector3d direction = sun.direction.normalized();
  const double elevation_deg = DegFromRad(ElevationOf(direction));
  if (!(elevation_deg > LowestSunOf(options.model))) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(2) << "the sun is at " << elevation_deg
         << " degrees, and the model of the daylight ends at ";
    if (options.model == SkyModel::kAtmosphere) {
      text << kLowestTwilight_deg << "; choose an hour of day or twilight";
    } else {
      text << "the horizon; choose an hour between sunrise and sunset, or the sky "
              "atmosphere, which goes on to "
           << kLowestTwilight_deg;
    }
    throw InputError(text.str());
  }

  if (options.model == SkyModel::kCabral2011) {
    Daylight day;
    day.sun_direction = direction;
    day.sun_irradiance = Cabral2011SunIrradiance(
        direction, {.sunset_correction = options.sunset_correction});
    day.sky = PreethamSky(
        direction, {.turbidity = kCabral2011Turbidity, .clamp = SkyClamp::kRec709});
    return day;
  }

  if (options.model == SkyModel::kPanorama) return PanoramaDaylight(direction, options);

  Daylight day = ClearDaylight(direction, options);
  const bool cie = options.model == SkyModel::kCie;
  const double cloud = cie ? CloudOfType(options.cie_type) : options.cloud;
  if (!cie && cloud == 0) return day;
  const double sun_lx =
      Luminance(day.sun_irradiance) * std::max(0.0, day.sun_direction.z());
  const double sky_lx =
      OnGround([&](const Eigen::Vector3d& at) { return Luminance(day.SkyRadiance(at)); });
  const UnderClouds left = Under(cloud, sky_lx, sun_lx);
  day.sun_irradiance *= left.sun;
  if (cie) {
    StandardSky standard = Standard(direction, options.cie_type, left.sky_lx);
    standard.white = cloud;
    if (cloud < 1) standard.color = std::get<PreethamSky>(day.sky);
    if (options.cie_type == 9) day.sun_irradiance.setZero();  // The sun is hidden
    day.sky = standard;
  } else {
    day.sky_share = 1 - cloud;
    day.clouds = Standard(direction, kCieOvercast, left.sky_lx - day.sky_share * sky_lx);
  }
  return day;
}

std::vector<std::string> PanoramaNotes(const SolarPosition& sun,
                                       const DaylightOptions& options) {
  if (options.model != SkyModel::kPanorama) return {};
  const Panorama& panorama = *options.panorama;
  const std::string name = panorama.file.string();
  const PlacedPanorama placed = PlacePanorama(sun.direction.normalized(), options);
  std::vector<std::string> notes;
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (!panorama.sun) {
    text << name << ": no sun is in it: the light is its sky's alone"
         << (placed.heading_is_known
                 ? ""
                 : "; its middle is taken as north (--panorama-heading)");
    notes.push_back(text.str());
  } else {
    const auto at = [&](const Eigen::Vector3d& direction) {
      std::ostringstream place;
      place << std::fixed << std::setprecision(1) << "azimuth "
            << DegFromRad(AzimuthOf(direction)) << ", elevation "
            << DegFromRad(ElevationOf(direction)) << " deg";
      return place.str();
    };
    if (!placed.heading_is_known) {
      text << name << ": which way its middle looks is not known: it is turned to "
           << std::fmod(DegFromRad(placed.heading_rad) + 720, 360)
           << " deg, where its sun has the hour's azimuth (--panorama-heading)";
      notes.push_back(text.str());
    }
    if (placed.sun_apart_rad > kSameSun_rad) {
      notes.push_back(
          name + ": its sun is at " + at(placed.own_sun) + ", that of the hour at " +
          at(sun.direction) +
          ": the panorama's is taken, for its sky belongs to it; light and shadows are "
          "those of another hour");
    } else if (placed.sun_apart_rad > RadFromDeg(1)) {
      text.str("");
      text << name << ": its sun is " << DegFromRad(placed.sun_apart_rad)
           << " deg off the hour's place, from where it is taken to shine";
      notes.push_back(text.str());
    }
    if (panorama.sun->clipped) {
      notes.push_back(
          name +
          ": its sun is cut off at the largest value of the file, so that its light is "
          "too little and shadows too faint; a panorama of more exposures does better");
    }
  }
  if (!options.panorama_scale && !panorama.absolute) {
    notes.push_back(name + ": its values have no unit: it is scaled to the level of " +
                    (panorama.sun ? "a clear day" : "a covered day") +
                    " (--panorama-scale)");
  }
  return notes;
}

Daylight UniformDaylight(const Eigen::Array3d& radiance, bool full_sphere) {
  Daylight daylight;
  daylight.sky = UniformSky{.radiance = radiance, .full_sphere = full_sphere};
  return daylight;
}

}  // namespace relight
