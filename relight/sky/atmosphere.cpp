// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/atmosphere.h"

#include "relight/base/angles.h"
#include "relight/sky/preetham_sun.h"
#include "relight/sky/rec709.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace relight {
namespace {

using std::numbers::pi;

constexpr int kWavelengths = 8;
using Spectrum = Eigen::Array<double, kWavelengths, 1>;
constexpr double kFirst_nm = 390.0, kStep_nm = 50.0;

constexpr double kEarth_km = 6371.0, kTop_km = 100.0;
constexpr double kEye_km = 0.002;
constexpr double kMoleculeHeight_km = 8.0;
constexpr double kSunRadius_rad = RadFromDeg(0.2665);

// Chosen on the relative luminances of shared reference/sky/hosek.csv, turbidity 2 to 6.
constexpr double kAerosolHeight_km = 1.407;
constexpr double kAerosolOfAngstrom = 0.234;
constexpr double kAerosolAlbedo = 0.85;  // Scattered, of what it takes.
constexpr double kForward = 0.706, kSideways = -0.23, kForwardShare = 0.786;
constexpr double kManyScatterings = 0.8;

constexpr int kHeights = 24, kSines = 48;               // Of the transmittances.
constexpr int kScatterHeights = 12, kScatterSuns = 40;  // Of Psi.
constexpr int kViewSteps = 40;

// Densities whose integral over the altitude is 1 [1/km].
struct Density {
  double molecules, aerosol, ozone;
};
Density DensityAt(double h_km) {
  const double h = std::max(0.0, h_km);
  return {std::exp(-h / kMoleculeHeight_km) / kMoleculeHeight_km,
          std::exp(-h / kAerosolHeight_km) / kAerosolHeight_km,
          std::max(0.0, 1 - std::abs(h - 25) / 15) / 15};
}

// A point at the radius r and a direction whose cosine with the vertical is mu.
double ToTop(double r, double mu) {
  const double top = kEarth_km + kTop_km;
  return -r * mu + std::sqrt(std::max(0.0, r * r * (mu * mu - 1) + top * top));
}
bool HitsEarth(double r, double mu) {
  return mu < 0 && r * r * (mu * mu - 1) + kEarth_km * kEarth_km >= 0;
}
double ToEarth(double r, double mu) {
  return -r * mu -
         std::sqrt(std::max(0.0, r * r * (mu * mu - 1) + kEarth_km * kEarth_km));
}
double HorizonCosine(double r) {
  const double sine = std::min(1.0, kEarth_km / r);
  return -std::sqrt(1 - sine * sine);
}

// Share of a disc of radius 1 above a line at the height `x` of its centre above it.
double ShareOfDisc(double x) {
  if (x >= 1) return 1.0;
  if (x <= -1) return 0.0;
  return 1 - (std::acos(x) - x * std::sqrt(1 - x * x)) / pi;
}

double Rayleigh(double cosine) { return 3 / (16 * pi) * (1 + cosine * cosine); }
double HenyeyGreenstein(double cosine, double g) {
  return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}
double AerosolPhase(double cosine) {
  return kForwardShare * HenyeyGreenstein(cosine, kForward) +
         (1 - kForwardShare) * HenyeyGreenstein(cosine, kSideways);
}

// Depths along a ray, each step so much longer than the one before that the air next to
// the eye is seen finely.
struct Step {
  double middle_km, length_km;
};
template <int kSteps, class Visit>
void March(double length_km, Visit&& visit) {
  for (int i = 0; i < kSteps; ++i) {
    const double a = static_cast<double>(i) / kSteps,
                 b = static_cast<double>(i + 1) / kSteps;
    visit(Step{length_km * (a * a + b * b) / 2, length_km * (b * b - a * a)});
  }
}

double RadiusAfter(double r, double mu, double t) {
  return std::sqrt(r * r + t * t + 2 * r * mu * t);
}

// Light scattered along a step of extinction e that begins with the transmittance T.
Spectrum OverStep(const Spectrum& source, const Spectrum& e, double length_km) {
  const Spectrum depth = e * length_km;
  return source * (depth > 1e-6).select((1 - (-depth).exp()) / e.max(1e-12), length_km);
}

}  // namespace

struct Atmosphere::Tables {
  Spectrum molecules, aerosol, ozone;             // Vertical optical depths.
  Eigen::Matrix<double, 3, kWavelengths> xyz_lx;  // XYZ of E_0 in each part of the light.
  std::vector<Spectrum> transmittance;  // [height][sine], to the top of the air.
  std::vector<Spectrum> scattered;      // [height][sun], Psi for E_0 = 1.

