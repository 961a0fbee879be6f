// SPDX-License-Identifier: Apache-2.0
#pragma once

// One view of a volume, made ready for many hours: what does not change with the light.
//
//   g_lm(x) = integral of tau(u, x) sigma(u) c_lm(u) du          [Cabral11, Eqs. 15, 16]
//
// with c_lm of (S1), so that the sky's part of a pixel is one product of coefficients,
//
//   E_sky(x) = sum_lm L_lm g_lm(x)                                   [Cabral11, Eq. 17]
//
// and the sun's part a sum over the voxels of the pixel's ray, whose shares are kept,
//
//   E_sun(x) = S sum over voxels of share(x, u) tau(u, w_sun)                      (S7)
//
// The same images as SingleScattering's, but for half floats.

#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/sh/projection.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace relight {

struct ViewTransport {
  static constexpr std::size_t kBlock = 64;  // Pixels whose g_lm lie together.

  cv::Size size;
  int bands = 0;
  std::vector<std::int32_t> pixel;   // row * width + column of those that meet volume.
  std::vector<float> weight;         // Of each: 1 - tau of its whole ray.
  std::vector<std::uint16_t> sky;    // Half floats, [block][bands^2][pixel of the block].
  std::vector<std::size_t> ray;      // Pixel p's voxels are [ray[p], ray[p + 1]) of:
  std::vector<std::int32_t> voxel;   // their numbers among the occupied, front to back,
  std::vector<std::uint16_t> share;  // and shares, as half floats.
};

// Pixels where `mask` (empty: all) is 0 are left out. Throws Cancelled.
ViewTransport MakeViewTransport(const ExtinctionGrid& grid,
                                const OccupiedVoxels& occupied,
                                const SkyTransmittance& sky_transmittance,
                                const Camera& camera,
                                const cv::Mat1b& mask = {},
                                const Progress& progress = {});

// The sky's part of the image, at least 0; `sky` has the bands of `view` at least.
cv::Mat3f SkyImage(const ViewTransport& view, const ShCoefficients& sky);

// The sun's part of the image, from tau(u, w_sun) of each non-empty voxel.
cv::Mat3f SunImage(const ViewTransport& view,
                   std::span<const float> sun_transmittance,
                   const Eigen::Array3d& sun_irradiance);

}  // namespace relight
