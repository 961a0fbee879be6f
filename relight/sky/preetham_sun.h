// SPDX-License-Identifier: Apache-2.0
#pragma once

// Irradiance of the sun behind the atmosphere.
//
//   [Preetham99] docs/bibliography.md#preetham99   transmittances, solar spectrum
//
//   tau_r = exp(-0.008735 l^-4.08 m)                        Rayleigh
//   tau_a = exp(-beta l^-1.3 m)                             aerosol (Angstrom)
//   tau_o = exp(-0.35 k_o m)                                ozone, 0.35 cm
//   tau_w = exp(-0.2385 k_wa w m / (1 + 20.07 k_wa w m)^0.45)  water vapour, w = 2 cm
//                                                                       [Preetham99]
//   E     = 683 lm/W * omega_s * integral L_0 tau_r tau_a tau_o tau_w (xbar, ybar, zbar)
//   dl
//                                                                              (K4)
// l       wavelength [um] in these formulas       m   air mass [KastenYoung89]
// beta    0.04608 T - 0.04586, T the turbidity (we carry the authors' further digits)
// L_0     radiance of the sun above the atmosphere [W m^-2 nm^-1 sr^-1]
// omega_s solid angle of the sun, pi/4 (1.39 / 150)^2 sr
//
// The integral runs from 380 to 750 nm by the trapezoid rule in steps of 5 nm. The mixed
// gases of the paper absorb from 759 nm on, so their transmittance is 1 here.

#include "relight/base/field.h"

#include <Eigen/Core>

namespace relight {

struct PreethamSunOptions {
  double turbidity = 3.0;
};

template <class Visitor>
void Describe(PreethamSunOptions& o, Visitor&& field) {
  field(o.turbidity,
        {"turbidity", "", "haze of the air: 2 clear, 6 hazy", Between(1.7, 10)});
}

// What each part of the atmosphere lets through at one wavelength, each in [0, 1].
struct SunTransmittance {
  double rayleigh = 1.0;
  double aerosol = 1.0;
  double ozone = 1.0;
  double water = 1.0;

  double Total() const { return rayleigh * aerosol * ozone * water; }
};

// `wavelength_nm` in [380, 750].
SunTransmittance SunTransmittanceAt(double wavelength_nm,
                                    double turbidity,
                                    double air_mass);

// L_0 [W m^-2 nm^-1 sr^-1], linear between the paper's 10 nm; `wavelength_nm` in [380,
// 750].
double SunRadianceAboveAtmosphere(double wavelength_nm);

// Irradiance of the sun above the atmosphere [lx/nm] as CIE 1931 XYZ; `wavelength_nm` in
// [380, 750], taken to the nearest 5 nm.
Eigen::Array3d SunXyzAboveAtmosphere(double wavelength_nm);

// On a plane that faces the sun.
struct SunIrradiance {
  Eigen::Array3d xyz_lx;  // CIE 1931; the second is the illuminance.
  Eigen::Array3d rgb_lx;  // Linear Rec.709, nothing clamped: blue is negative at dusk.
  double visible_w_per_m2 = 0.0;  // From 380 to 750 nm.
};

SunIrradiance PreethamSunIrradianceAtAirMass(double air_mass,
                                             const PreethamSunOptions& options = {});

// Throws OptionError, and InputError for a sun at or below the horizon.
SunIrradiance PreethamSunIrradiance(const Eigen::Vector3d& sun_in_world,
                                    const PreethamSunOptions& options = {});

}  // namespace relight
