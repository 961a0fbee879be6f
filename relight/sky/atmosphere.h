// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sun and clear sky through air of our own making: molecules, aerosol and ozone over
// altitude, at eight wavelengths, from the zenith to a sun 6 degrees below the horizon.
//
//   [Nishita93]  docs/bibliography.md#nishita93   single scattering in a round atmosphere
//   [Hillaire20] docs/bibliography.md#hillaire20  many scatterings as a geometric series
//   [Preetham99] docs/bibliography.md#preetham99  optical depths, spectrum of the sun
//
// Per wavelength, over the altitude h of the point x that the view ray w passes:
//
//   L(w)  = integral of T(x, eye) (b_r p_r + b_m p_m) T(x, sun) E_0
//           + T(x, eye) (b_r + b_m) Psi(x) dx                                      (K6)
//   Psi   = L_2 / (1 - f)                                               [Hillaire20]
//   E_sun = E_0 T(eye, sun) v                                                      (K7)
//
// b_r, b_m  scattering of molecules and aerosol [1/km], exp(-h / 8 km), exp(-h / H);
//           ozone absorbs between 10 and 40 km, most at 25 km
// p_r, p_m  phase functions: Rayleigh's; two of Henyey and Greenstein, forward and not
// T         transmittance; none through the Earth, whose edge lets through as much of the
//           sun's disc as is above it
// L_2       light that the second scattering finds, the ground's reflection in it, and f
//           the share of light that comes back from a scattering everywhere, both as if
//           scattered evenly
// v         share of the sun's disc above the horizon: light goes on smoothly through
//           sunset
//
// Vertical optical depths of molecules and ozone are [Preetham99]'s. The aerosol's is a
// fraction of Angstrom's, and H, p_m and the weight of Psi are chosen so that relative
// luminances are those of a published sky that was computed by tracing paths through the
// air (docs/validation.md#skies). Not in it: refraction, polarisation, water vapour,
// clouds, light of the night sky.

#include "relight/base/field.h"

#include <Eigen/Core>

#include <memory>

namespace relight {

inline constexpr double kLowestTwilight_deg = -6.0;

struct AtmosphereOptions {
  double turbidity = 3.0;
  double ground_albedo = 0.2;
};

template <class Visitor>
void Describe(AtmosphereOptions& o, Visitor&& field) {
  field(o.turbidity,
        {"turbidity", "", "haze of the air: 2 clear, 6 hazy", Between(1.7, 10)});
  field(o.ground_albedo,
        {"ground-albedo", "", "light that the ground reflects", Between(0, 1)});
}

class Atmosphere {
 public:
  // Makes the tables: some hundredths of a second. Throws OptionError.
  explicit Atmosphere(const AtmosphereOptions& options = {});

  // Linear Rec.709 [cd/m2 per channel] of a unit direction, negative X or Z set to 0; 0
  // below the horizon. `sun_in_world` is a unit vector.
  Eigen::Array3d SkyRadiance(const Eigen::Vector3d& sun_in_world,
                             const Eigen::Vector3d& direction_in_world) const;

  // Linear Rec.709 [lx] on a plane that faces the sun, nothing clamped but X and Z.
  Eigen::Array3d SunIrradiance(const Eigen::Vector3d& sun_in_world) const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;  // Never changed once made.
};

// Where the light of what is above the horizon of the sun's disc comes from: the sun
// itself when it is wholly up, else the middle of what is seen of it; the sun itself when
// nothing is.
Eigen::Vector3d SeenPartOfSun(const Eigen::Vector3d& sun_in_world);

}  // namespace relight
