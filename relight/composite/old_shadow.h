// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ground of a photo taken from the tree's shadow of one hour to that of another, so
// that no picture shows two shadows. Approximate: all that is outside the matte and below
// the horizon is taken as level ground.
//
// With i and t the shadows of input and target (ground_shadow.h), per channel,
//
//   r = (t + e) / (i + e),   e = i max(0, f / Y(i) - 1), Y luminance            (G4)
//
// so that the input's shadow counts as f = 0.2 where it is deeper, in its own colour, and
// equal shadows leave the photo as it is. A pixel that is partly tree,
// I = a F + (1 - a) B, changes by its ground alone:
//
//   I' = I + (r - 1) max(0, I - a F)                                           (G5)
//
// i as the volume has it is a mean: it knows how much sun comes through the crown, but
// not through which gap, and the ground divided by it keeps the old flecks of sun. The
// photo shows them. With B the ground's luminance blended inwards from where there is no
// shadow, and i = d + T (l - d), d all shade and l full sun, the sun's part that a pixel
// shows is
//
//   T' = clamp(((I / B - d) / (l - d) - u) / (v - u), 0, 1),  u = 0.05, v = 0.85  (G6)
//
// taken in place of T where the volume casts a shadow near by: what is nearly all shade,
// or nearly full sun, counts as such and keeps its texture. For suns g apart it counts by
// 1 - exp(-(g / 1 deg)^2), so that the same hour gives the same photo.

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/composite/ground_shadow.h"

#include <opencv2/core.hpp>

namespace relight {

struct OldShadowOptions {
  double floor = 0.2;        // f of (G4).
  bool volume_only = false;  // No flecks of (G6): i is the volume's own.
};

template <class Visitor>
void Describe(OldShadowOptions& o, Visitor&& field) {
  field(o.floor,
        FieldInfo{"old-shadow-floor",
                  "",
                  "the photo's own shadow counts as this where it is deeper",
                  Between(0.01, 1)});
  field(
      o.volume_only,
      FieldInfo{"old-shadow-plain",
                "",
                "the photo's own shadow by the volume alone, not by its flecks of sun"});
}

// The tree's shadow in the photo, RGB in [0, 1]: what divides it away is
// cast + flecks (seen - cast), with `flecks` in [0, 1] how much (G6) counts.
struct PhotoShadow {
  cv::Mat3f cast;  // By the volume.
  cv::Mat3f seen;  // By (G6).
};

// `photo` is linear, `alpha` the tree's matte and whatever else is no ground, both of the
// camera's size. With `volume_only`, and where the sun casts no shadow, `seen` is `cast`.
// Throws Cancelled.
PhotoShadow ShadowInPhoto(const cv::Mat3f& photo,
                          const cv::Mat1f& alpha,
                          const GroundShadow& input,
                          const Camera& camera,
                          const OldShadowOptions& options = {},
                          const Progress& progress = {});

// r of (G4); `sun_turn_rad` is the angle between the two suns. 1 where there is no
// ground. Throws OptionError, Cancelled.
cv::Mat3f GroundRatio(const PhotoShadow& input,
                      const GroundShadow& target,
                      const Camera& camera,
                      double sun_turn_rad,
                      const OldShadowOptions& options = {},
                      const Progress& progress = {});

// I' of (G5), with F the tree's own colours, straight. The tree is as it was.
cv::Mat3f ReshadowedPhoto(const cv::Mat3f& photo,
                          const cv::Mat1f& alpha,
                          const cv::Mat3f& foreground,
                          const cv::Mat3f& ratio);

}  // namespace relight
