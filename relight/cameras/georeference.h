// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where on Earth a calibrated scene is: from the frame of the program that made it to ENU
// metres, x_world = s R x + t.
//
// s, R and t agree best with all that is known at once, each clue measured by its own
// error sigma (one standard deviation):
//
//   GPS        east, north and up of each photo's camera                    [m]
//   compass    azimuth of its view; of the picture's upper edge where the camera looks
//              steeply up or down                                           [rad]
//   level      the camera's x axis is level: hardly anybody photographs trees askew [rad]
//   the user   a heading, an up, a distance of two cameras, a shadow on the ground
//
//   minimise  sum_i rho(r_i / sigma_i),   rho Tukey's biweight, c = 4.685    (C7)
//
// It starts from each pair of places and each single compass, all of them: RANSAC without
// chance. Then Gauss-Newton, with the sigmas of GPS and compass scaled to the residuals
// that are found (their stated errors count as four photos). Errors that are reported
// come from the normal matrix at the minimum.

#include "relight/base/field.h"
#include "relight/base/instant.h"
#include "relight/cameras/calibrated_scene.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

// What a photo says of its own camera.
struct CameraClues {
  std::string view;
  std::optional<Place> place = {};
  std::optional<double> heading_rad = {};  // From true north.
};

// A view whose camera is known to look along an azimuth.
struct KnownHeading {
  std::string view;
  double heading_rad = 0.0;
};
// Two views whose cameras are a known distance apart.
struct KnownDistance {
  std::string a, b;
  double length_m = 0.0;
};
// The shadow on the ground of something upright: from its foot to its tip, as pixels of a
// view, when the sun stood at that azimuth.
struct KnownShadow {
  std::string view;
  Eigen::Vector2d foot_px, tip_px;
  double sun_azimuth_rad = 0.0;
};
// What the user says.
struct GivenFrame {
  std::optional<Eigen::Vector3d> up = {};  // In the scene's own frame.
  std::optional<KnownHeading> heading = {};
  std::optional<KnownDistance> distance = {};
  std::optional<KnownShadow> shadow = {};
};

struct GeoreferenceOptions {
  double gps_error_m = 4.0;        // Of a place, along each axis on the ground.
  double compass_error_deg = 8.0;  // Of a heading.
  double level_error_deg = 2.0;    // Of a camera held level.
};

template <class Visitor>
void Describe(GeoreferenceOptions& o, Visitor&& field) {
  field(
      o.gps_error_m,
      FieldInfo{"gps-error", "m", "error of a photo's place, along each axis", Above(0)});
  field(o.compass_error_deg,
        FieldInfo{"compass-error", "deg", "error of a photo's heading", Above(0)});
  field(o.level_error_deg,
        FieldInfo{"level-error", "deg", "how level cameras are held", Above(0)});
}

struct ViewResidual {
  std::string view;
  std::optional<double> gps_m = {};        // From its place to its camera, on the ground.
  std::optional<double> compass_rad = {};  // Compass less camera, in (-pi, pi].
  bool gps_is_outlier = false;
  bool compass_is_outlier = false;
};

struct Georeference {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  std::optional<Place> origin;  // Of the world; unset when no photo has a place.

  // One standard deviation each; the scale's is a share of it.
  double north_error_rad = 0.0, up_error_rad = 0.0, scale_error = 0.0;
  std::string north_from, up_from, scale_from;  // "GPS of 12 photos and 11 compasses".
  bool kept_frame = false;  // The scene was ENU metres already, and agrees.
  std::vector<ViewResidual> residuals;
  std::vector<std::string> notes;

  Eigen::Vector3d ToWorld(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
};

// A scene whose own frame agrees with the clues as well as the best one keeps it (only
// shifted): it is ENU metres already, better known than by GPS. Throws InputError with
// all that is not known (north, scale) and the options that tell it; for a view of
// `given` that is not in the scene.
Georeference FindGeoreference(const CalibratedScene& scene,
                              std::span<const CameraClues> clues,
                              const GivenFrame& given = {},
                              const GeoreferenceOptions& options = {});

// The scene in the world. The origin moves with it.
CalibratedScene InWorld(const CalibratedScene& scene, const Georeference& georeference);

// The same scene with its origin moved to `point` [m, ENU], and the place of it.
CalibratedScene MovedTo(const CalibratedScene& scene, const Eigen::Vector3d& point);

}  // namespace relight