  struct Cell {
    int i, j;
    double x, y;
  };
  static Cell CellAt(double x, double y, int nx, int ny) {
    x = std::clamp(x, 0.0, nx - 1.0);
    y = std::clamp(y, 0.0, ny - 1.0);
    const int i = std::min(static_cast<int>(x), nx - 2),
              j = std::min(static_cast<int>(y), ny - 2);
    return {i, j, x - i, y - j};
  }
  static Spectrum Between4(const std::vector<Spectrum>& table, const Cell& c, int ny) {
    const Spectrum* low = &table[static_cast<std::size_t>(c.i * ny + c.j)];
    const Spectrum* high = low + ny;
    return (1 - c.x) * ((1 - c.y) * low[0] + c.y * low[1]) +
           c.x * ((1 - c.y) * high[0] + c.y * high[1]);
  }

  Spectrum Extinction(const Density& d) const {
    return d.molecules * molecules + d.aerosol * aerosol + d.ozone * ozone;
  }

  // Towards the sun, as much of whose disc is seen as the Earth leaves.
  Spectrum ToSun(double r, double mu) const {
    const double horizon = HorizonCosine(r);
    const double seen = ShareOfDisc((std::acos(std::clamp(horizon, -1.0, 1.0)) -
                                     std::acos(std::clamp(mu, -1.0, 1.0))) /
                                    kSunRadius_rad);
    if (seen <= 0) return Spectrum::Zero();
    const double h = std::max(0.0, r - kEarth_km);
    const double x = std::sqrt(h / kTop_km) * (kHeights - 1);
    const double y =
        std::sqrt(std::max(0.0, (mu - horizon) / (1 - horizon))) * (kSines - 1);
    return seen * Between4(transmittance, CellAt(x, y, kHeights, kSines), kSines);
  }

  Spectrum Scattered(double r, double mu_sun) const {
    const double h = std::max(0.0, r - kEarth_km);
    const double x = std::sqrt(h / kTop_km) * (kScatterHeights - 1);
    return Between4(scattered,
                    CellAt(x, SunIndex(mu_sun), kScatterHeights, kScatterSuns),
                    kScatterSuns);
  }
  // Suns are close together about the horizon: mu = 0.25 s |s| + 0.75 s^5.
  static double CosineOf(double s) {
    return 0.25 * s * std::abs(s) + 0.75 * s * s * s * s * s;
  }
  static double SunIndex(double mu) {
    double low = -1, high = 1;
    for (int i = 0; i < 24; ++i) {
      const double middle = 0.5 * (low + high);
      (CosineOf(middle) < mu ? low : high) = middle;
    }
    return (0.5 * (low + high) - kLowestSun) / (1 - kLowestSun) * (kScatterSuns - 1);
  }
  static constexpr double kLowestSun = -0.85;  // s: cosine -0.51

  void MakeTransmittance() {
    for (int i = 0; i < kHeights; ++i) {
      const double u = static_cast<double>(i) / (kHeights - 1);
      const double r = kEarth_km + kTop_km * u * u, horizon = HorizonCosine(r);
      for (int j = 0; j < kSines; ++j) {
        const double v = static_cast<double>(j) / (kSines - 1);
        const double mu = horizon + (1 - horizon) * v * v;
        Spectrum depth = Spectrum::Zero();
        March<64>(ToTop(r, mu), [&](const Step& s) {
          const double at = RadiusAfter(r, mu, s.middle_km);
          depth += Extinction(DensityAt(at - kEarth_km)) * s.length_km;
        });
        transmittance.push_back((-depth).exp());
      }
    }
  }

  // Psi = L_2 / (1 - f)                                                  [Hillaire20]
  void MakeScattered(double albedo) {
    constexpr int kRings = 8, kAzimuths = 4;
    for (int i = 0; i < kScatterHeights; ++i) {
      const double u = static_cast<double>(i) / (kScatterHeights - 1);
      const double r = kEarth_km + std::max(kTop_km * u * u, kEye_km);
      for (int j = 0; j < kScatterSuns; ++j) {
        const double mu_sun =
            CosineOf(kLowestSun + (1 - kLowestSun) * j / (kScatterSuns - 1));
        const double sine_sun = std::sqrt(std::max(0.0, 1 - mu_sun * mu_sun));
        Spectrum second = Spectrum::Zero(), back = Spectrum::Zero();
        for (int ring = 0; ring < kRings; ++ring) {
          const double mu = 2 * (ring + 0.5) / kRings - 1;
          for (int k = 0; k < kAzimuths; ++k) {
            // The sun is on +x: half of the azimuths stands for all
            const double cosine = mu * mu_sun + std::sqrt(1 - mu * mu) * sine_sun *
                                                    std::cos((k + 0.5) / kAzimuths * pi);
            const bool to_earth = HitsEarth(r, mu);
            const double length_km = to_earth ? ToEarth(r, mu) : ToTop(r, mu);
            Spectrum through = Spectrum::Ones();
            March<24>(length_km, [&](const Step& s) {
              const double at = RadiusAfter(r, mu, s.middle_km);
              const Density d = DensityAt(at - kEarth_km);
              const Spectrum e = Extinction(d);
              const Spectrum scattering =
                  d.molecules * molecules + kAerosolAlbedo * d.aerosol * aerosol;
              const Spectrum step = through * OverStep(scattering, e, s.length_km);
              const double sun_there = (r * mu_sun + s.middle_km * cosine) / at;
              second += step * ToSun(at, sun_there) / (4 * pi);
              back += step;
              through *= (-e * s.length_km).exp();
            });
            if (!to_earth) continue;
            const double on_ground = (r * mu_sun + length_km * cosine) / kEarth_km;
            second += through * albedo / pi * std::max(0.0, on_ground) *
                      ToSun(kEarth_km + kEye_km, on_ground);
          }
        }
        second /= kRings * kAzimuths;
        back /= kRings * kAzimuths;
        scattered.push_back(second / (1 - back.min(0.99)));
      }
    }
  }
};

