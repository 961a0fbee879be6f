// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the simulation of light leaves, learned from rendered trees whose other hours are
// known: the logarithm of true over simulated ratio at low frequency, predicted from what
// the stages already know of each patch of the crown (correction_features.h).
//
//   c(x) = t (clip(B tanh((n(f(x)) - n_0) / B) (1 - exp(-(gamma / gamma_0)^2)) + l)) (R3)
//
// n       mean of a few perceptrons (tanh), of the features clipped to what was trained
// on n_0     its mean over the crown, by the brightness that the simulation gives it:
// where
//         the light is, the perceptrons tell; how much of it in all, only l
// B       0.7; clip keeps the sum within +-B: the ratio changes by a factor of 2 at most
// gamma   angle between the suns of the two hours, gamma_0 = 10 degrees: equal hours give
//         the ratio 1 exactly, and nearby hours nearly so
// t       how far the features are known: with z the sum over them of the square of what
//         each lies beyond the trained range, in widths of that range,
//         t = exp(-4 z)                                                            (R4)
// l       of the whole picture, odd in the two hours; with e the sun's elevation and a
// its
//         azimuth from where the camera looks,
//         l = sum of b_k (q_k(target) - q_k(input)),
//         q = (cos e cos a, sin e, cos e cos^2 a)                                  (R5)
//         (leaves lit from behind the camera are brighter than leaves against the sun)
//
// c is one number for all channels, so that greys stay grey. The weights are a text file
// that relight/ratio/training makes.

#include "relight/base/field.h"
#include "relight/ratio/correction_features.h"

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <filesystem>
#include <vector>

namespace relight {

struct CorrectionOptions {
  bool no_correction = false;
};

template <class Visitor>
void Describe(CorrectionOptions& o, Visitor&& field) {
  field(o.no_correction,
        FieldInfo{"no-correction",
                  "",
                  "the simulation of light alone, without what was learned from trees"});
}

struct CorrectionModel {
  struct Layer {
    Eigen::MatrixXf weights;  // Outputs x inputs.
    Eigen::VectorXf bias;
  };
  // Per feature, in the order of CorrectionFeatureNames(): range that was trained on,
  // mean and standard deviation inside it.
  Eigen::VectorXf low, high, mean, deviation;
  Eigen::Vector3f level = Eigen::Vector3f::Zero();  // b_k of (R5).
  std::vector<std::vector<Layer>> members;
};

// Reads the shipped weights, or a file of the same format. Throws InputError when the
// file is missing, damaged, of other features or another version.
CorrectionModel ReadCorrectionModel();
CorrectionModel ReadCorrectionModel(const std::filesystem::path& file);

struct Correction {
  PatchGrid grid;
  cv::Mat1f log_factor;     // c of (R3), rows x columns of the grid.
  cv::Mat1f trust;          // t of (R4), in [0, 1].
  cv::Mat1f spread;         // Standard deviation of the perceptrons' answers.
  double mean_trust = 1.0;  // Of the tree: patches count by their cover.
};

// `sun_angle_rad`: gamma. Without patches the answer has none, and changes nothing.
// Throws InputError for weights of other features than `features` has.
Correction PredictCorrection(const CorrectionModel& model,
                             const CorrectionFeatures& features,
                             double sun_angle_rad);

// 1 - exp(-(gamma / gamma_0)^2) of (R3), in [0, 1]; exactly 0 for equal suns.
float HourFade(double sun_angle_rad);

// One of the correction's images for rows [row_begin, row_end) of a picture `width` wide,
// bilinear between the patches' centres and constant beyond the outermost.
cv::Mat1f PatchRows(
    const PatchGrid& grid, const cv::Mat1f& image, int width, int row_begin, int row_end);

}  // namespace relight
