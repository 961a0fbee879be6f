// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the importers of different formats make a camera from: a pose given as a matrix,
// the size of a photo, the view that a file's name means, and radial distortion of a
// degree that (C1) does not have.

#include "relight/cameras/calibrated_scene.h"

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace relight {

// What a term that a camera cannot hold may move in the frame before it is refused.
inline constexpr double kIgnoredShift_px = 0.01;

// The pose of a camera at `position` whose axes in the world are the columns of
// `world_from_camera`, all as long as each other. Nothing when that is no rotation.
std::optional<Eigen::Isometry3d> PoseFromAxes(const Eigen::Matrix3d& world_from_camera,
                                              const Eigen::Vector3d& position);

// A photo's width or height; nothing when no photo is that large or small.
std::optional<int> SizeFrom(double pixels);

// The view of an image's file name, whatever system wrote it: without folders and,
// unless a photo has the name as it stands, without extension.
std::string ViewOfImage(std::string_view name, const PhotoSizes& photos);

// Cameras of photos that are not at hand, in a format that needs their sizes.
enum class UnknownPhotos { kRefuse, kLeaveOut };

// The size of the view's photo. When it is not known: nothing if these are left out, else
// throws InputError that names `file` and the photo to add.
std::optional<PhotoSize> SizeOfView(const std::string& view,
                                    const PhotoSizes& photos,
                                    UnknownPhotos unknown,
                                    const std::string& file);

// The camera of the same photo turned clockwise by a quarter, for formats that know the
// photo as it lies in its file (EXIF's orientation). A point at (u, v) comes to (h - v,
// u).
Camera QuarterTurned(const Camera& camera);

// The distance from the centre to the farthest corner, on the plane z = 1 as distorted.
double CornerRadius(const Camera& camera);

// Replaces the radial part of the lens by the polynomial of degree four of Metashape,
// RealityCapture and nerfstudio, k[0..3] for r^2, r^4, r^6, r^8:
//
//   q = 1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8
//
// (C1) has no r^8, but its quotient of two polynomials of degree three comes near enough
// for each lens that a photo can show. The quotient is fitted over the frame, and answers
// whether it agrees with q there within kIgnoredShift_px.
bool SetRadialPolynomial(Camera& camera, const std::array<double, 4>& k);

}  // namespace relight
