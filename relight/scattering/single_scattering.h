// SPDX-License-Identifier: Apache-2.0
#pragma once

// The image of the volume under one or more lights, by single scattering of unit phase
// function along each pixel's view ray:
//
//   E(x) = integral of tau(u, x) sigma(u) L(u) du              [Cabral11, Eqs. 7, 9, 13]
//
// with extinction and light constant in each voxel, where the integral is exact:
// a voxel of optical depth d behind tau adds tau (1 - exp(-d)) L.

#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/scattering/arriving_light.h"
#include "relight/volume/extinction_grid.h"

#include <opencv2/core.hpp>

#include <span>
#include <vector>

namespace relight {

// All height x width of the camera; in the Daylight's unit, not divided by `weight`.
struct IrradianceImage {
  cv::Mat3f sun, sky, indirect;
  cv::Mat3f Total() const { return sun + sky + indirect; }
};

struct ScatteringImages {
  cv::Mat1f weight;                     // Sum of tau sigma du = 1 - tau of the whole ray.
  std::vector<IrradianceImage> lights;  // One per light given.
};

// Pixels where `mask` (empty: all) is 0 are left 0. All lights are gathered on one way
// along each ray, so that equal lights give equal images to the last bit. Throws
// Cancelled.
ScatteringImages SingleScattering(const ExtinctionGrid& grid,
                                  const OccupiedVoxels& occupied,
                                  std::span<const ArrivingLight> lights,
                                  const Camera& camera,
                                  const cv::Mat1b& mask = {},
                                  const Progress& progress = {});

}  // namespace relight
