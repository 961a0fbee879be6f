// SPDX-License-Identifier: Apache-2.0
#pragma once

// The camera of one photo: from what EXIF and the user know of its lens, its horizon, its
// heading and its height, or from points whose places on Earth are known; and how each
// was known, in words. It is kept beside the photo, in STEM_camera/, as a COLMAP model
// with an overlay to look at (relight/capture/camera_overlay.h).
//
// Its world is ENU (docs/conventions.md#world) with the ground at z = 0. The origin is
// the tree's foot when that is given, else point 1, else the ground below the camera.

#include "relight/capture/camera_overlay.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/photo_facts.h"
#include "relight/sky/solar_position.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// As on the command line.
struct OnePhotoRequest {
  std::filesystem::path photo = {};
  std::optional<double> focal_35mm_mm = {};    // Else EXIF's, else a phone's.
  std::optional<std::string> horizon = {};     // "Y" or "X1,Y1,X2,Y2" [px].
  std::optional<std::string> heading = {};     // "DEG" or "SW".
  std::optional<double> camera_height_m = {};  // Above the ground; else kEyeHeight_m.
  std::vector<std::string> points = {};  // "X,Y=LAT,LON[,H]"; four or more: all of it.
  std::optional<std::string> foot = {};  // "X,Y" [px] of the trunk.
  std::optional<std::string> place = {}, zone = {}, taken = {};
};

// The sun of the photo's moment.
struct PhotoSun {
  LocalTime time;
  SolarPosition position;
  Eigen::Vector3d in_camera;          // Unit vector in camera axes.
  double azimuth_from_ahead_rad = 0;  // To the right of the camera's heading, [-pi, pi).
};

struct OnePhotoCamera {
  Camera camera;
  double focal_35mm_mm = 0.0;
  double heading_deg = 0.0, pitch_deg = 0.0;
  double roll_deg = 0.0;  // Clockwise as seen from behind the camera.
  double height_m = 0.0;  // Above the ground.
  std::string focal_from, tilt_from, heading_from, height_from;  // In words.
  std::optional<Place> origin;  // Of the world, when known.
  std::string origin_is;        // "the ground below the camera".

  std::vector<double> point_residual_px;  // Of the points, in their order.
  double position_error_m = 0.0;          // Of a pose from points; 0: not known.
  std::optional<Eigen::Vector3d> foot_in_world;
  std::optional<PhotoSun> sun;
  std::vector<std::string> notes;
};

// `display_rgb` are the photo's pixels, looked at for upright lines only. Throws
// OptionError for texts that cannot be read or do not go together; InputError for what is
// missing, with the option that gives it, and as FindPose does.
OnePhotoCamera FindOnePhotoCamera(const OnePhotoRequest& request,
                                  const PhotoFacts& facts,
                                  const cv::Mat3b& display_rgb);

// Draws the photo's overlay.
cv::Mat3b OverlayOf(const OnePhotoCamera& found, const cv::Mat3b& display_rgb);

// STEM_camera/ beside the photo.
std::filesystem::path CameraFolderOf(const std::filesystem::path& photo);

// Writes cameras.txt, images.txt, points3D.txt and overlay.jpg into `folder`, which is
// made. Throws InputError when one of them is the photo, or the folder holds the cameras
// of other photos.
void WriteOnePhotoCamera(const std::filesystem::path& folder,
                         const std::filesystem::path& photo,
                         const OnePhotoCamera& found,
                         const cv::Mat3b& overlay);

// The camera in CameraFolderOf(photo) at the size given; nothing when there is none.
// Throws InputError: it is of another shape, or cannot be read; with the remedy.
std::optional<Camera> CameraBeside(const std::filesystem::path& photo,
                                   int width_px,
                                   int height_px);

}  // namespace relight
