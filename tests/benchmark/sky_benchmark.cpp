// SPDX-License-Identifier: Apache-2.0

// What the skies give, and what their harmonics cost.
//
//   benchmark_skies
//
// First a table of levels: light on level ground of each sky over that of preetham at
// turbidity 3 (docs/skies.md). Then, on Preetham's sky, a polynomial in the sun's height
// and the turbidity, fitted once to each coefficient, against projecting the sky at run
// time (docs/decisions/0010): largest and mean relative error over suns and turbidities
// that the fit has not seen, and CPU time of both.

#include "relight/base/angles.h"
#include "relight/sh/sky_coefficients.h"
#include "relight/sky/daylight.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

namespace relight {
namespace {

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

SolarPosition SunAt(double azimuth_rad, double elevation_deg) {
  const double elevation_rad = RadFromDeg(elevation_deg);
  return {azimuth_rad,
          elevation_rad,
          DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)};
}

// --- Levels --------------------------------------------------------------------------

double GroundLux(const Daylight& day) {
  return Luminance(HorizontalSkyIrradiance(day)) +
         Luminance(day.sun_irradiance) * std::max(0.0, day.sun_direction.z());
}

void PrintLevels() {
  struct Row {
    std::string name;
    DaylightOptions sky;
  };
  std::vector<Row> rows = {
      {"preetham, 2", {.turbidity = 2.0}},
      {"preetham, 3", {.turbidity = 3.0}},
      {"preetham, 6", {.turbidity = 6.0}},
      {"atmosphere, 2", {.model = SkyModel::kAtmosphere, .turbidity = 2.0}},
      {"atmosphere, 3", {.model = SkyModel::kAtmosphere, .turbidity = 3.0}},
      {"atmosphere, 6", {.model = SkyModel::kAtmosphere, .turbidity = 6.0}},
      {"atmosphere, 3, albedo 0.8",
       {.model = SkyModel::kAtmosphere, .turbidity = 3.0, .ground_albedo = 0.8}},
      {"cabral2011 (4.2)", {.model = SkyModel::kCabral2011}},
      {"--cloud 0.5", {.turbidity = 3.0, .cloud = 0.5}}};
  for (const int type : {1, 5, 7, 10, 12, 15}) {
    rows.push_back({fmt::format("cie:{}", type),
                    {.model = SkyModel::kCie, .turbidity = 3.0, .cie_type = type}});
  }
  fmt::print("| sky, turbidity | sun 5° | 15° | 30° | 60° | share of the sky at 30° |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    fmt::print("| {} |", row.name);
    for (const double elevation_deg : {5.0, 15.0, 30.0, 60.0}) {
      const SolarPosition sun = SunAt(2.0, elevation_deg);
      fmt::print(" {:.2f} |",
                 GroundLux(MakeDaylight(sun, row.sky)) /
                     GroundLux(MakeDaylight(sun, {.turbidity = 3.0})));
    }
    const Daylight day = MakeDaylight(SunAt(2.0, 30), row.sky);
    fmt::print(" {:.0f} % |\n",
               100 * Luminance(HorizontalSkyIrradiance(day)) / GroundLux(day));
  }
}

// --- Harmonics of Preetham's sky by a fit --------------------------------------------

constexpr int kHeights = 10, kTurbidities = 4;  // Terms: powers 0 … of each

// Powers of the sun's zenith angle and the turbidity, both brought to [-1, 1].
Eigen::VectorXd Terms(double elevation_deg, double turbidity) {
  const double a = elevation_deg / 45 - 1, t = (turbidity - 6) / 4;
  Eigen::VectorXd terms(kHeights * kTurbidities);
  double height = 1;
  for (int i = 0; i < kHeights; ++i, height *= a) {
    double power = height;
    for (int j = 0; j < kTurbidities; ++j, power *= t)
      terms[i * kTurbidities + j] = power;
  }
  return terms;
}

// The sun in +x: coefficients are then symmetric about its plane, and those of m < 0 are
// 0.
constexpr double kAlongX_rad = std::numbers::pi / 2;

ShCoefficients Projected(double azimuth_rad, double elevation_deg, double turbidity) {
  return SkyCoefficients(
      MakeDaylight(SunAt(azimuth_rad, elevation_deg), {.turbidity = turbidity}));
}

void PrintFit() {
  const int count = ShCount(kSkyBands);
  std::vector<Eigen::VectorXd> terms, values;
  for (double turbidity = 2; turbidity <= 10; turbidity += 0.5) {
    for (double elevation_deg = 0.5; elevation_deg <= 90; elevation_deg += 1.5) {
      const ShCoefficients c = Projected(kAlongX_rad, elevation_deg, turbidity);
      const double weight = 1 / c.norm();  // Relative errors are to be small
      terms.push_back(weight * Terms(elevation_deg, turbidity));
      values.push_back(weight * Eigen::Map<const Eigen::VectorXd>(c.data(), c.size()));
    }
  }
  Eigen::MatrixXd a(terms.size(), terms[0].size()), b(terms.size(), values[0].size());
  for (std::size_t i = 0; i < terms.size(); ++i) {
    a.row(static_cast<Eigen::Index>(i)) = terms[i].transpose();
    b.row(static_cast<Eigen::Index>(i)) = values[i].transpose();
  }
  const Eigen::MatrixXd fit = a.colPivHouseholderQr().solve(b);
  const Eigen::MatrixXd by_coefficient = fit.transpose();
  const auto fitted = [&](double azimuth_rad, double elevation_deg, double turbidity) {
    ShCoefficients c(count, 3);
    Eigen::Map<Eigen::VectorXd>(c.data(), c.size()) =
        by_coefficient * Terms(elevation_deg, turbidity);
    return TurnedAboutZ(c, kAlongX_rad - azimuth_rad);
  };

  double worst = 0, sum = 0, worst_high = 0;
  int cases = 0;
  for (double turbidity = 2.25; turbidity < 10; turbidity += 0.5) {
    for (double elevation_deg = 1; elevation_deg < 90; elevation_deg += 1.5) {
      const ShCoefficients exact = Projected(4.0, elevation_deg, turbidity);
      const double error =
          (fitted(4.0, elevation_deg, turbidity) - exact).norm() / exact.norm();
      worst = std::max(worst, error);
      if (elevation_deg > 10) worst_high = std::max(worst_high, error);
      sum += error;
      ++cases;
    }
  }
  const auto milliseconds = [](const auto& work) {
    constexpr int kRuns = 200;
    double least = 1e9;
    for (int run = 0; run < 5; ++run) {
      const double begin = CpuSeconds();
      for (int i = 0; i < kRuns; ++i) work(10 + 0.3 * i);
      least = std::min(least, (CpuSeconds() - begin) / kRuns);
    }
    return 1e3 * least;
  };
  double seen = 0;
  const double project_ms = milliseconds(
      [&](double elevation_deg) { seen += Projected(4.0, elevation_deg, 3)(0, 0); });
  const double fit_ms = milliseconds(
      [&](double elevation_deg) { seen += fitted(4.0, elevation_deg, 3)(0, 0); });
  fmt::print(
      "\nPreetham's sky in 6 bands by {} numbers: relative error mean {:.4f}, largest "
      "{:.4f} ({:.4f} with the sun above 10 deg); projected {:.3f} CPU ms, fitted "
      "{:.4f}{}\n",
      fit.size(),
      sum / cases,
      worst,
      worst_high,
      project_ms,
      fit_ms,
      std::isfinite(seen) ? "" : " ?");
}

int Run() {
  PrintLevels();
  PrintFit();
  return 0;
}

}  // namespace
}  // namespace relight

int main() {
  try {
    return relight::Run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
