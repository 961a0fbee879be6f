// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/true_heading.h"

#include "relight/base/data_folder.h"
#include "relight/base/error.h"

#include <GeographicLib/MagneticModel.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace relight {
namespace {

struct ModelYears {
  const char* name;
  double from, to;  // Decimal years.
};

constexpr std::array kModels = {ModelYears{"wmm2010", 2010, 2015},
                                ModelYears{"wmm2015v2", 2015, 2020},
                                ModelYears{"wmm2020", 2020, 2025},
                                ModelYears{"wmm2025", 2025, 2030}};

// Of the two at a border the newer: it has measured what the older foretold.
const ModelYears& ModelOf(double year) {
  const auto covering =
      std::find_if(kModels.rbegin(), kModels.rend(), [&](const ModelYears& model) {
        return year >= model.from;
      });
  return covering == kModels.rend() ? kModels.front() : *covering;
}

std::string InYears(double year) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", year);
  return text;
}

}  // namespace

Declination MagneticDeclination(const Place& place, double year) {
  const ModelYears& years = ModelOf(year);
  Declination result{.model = years.name};
  const double asked = std::clamp(year, years.from, years.to);
  if (asked != year) {
    result.notes.push_back("No magnetic model for " + InYears(year) +
                           " is at hand; magnetic north is that of " + InYears(asked) +
                           ".");
  }

  double east_nt = 0.0, north_nt = 0.0, up_nt = 0.0;
  try {
    const GeographicLib::MagneticModel model(years.name, DataPath("magnetic").string());
    model(asked,
          place.latitude_deg,
          place.longitude_deg,
          place.altitude_m,
          east_nt,
          north_nt,
          up_nt);
  } catch (const GeographicLib::GeographicErr& e) {
    throw InputError(std::string("magnetic model ") + years.name + ": " + e.what() +
                     "; install relight's data again, or set RELIGHT_DATA");
  }
  double horizontal_nt, total_nt, dip_deg;
  GeographicLib::MagneticModel::FieldComponents(
      east_nt, north_nt, up_nt, horizontal_nt, total_nt, result.declination_deg, dip_deg);

  constexpr double kCautionNt = 6000.0;  // [WMM]'s caution zone
  if (horizontal_nt < kCautionNt) {
    result.notes.push_back(
        "So near the magnetic pole a compass is hardly to be trusted; give --heading.");
  }
  return result;
}

// true heading = magnetic heading + D                                    (P2)
TrueHeading TrueFromMagnetic(double magnetic_heading_deg,
                             const Place& place,
                             Instant utc) {
  TrueHeading result{.declination = MagneticDeclination(place, DecimalYear(utc))};
  const double sum = magnetic_heading_deg + result.declination.declination_deg;
  result.heading_deg = sum - 360.0 * std::floor(sum / 360.0);
  if (result.heading_deg >= 360.0) result.heading_deg = 0.0;
  return result;
}

double DecimalYear(Instant utc) {
  using namespace std::chrono;
  const year_month_day date{floor<days>(utc)};
  const sys_days begin = date.year() / January / 1;
  const sys_days end = (date.year() + years(1)) / January / 1;
  return int(date.year()) + duration<double>(utc - begin) / duration<double>(end - begin);
}

}  // namespace relight
