// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that arrives at each voxel of the tree at one moment, per channel: the brackets
// of
//
//   L_ss(u) = S tau(u, w_sun) + integral of L_sky(w) tau(u, w) dw         [Cabral11, Eq.
//   8]
//
// with S the sun's irradiance on a plane facing it, and the sky's integral as a product
// of spherical-harmonic coefficients, sum_lm L_lm c_lm(u)                    [Cabral11,
// Eq. 17]
//
// The sun is a point there. Departs from [Cabral11, Eq. 8] on demand: as the disc that it
// is, of radius rho, tau(u, w_sun) is the mean over n directions spread over it,
//
//   w_i = unit(w_sun + tan(rho) sqrt((i + 1/2) / n) (cos(i g) a + sin(i g) b))   (S2)
//
// with g = pi (3 - sqrt 5) and a, b across w_sun. Light at a voxel's centre then changes
// more evenly while the rays go over from voxel to voxel: in a minute the sun moves by
// half its width. On a rendered tree it lowers the mean change of the ratio in a minute
// at 13:00 from 1.5 to 1.2 %, and moves the sun's light by 0.3 to 0.8 %.
//
// Departs from [Cabral11, Eq. 6] on demand: a leaf does not stand in its own light. The
// sun's way begins where it leaves the voxel, after the half edge r / 2 of the voxel's
// own extinction, r = cell / max |w_i|; of that a share a is left:
//
//   tau(u, w_sun)' = tau(u, w_sun) exp((1 - a) sigma(u) r / 2)                   (S3)

#include "relight/base/field.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <vector>

namespace relight {

// One value per non-empty voxel, in the order of FindOccupied; in the unit of the
// Daylight.
struct ArrivingLight {
  std::vector<Eigen::Array3f> sun;
  std::vector<Eigen::Array3f> sky;
  std::vector<Eigen::Array3f> indirect;  // From the ground (ground_bounce.h); else 0.
};

struct ArrivingLightOptions {
  int sun_directions = 1;  // n of (S2); 1: to the sun's centre, as [Cabral11].
  double own_shade = 1.0;  // a of (S3); 1: all of it, as [Cabral11].
  // l of (S4), hot_spot.h, which needs the eye: no part of LightArriving. 0: points, as
  // [Cabral11].
  double gap_length_m = 0.0;
};

template <class Visitor>
void Describe(ArrivingLightOptions& o, Visitor&& field) {
  field(o.sun_directions,
        FieldInfo{"sun-directions",
                  "",
                  "directions over the sun's disc; 1 for its centre alone",
                  Between(1, 1024)});
  field(o.own_shade,
        FieldInfo{"own-shade",
                  "",
                  "share of a voxel's own extinction that shades its leaves from the sun",
                  Between(0, 1)});
  field(o.gap_length_m,
        FieldInfo{"gap-length",
                  "m",
                  "length over which gaps between leaves hang together, some 0.4 of "
                  "a leaf's width: what is seen from near the sun's direction is lit",
                  Between(0, 1)});
}

// tau(u, w_sun) for each non-empty voxel, as (S2) and (S3) say, behind `occluder` where
// given: by the mean of its T over the same directions. Throws OptionError.
std::vector<float> SunTransmittance(const ExtinctionGrid& grid,
                                    const OccupiedVoxels& occupied,
                                    const Eigen::Vector3d& sun_direction,
                                    const ArrivingLightOptions& options = {},
                                    const Occluder* occluder = nullptr);

// The sky's light is floored at 0: a few bands may overshoot in the darkest voxels. What
// an occluder takes of it is in `sky_transmittance`.
// Throws OptionError.
ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight,
                            const ArrivingLightOptions& options = {},
                            const Occluder* occluder = nullptr);

}  // namespace relight
