// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/true_heading.h"

#include "relight/base/error.h"
#include "tests/relight/photo/made_files.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace relight {
namespace {

// NOAA's own test values: date, height [km], latitude, longitude, declination [deg].
void AgreesWithTestValues(const char* file, const char* model) {
  RELIGHT_SKIP_WITHOUT_SHARED(std::filesystem::path("reference/magnetic") / file);
  std::ifstream in(tests::SharedPath(std::filesystem::path("reference/magnetic") / file));
  std::string line;
  int rows = 0;
  double worst_deg = 0.0;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream columns(line);
    double year, height_km, latitude, longitude, declination;
    ASSERT_TRUE(columns >> year >> height_km >> latitude >> longitude >> declination)
        << line;
    const Declination d = MagneticDeclination({.latitude_deg = latitude,
                                               .longitude_deg = longitude,
                                               .altitude_m = 1000 * height_km},
                                              year);
    EXPECT_EQ(d.model, model);
    worst_deg = std::max(worst_deg, std::abs(d.declination_deg - declination));
    ++rows;
  }
  EXPECT_EQ(rows, 100);
  EXPECT_LE(worst_deg, 0.00501);  // Printed with two digits
}

TEST(TrueHeading, AgreesWithNoaaIn2020) {
  AgreesWithTestValues("WMM2020_TEST_VALUES.txt", "wmm2020");
}
TEST(TrueHeading, AgreesWithNoaaIn2025) {
  AgreesWithTestValues("WMM2025_FINAL_TEST_VALUES_HIGHPREC.txt", "wmm2025");
}

TEST(TrueHeading, AddsTheDeclination) {
  const Instant july_2011 =
      Instant(std::chrono::sys_days(std::chrono::year(2011) / 7 / 22));
  const Place princeton{.latitude_deg = 40.35, .longitude_deg = -74.65, .altitude_m = 20};
  const TrueHeading heading = TrueFromMagnetic(5.0, princeton, july_2011);
  EXPECT_EQ(heading.declination.model, "wmm2010");
  // The needle pointed 12 to 13 degrees west of north in New Jersey then
  EXPECT_NEAR(heading.declination.declination_deg, -12.6, 0.5);
  EXPECT_DOUBLE_EQ(heading.heading_deg, 365.0 + heading.declination.declination_deg);
  EXPECT_TRUE(heading.declination.notes.empty());
}

TEST(TrueHeading, YearsWithoutAModelTakeTheNearestAndSaySo) {
  const Place place{.latitude_deg = 48.0, .longitude_deg = 2.0};
  EXPECT_EQ(MagneticDeclination(place, 1999.0).notes.size(), 1u);
  EXPECT_EQ(MagneticDeclination(place, 1999.0).declination_deg,
            MagneticDeclination(place, 2010.0).declination_deg);
  EXPECT_EQ(MagneticDeclination(place, 2035.0).declination_deg,
            MagneticDeclination(place, 2030.0).declination_deg);
  // From model to model at a border: the fields part by a fraction of a degree
  for (const double year : {2015.0, 2020.0, 2025.0}) {
    EXPECT_NEAR(MagneticDeclination(place, year - 1e-6).declination_deg,
                MagneticDeclination(place, year).declination_deg,
                0.3);
  }
  EXPECT_FALSE(MagneticDeclination({.latitude_deg = 86.0, .longitude_deg = 160.0}, 2022)
                   .notes.empty());
}

TEST(TrueHeading, DecimalYears) {
  using namespace std::chrono;
  EXPECT_EQ(DecimalYear(sys_days(year(2011) / 1 / 1)), 2011.0);
  EXPECT_DOUBLE_EQ(DecimalYear(Instant(sys_days(year(2011) / 7 / 2)) + hours(12)),
                   2011.5);
  EXPECT_DOUBLE_EQ(DecimalYear(sys_days(year(2012) / 7 / 2)), 2012.5);  // A leap year
}

TEST(TrueHeading, SaysWhereTheModelsWereLookedFor) {
  const tests::TemporaryFolder folder;
  const tests::WithEnvironment data("RELIGHT_DATA", folder.path().string());
  const std::string words =
      tests::WordsOf<InputError>([] { MagneticDeclination({}, 2020.0); });
  EXPECT_NE(words.find(folder.path().string()), std::string::npos) << words;
}

}  // namespace
}  // namespace relight
