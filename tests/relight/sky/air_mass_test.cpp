// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/air_mass.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// The table has ten digits of the same formula.
TEST(AirMass, AgreesWithTheTable) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/airmass.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/airmass.csv"));
  ASSERT_EQ(rows.size(), 25u);
  for (const auto& row : rows) {
    EXPECT_NEAR(AirMass(RadFromDeg(row["zenith_deg"])), row["m_kastenyoung1989"], 1e-7);
  }
}

TEST(AirMass, GrowsTowardsTheHorizonAndEndsBelowIt) {
  for (double z_deg = 0.0; z_deg < 91.0; z_deg += 0.5) {
    EXPECT_LT(AirMass(RadFromDeg(z_deg)), AirMass(RadFromDeg(z_deg + 0.5)));
  }
  EXPECT_THROW(AirMass(RadFromDeg(91.5)), InputError);
  EXPECT_THROW(AirMass(-0.1), InputError);
}

// Flat layers give 1 / cos z; up to 60 degrees the earth's curve takes 0.3 % off.
TEST(AirMass, IsTheSecantForAHighSun) {
  for (double z_deg = 0.0; z_deg <= 60.0; z_deg += 5.0) {
    const double secant = 1.0 / std::cos(RadFromDeg(z_deg));
    EXPECT_NEAR(AirMass(RadFromDeg(z_deg)) / secant, 1.0, 0.003);
  }
}

}  // namespace
}  // namespace relight