Atmosphere::Atmosphere(const AtmosphereOptions& options) {
  CheckFields(options);
  auto tables = std::make_shared<Tables>();
  for (int k = 0; k < kWavelengths; ++k) {
    const SunTransmittance at =
        SunTransmittanceAt(kFirst_nm + kStep_nm * k, options.turbidity, 1.0);
    tables->molecules[k] = -std::log(at.rayleigh);
    tables->aerosol[k] = -kAerosolOfAngstrom * std::log(at.aerosol);
    tables->ozone[k] = -std::log(at.ozone);
  }
  // What is between two wavelengths goes to both, linearly
  tables->xyz_lx.setZero();
  for (double nm = 380; nm <= 750; nm += 5) {
    const double at = std::clamp((nm - kFirst_nm) / kStep_nm, 0.0, kWavelengths - 1.0);
    const int k = std::min(static_cast<int>(at), kWavelengths - 2);
    const Eigen::Vector3d xyz = 5 * SunXyzAboveAtmosphere(nm).matrix();
    tables->xyz_lx.col(k) += (1 - (at - k)) * xyz;
    tables->xyz_lx.col(k + 1) += (at - k) * xyz;
  }
  tables->MakeTransmittance();
  tables->MakeScattered(options.ground_albedo);
  tables_ = tables;
}

// L(w)                                                                           (K6)
Eigen::Array3d Atmosphere::SkyRadiance(const Eigen::Vector3d& sun,
                                       const Eigen::Vector3d& direction) const {
  if (direction.z() < 0) return Eigen::Array3d::Zero();
  const double r = kEarth_km + kEye_km, mu = std::max(direction.z(), 1e-4);
  const double cosine = std::clamp(sun.dot(direction), -1.0, 1.0);
  const double rayleigh = Rayleigh(cosine), aerosol = AerosolPhase(cosine);
  Spectrum light = Spectrum::Zero(), through = Spectrum::Ones();
  March<kViewSteps>(ToTop(r, mu), [&](const Step& s) {
    const double at = RadiusAfter(r, mu, s.middle_km);
    const double sun_there = (r * sun.z() + s.middle_km * cosine) / at;
    const Density d = DensityAt(at - kEarth_km);
    const Spectrum molecules = d.molecules * tables_->molecules;
    const Spectrum haze = d.aerosol * tables_->aerosol;
    const Spectrum e = molecules + haze + d.ozone * tables_->ozone;
    const Spectrum source = (rayleigh * molecules + aerosol * kAerosolAlbedo * haze) *
                                tables_->ToSun(at, sun_there) +
                            kManyScatterings * (molecules + kAerosolAlbedo * haze) *
                                tables_->Scattered(at, sun_there);
    light += through * OverStep(source, e, s.length_km);
    through *= (-e * s.length_km).exp();
  });
  const Eigen::Array3d xyz = (tables_->xyz_lx * light.matrix()).array();
  return Rec709FromXyz(xyz.max(0.0));
}

// E_sun = E_0 T v                                                                (K7)
Eigen::Array3d Atmosphere::SunIrradiance(const Eigen::Vector3d& sun) const {
  const Spectrum seen = tables_->ToSun(kEarth_km, sun.z());
  return Rec709FromXyz((tables_->xyz_lx * seen.matrix()).array());
}

Eigen::Vector3d SeenPartOfSun(const Eigen::Vector3d& sun) {
  const double elevation_rad = ElevationOf(sun);
  if (std::abs(elevation_rad) >= kSunRadius_rad) return sun;
  return DirectionFromAzimuthElevation(AzimuthOf(sun),
                                       0.5 * (elevation_rad + kSunRadius_rad));
}

}  // namespace relight
