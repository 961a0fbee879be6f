// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/preetham_sun.h"

#include "relight/base/error.h"
#include "relight/sky/air_mass.h"
#include "relight/sky/rec709.h"

#include <algorithm>
#include <iterator>
#include <numbers>

namespace relight {
namespace {

constexpr double kFirst_nm = 380.0;
constexpr double kLast_nm = 750.0;
constexpr double kStep_nm = 5.0;
constexpr double kLumenPerWatt = 683.0;
constexpr double kSunSolidAngle_sr =
    0.25 * std::numbers::pi * (1.39 / 150.0) * (1.39 / 150.0);

struct Sample {
  double wavelength_nm;
  double value;
};

// Piecewise linear through samples of rising wavelength.
template <std::size_t kCount>
double Interpolate(const Sample (&table)[kCount], double wavelength_nm) {
  const Sample* above =
      std::find_if(std::begin(table) + 1, std::end(table) - 1, [&](const Sample& s) {
        return s.wavelength_nm >= wavelength_nm;
      });
  const Sample& a = *(above - 1);
  const Sample& b = *above;
  const double t =
      (wavelength_nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
  return a.value + t * (b.value - a.value);
}

// Radiance of the sun above the atmosphere [W m^-2 nm^-1 sr^-1].       [Preetham99]
constexpr Sample kSunRadiance[] = {
    {380, 16559.0}, {390, 16233.7}, {400, 21127.5}, {410, 25888.2}, {420, 25829.1},
    {430, 24232.3}, {440, 26760.5}, {450, 29658.3}, {460, 30545.4}, {470, 30057.5},
    {480, 30663.7}, {490, 28830.4}, {500, 28712.1}, {510, 27825.0}, {520, 27100.6},
    {530, 27233.6}, {540, 26361.3}, {550, 25503.8}, {560, 25060.2}, {570, 25311.6},
    {580, 25355.9}, {590, 25134.2}, {600, 24631.5}, {610, 24173.2}, {620, 23685.3},
    {630, 23212.1}, {640, 22827.7}, {650, 22339.8}, {660, 21970.2}, {670, 21526.7},
    {680, 21097.9}, {690, 20728.3}, {700, 20240.4}, {710, 19870.8}, {720, 19427.2},
    {730, 19072.4}, {740, 18628.9}, {750, 18259.2}};

// Absorption of ozone, k_o [1/cm].                                     [Preetham99]
constexpr Sample kOzone[] = {
    {355, 0.0},   {445, 0.003}, {450, 0.003}, {455, 0.004}, {460, 0.006}, {465, 0.008},
    {470, 0.009}, {475, 0.012}, {480, 0.014}, {485, 0.017}, {490, 0.021}, {495, 0.025},
    {500, 0.030}, {505, 0.035}, {510, 0.040}, {515, 0.045}, {520, 0.048}, {525, 0.057},
    {530, 0.063}, {535, 0.070}, {540, 0.075}, {545, 0.080}, {550, 0.085}, {555, 0.095},
    {560, 0.103}, {565, 0.110}, {570, 0.120}, {575, 0.122}, {580, 0.120}, {585, 0.118},
    {590, 0.115}, {595, 0.120}, {600, 0.125}, {605, 0.130}, {610, 0.120}, {620, 0.105},
    {630, 0.090}, {640, 0.079}, {650, 0.067}, {660, 0.057}, {670, 0.048}, {680, 0.036},
    {690, 0.028}, {700, 0.023}, {710, 0.018}, {720, 0.014}, {730, 0.011}, {740, 0.010},
    {750, 0.009}};

// Absorption of water vapour, k_wa [1/cm].                             [Preetham99]
constexpr Sample kWater[] = {{380, 0.0},
                             {689, 0.0},
                             {690, 0.016},
                             {700, 0.024},
                             {710, 0.0125},
                             {720, 1.0},
                             {730, 0.87},
                             {740, 0.061},
                             {750, 0.001}};

// CIE 1931 two-degree observer from 380 to 750 nm in steps of 5 nm: xbar, ybar, zbar.
constexpr double kObserver[][3] = {
    {0.001368, 0.000039, 0.006450}, {0.002236, 0.000064, 0.010550},
    {0.004243, 0.000120, 0.020050}, {0.007650, 0.000217, 0.036210},
    {0.014310, 0.000396, 0.067850}, {0.023190, 0.000640, 0.110200},
    {0.043510, 0.001210, 0.207400}, {0.077630, 0.002180, 0.371300},
    {0.134380, 0.004000, 0.645600}, {0.214770, 0.007300, 1.039050},
    {0.283900, 0.011600, 1.385600}, {0.328500, 0.016840, 1.622960},
    {0.348280, 0.023000, 1.747060}, {0.348060, 0.029800, 1.782600},
    {0.336200, 0.038000, 1.772110}, {0.318700, 0.048000, 1.744100},
    {0.290800, 0.060000, 1.669200}, {0.251100, 0.073900, 1.528100},
    {0.195360, 0.090980, 1.287640}, {0.142100, 0.112600, 1.041900},
    {0.095640, 0.139020, 0.812950}, {0.057950, 0.169300, 0.616200},
    {0.032010, 0.208020, 0.465180}, {0.014700, 0.258600, 0.353300},
    {0.004900, 0.323000, 0.272000}, {0.002400, 0.407300, 0.212300},
    {0.009300, 0.503000, 0.158200}, {0.029100, 0.608200, 0.111700},
    {0.063270, 0.710000, 0.078250}, {0.109600, 0.793200, 0.057250},
    {0.165500, 0.862000, 0.042160}, {0.225750, 0.914850, 0.029840},
    {0.290400, 0.954000, 0.020300}, {0.359700, 0.980300, 0.013400},
    {0.433450, 0.994950, 0.008750}, {0.512050, 1.000000, 0.005750},
    {0.594500, 0.995000, 0.003900}, {0.678400, 0.978600, 0.002750},
    {0.762100, 0.952000, 0.002100}, {0.842500, 0.915400, 0.001800},
    {0.916300, 0.870000, 0.001650}, {0.978600, 0.816300, 0.001400},
    {1.026300, 0.757000, 0.001100}, {1.056700, 0.694900, 0.001000},
    {1.062200, 0.631000, 0.000800}, {1.045600, 0.566800, 0.000600},
    {1.002600, 0.503000, 0.000340}, {0.938400, 0.441200, 0.000240},
    {0.854450, 0.381000, 0.000190}, {0.751400, 0.321000, 0.000100},
    {0.642400, 0.265000, 0.000050}, {0.541900, 0.217000, 0.000030},
    {0.447900, 0.175000, 0.000020}, {0.360800, 0.138200, 0.000010},
    {0.283500, 0.107000, 0.000000}, {0.218700, 0.081600, 0.000000},
    {0.164900, 0.061000, 0.000000}, {0.121200, 0.044580, 0.000000},
    {0.087400, 0.032000, 0.000000}, {0.063600, 0.023200, 0.000000},
    {0.046770, 0.017000, 0.000000}, {0.032900, 0.011920, 0.000000},
    {0.022700, 0.008210, 0.000000}, {0.015840, 0.005723, 0.000000},
    {0.011359, 0.004102, 0.000000}, {0.008111, 0.002929, 0.000000},
    {0.005790, 0.002091, 0.000000}, {0.004109, 0.001484, 0.000000},
    {0.002899, 0.001047, 0.000000}, {0.002049, 0.000740, 0.000000},
    {0.001440, 0.000520, 0.000000}, {0.001000, 0.000361, 0.000000},
    {0.000690, 0.000249, 0.000000}, {0.000476, 0.000172, 0.000000},
    {0.000332, 0.000120, 0.000000}};

static_assert(std::size(kObserver) == (kLast_nm - kFirst_nm) / kStep_nm + 1);

void RequireInRange(double wavelength_nm) {
  Require(wavelength_nm >= kFirst_nm && wavelength_nm <= kLast_nm,
          "a wavelength of the sun's table is 380 to 750 nm");
}

}  // namespace

double SunRadianceAboveAtmosphere(double wavelength_nm) {
  RequireInRange(wavelength_nm);
  return Interpolate(kSunRadiance, wavelength_nm);
}

// tau_r = exp(-0.008735 l^-4.08 m)           tau_a = exp(-beta l^-1.3 m)
// tau_o = exp(-0.35 k_o m)
// tau_w = exp(-0.2385 k_wa w m / (1 + 20.07 k_wa w m)^0.45),  w = 2    [Preetham99]
SunTransmittance SunTransmittanceAt(double wavelength_nm, double turbidity, double m) {
  RequireInRange(wavelength_nm);
  const double l = wavelength_nm / 1000.0;
  const double beta = 0.04608365822050 * turbidity - 0.04586025928522;
  const double ozone = 0.35 * Interpolate(kOzone, wavelength_nm) * m;
  const double water = Interpolate(kWater, wavelength_nm) * 2.0 * m;
  return {.rayleigh = std::exp(-0.008735 * std::pow(l, -4.08) * m),
          .aerosol = std::exp(-beta * std::pow(l, -1.3) * m),
          .ozone = std::exp(-ozone),
          .water = std::exp(-0.2385 * water / std::pow(1.0 + 20.07 * water, 0.45))};
}

Eigen::Array3d SunXyzAboveAtmosphere(double wavelength_nm) {
  RequireInRange(wavelength_nm);
  const auto i = static_cast<int>(std::lround((wavelength_nm - kFirst_nm) / kStep_nm));
  return kLumenPerWatt * kSunSolidAngle_sr * SunRadianceAboveAtmosphere(wavelength_nm) *
         Eigen::Array3d::Map(kObserver[i]);
}

// E = 683 omega_s integral L_0 tau (xbar, ybar, zbar) dl                        (K4)
SunIrradiance PreethamSunIrradianceAtAirMass(double air_mass,
                                             const PreethamSunOptions& options) {
  CheckFields(options);
  SunIrradiance sun{.xyz_lx = Eigen::Array3d::Zero(), .rgb_lx = Eigen::Array3d::Zero()};
  const int last = static_cast<int>(std::size(kObserver)) - 1;
  for (int i = 0; i <= last; ++i) {
    const double wavelength_nm = kFirst_nm + kStep_nm * i;
    const double weight_nm = (i == 0 || i == last) ? 0.5 * kStep_nm : kStep_nm;
    const double irradiance =
        kSunSolidAngle_sr * weight_nm * SunRadianceAboveAtmosphere(wavelength_nm) *
        SunTransmittanceAt(wavelength_nm, options.turbidity, air_mass).Total();
    sun.visible_w_per_m2 += irradiance;
    sun.xyz_lx += kLumenPerWatt * irradiance * Eigen::Array3d::Map(kObserver[i]);
  }
  sun.rgb_lx = Rec709FromXyz(sun.xyz_lx);
  return sun;
}

SunIrradiance PreethamSunIrradiance(const Eigen::Vector3d& sun_in_world,
                                    const PreethamSunOptions& options) {
  return PreethamSunIrradianceAtAirMass(AirMassOfSun(sun_in_world), options);
}

}  // namespace relight
