// SPDX-License-Identifier: Apache-2.0
#pragma once

// The open sky of photos, and the turbidity of the air that it tells.
//
// For the turbidity each photo is looked at in blocks of 1/50 of its longer side, column
// by column from the top down. A block is sky when no tree is in it, its pixels are alike
// (2 % in the logarithm of luminance, beside noise) and neither black nor at the photo's
// limit, and it goes on from the last one above it: by less than 12 % in each channel's
// logarithm, a tree between them or not. The first other block ends the column: roofs,
// hills, clouds.

#include "relight/base/progress.h"
#include "relight/cameras/camera.h"
#include "relight/capture/stage_records.h"
#include "relight/capture/view_plan.h"
#include "relight/sky/sky_turbidity.h"

#include <opencv2/core.hpp>

#include <vector>

namespace relight {

// `pixels` linear, `alpha` the tree's, of one size; `sun_in_world` when it was taken.
std::vector<SkySample> SkySamples(const cv::Mat3f& pixels,
                                  const cv::Mat1f& alpha,
                                  const Camera& camera,
                                  const Eigen::Vector3d& sun_in_world,
                                  int photo);

// Where each column's sky ends, as a row from the top; 0 where it shows none. By what the
// matte knows of the sky (matting/sky_behind.h), going down through sky and tree; what
// ends behind the tree goes on as beside it. No more than 2 % of the rows in between may
// be neither, for wires and the like. All of `pixels.cols` columns, in rows of `pixels`.
// Throws Cancelled.
cv::Mat1f SkyEnds(const cv::Mat3f& pixels,
                  const cv::Mat1f& alpha,
                  const Progress& progress = {});

// From up to six photos of a capture that have a camera and a matte, spread evenly over
// them, each under the sun of its own time. What it tells is kept in cache/sky.json.
// Throws Cancelled, InputError for a photo that cannot be read.
TurbidityEstimate TurbidityOfCapture(const ViewPlan& plan,
                                     const std::map<std::string, Camera>& cameras,
                                     StageRecords& records);

}  // namespace relight
