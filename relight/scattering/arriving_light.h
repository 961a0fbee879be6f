// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light that arrives at each voxel of the tree at one moment, per channel: the brackets
// of
//
//   L_ss(u) = S tau(u, w_sun) + integral of L_sky(w) tau(u, w) dw     [Cabral11, Eq. 8]
//
// with S the sun's irradiance on a plane facing it, and the sky's integral as a product
// of spherical-harmonic coefficients,
//
//   sum_lm L_lm c_lm(u)                                              [Cabral11, Eq. 17]
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
//
// Departs from it once more on demand: leaves in clumps leave more gaps than as many
// leaves at random. A way of the optical depth D, for sun and sky alike, then transmits
//
//   tau = (1 + k D)^(-1 / k)                                                     (S9)
//
// the mean of exp(-g D) over densities g of mean 1 and variance k. Of the sun's disc, of
// the disc's mean.

#include "relight/base/field.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/sh/projection.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace relight {

// One value per non-empty voxel, in the order of FindOccupied; in the unit of the
// Daylight.
struct ArrivingLight {
  std::vector<Eigen::Array3f> sun;
  std::vector<Eigen::Array3f> sky;
  // From the ground (ground_bounce.h) and from leaf to leaf (multiple_scattering.h); 0
  // but for these.
  std::vector<Eigen::Array3f> indirect;

  Eigen::Array3f Total(std::size_t voxel) const {
    return sun[voxel] + sky[voxel] + indirect[voxel];
  }
};

struct ArrivingLightOptions {
  int sun_directions = 1;  // n of (S2); 1: to the sun's centre, as [Cabral11].
  double own_shade = 1.0;  // a of (S3); 1: all of it, as [Cabral11].
  double clumping = 0.0;   // k of (S9); 0: leaves at random, as [Cabral11].

  // No part of LightArriving, for they need the eye, the ground or the light itself; all
  // off as in [Cabral11].
  double gap_length_m = 0.0;                     // l of (S4), hot_spot.h.
  std::optional<double> leaf_transmission = {};  // t of (S11), leaf_phase.h.
  double multiple_scattering = 0.0;              // a of (S12), multiple_scattering.h.
  bool bounce = false;                           // ground_bounce.h

  bool operator==(const ArrivingLightOptions&) const = default;
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
  field(o.clumping,
        FieldInfo{"clumping",
                  "",
                  "how far leaves stand in clumps that let more light through; 0 for "
                  "leaves at random",
                  Between(0, 4)});
  field(o.leaf_transmission,
        FieldInfo{"leaf-transmission",
                  "",
                  "of the light that a leaf scatters, the share that goes through it; "
                  "left out, leaves scatter evenly to all sides",
                  Between(0, 1)});
  field(o.multiple_scattering,
        FieldInfo{"multiple-scattering",
                  "",
                  "share of green light that a leaf scatters on to other leaves, some "
                  "0.3; 0 for none",
                  Between(0, 0.95)});
  field(o.bounce,
        FieldInfo{"bounce",
                  "",
                  "light that the ground sends up into the tree, of --ground-albedo"});
}

// (S9), or exp(-depth) for k = 0.
double TransmittanceOfDepth(double depth, double clumping);

// tau(u, w_sun) for each non-empty voxel, as (S2), (S3), (S9) say, behind `occluder`
// where given: by the mean of its T over the same directions. Throws OptionError.
std::vector<float> SunTransmittance(const ExtinctionGrid& grid,
                                    const OccupiedVoxels& occupied,
                                    const Eigen::Vector3d& sun_direction,
                                    const ArrivingLightOptions& options = {},
                                    const Occluder* occluder = nullptr);

// The sky's light at each voxel, floored at 0: a few bands may overshoot in the darkest
// voxels. `sky` has the bands of the transmittance.
std::vector<Eigen::Array3f> SkyLight(const SkyTransmittance& sky_transmittance,
                                     const ShCoefficients& sky);

// What an occluder and clumps change of the sky is in `sky_transmittance`.
// Throws OptionError.
ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight,
                            const ArrivingLightOptions& options = {},
                            const Occluder* occluder = nullptr);

}  // namespace relight
