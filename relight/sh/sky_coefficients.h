// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sky of one moment in spherical harmonics, and its light on level ground.
//
//   [Cabral11] docs/bibliography.md#cabral11
//
//   L_lm = integral over the sphere of L_sky(omega) Y_lm(omega) d omega           (H7)
//   E_h  = integral over the sphere of L_sky(omega) max(0, omega_z) d omega       (H8)
//
// L_sky is zero below the horizon; the sun is not in it.

#include "relight/sh/projection.h"
#include "relight/sky/daylight.h"

#include <Eigen/Core>

#include <functional>

namespace relight {

// [cd/m2 sr^1/2] per channel; bands^2 rows. With `weight`: of L_sky(omega)
// weight(omega).
ShCoefficients SkyCoefficients(
    const Daylight& daylight,
    int bands = kSkyBands,
    const std::function<double(const Eigen::Vector3d&)>& weight = {});

// [lx] per channel, of the sky alone.
Eigen::Array3d HorizontalSkyIrradiance(const Daylight& daylight);

}  // namespace relight
