// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a tree leaves of the light on level ground: a colour to multiply the ground with,
// 1 where there is no shadow, per channel.
//
// At a point p of the plane z = ground_z_m, with S the sun's irradiance on a plane that
// faces it, L the sky's radiance and tau the transmittance of the volume,
//
//   s(p) = E_with(p) / E_without = q T(p) + (1 - q) V(p)                        (G7)
//   q    = S sin(e) / (S sin(e) + k E_h),   e the sun's elevation               (G8)
//   T(p) = mean of tau(p, w) over the sun's disc                                (G9)
//   V(p) = sum_i L(w_i) tau(p, w_i) / sum_i L(w_i)                              (G10)
//
// E_h is the sky's irradiance on the ground (relight/sh/sky_coefficients.h), and the w_i
// are spread with the density of the cosine. Sun and sky part in colour, so a shadow of
// the sun takes the sky's blue. The disc makes the shadow of a high twig softer than that
// of the trunk's foot.
//
// k is how much of the sky's light counts. [Preetham99]'s sky is too bright beside its
// sun: at turbidity 3 it gives 39 % of the light on the ground under a sun 35 degrees
// high and 28 % at 70 degrees, where the clear sky of the Illuminating Engineering
// Society (0.8 + 15.5 sqrt(sin e) klx, sun 127.5 exp(-0.21 / sin e) klx) has 20 % and 14
// %: k = 0.4. And of the sky that the tree hides, the tree's own light gives a part back,
// which is left out here. Rendered ground under a tree shows k = 0.2 to 0.35.

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/scattering/occluder.h"
#include "relight/sky/daylight.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace relight {

// Seen from the Earth, on the mean over a year.
inline constexpr double kSunDiameter_deg = 0.533;

struct GroundShadowOptions {
  double ground_z_m = 0.0;   // Of the level ground; the tree's foot is near 0.
  int sky_directions = 256;  // Of (G10).
  double sky_level = 0.3;    // k of (G8).
};

template <class Visitor>
void Describe(GroundShadowOptions& o, Visitor&& field) {
  field(o.ground_z_m, FieldInfo{"ground", "m", "height of the level ground"});
  field(o.sky_directions,
        FieldInfo{"shadow-directions",
                  "",
                  "directions of the sky that a shadow is gathered from",
                  Between(16, 4096)});
  field(o.sky_level,
        FieldInfo{"shadow-sky",
                  "",
                  "how much of the sky's light counts in a shadow; less is darker",
                  Between(0.01, 10)});
}

// Values on a rectangle of the ground; texel (0, 0) has its corner at `corner_m`, rows
// run along y. Outside, the value is 1.
struct GroundMap {
  Eigen::Vector2d corner_m = {0, 0};  // ENU.
  double texel_m = 1.0;
  cv::Mat values;  // CV_32FC1 or CV_32FC3; may be empty.
};

// The shadow on the ground, before any camera.
struct GroundShadow {
  double ground_z_m = 0.0;
  Eigen::Array3f sun_share = Eigen::Array3f::Zero();  // q of (G8), in [0, 1].
  GroundMap sun;                                      // T of (G9), one channel.
  GroundMap sky;                                      // V of (G10), RGB.

  // s of (G7) at a point of the ground, in [0, 1].
  cv::Vec3f At(const Eigen::Vector2d& ground_m) const;
};

// The sky's part ends where the sky that the tree hides is less than 1/255 of all light;
// it goes to 1 there without a step. Voxels below the ground cast no shadow. Where an
// `occluder` hides the sun from the ground, the tree takes none from it: T of (G9) is 1 -
// T_o (1 - T), T_o the occluder's; of the sky both have their own part. Throws
// OptionError, Cancelled. The result does not depend on the threads.
GroundShadow MakeGroundShadow(const ExtinctionGrid& grid,
                              const Daylight& daylight,
                              const GroundShadowOptions& options = {},
                              const Progress& progress = {},
                              const Occluder* occluder = nullptr);

// s of (G7) in the rows row_begin … row_end - 1 of the camera, the mean over each pixel;
// 1 where a ray does not meet the ground. RGB, linear, in [0, 1].
cv::Mat3f ShadowRows(const GroundShadow& shadow,
                     const Camera& camera,
                     int row_begin,
                     int row_end);

// All rows.
cv::Mat3f ShadowImage(const GroundShadow& shadow,
                      const Camera& camera,
                      const Progress& progress = {});

// The share of the camera's pixels whose rays meet the ground.
double GroundShare(const Camera& camera, double ground_z_m);

}  // namespace relight
