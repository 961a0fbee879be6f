// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/color_transfer.h"

#include "relight/base/error.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <vector>

namespace relight {
namespace {

using Colors = std::vector<Eigen::Vector3d>;

Colors Gather(const cv::Mat3d& image, const cv::Mat1b& inside) {
  Colors colors;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (inside(y, x) != 0)
        colors.emplace_back(image(y, x)[0], image(y, x)[1], image(y, x)[2]);
    }
  }
  return colors;
}

cv::Mat3d Scatter(const Colors& colors,
                  const cv::Mat3d& source,
                  const cv::Mat1b& inside) {
  cv::Mat3d image = source.clone();
  std::size_t next = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (inside(y, x) == 0) continue;
      const Eigen::Vector3d& color = colors[next++];
      image(y, x) = {color[0], color[1], color[2]};
    }
  }
  return image;
}

Eigen::Vector3d MeanOf(const Colors& colors) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& color : colors) sum += color;
  return sum / double(colors.size());
}

Eigen::Matrix3d CovarianceOf(const Colors& colors, const Eigen::Vector3d& mean) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& color : colors)
    sum += (color - mean) * (color - mean).transpose();
  return sum / double(colors.size());
}

void Check(const cv::Mat3d& source, const cv::Mat3d& target, const cv::Mat1b& inside) {
  if (source.size() != target.size() || source.size() != inside.size()) {
    throw InputError("colour transfer needs source, target and mask of one size");
  }
  if (cv::countNonZero(inside) == 0) {
    throw InputError("colour transfer needs a pixel inside the mask");
  }
}

// Cone responses of linear RGB, and l-alpha-beta of their logarithms. [Reinhard01]
Eigen::Matrix3d ConesFromRgb() {
  Eigen::Matrix3d m;
  m << 0.3811, 0.5783, 0.0402, 0.1967, 0.7244, 0.0782, 0.0241, 0.1288, 0.8444;
  return m;
}

Eigen::Matrix3d OpponentFromLogCones() {
  Eigen::Matrix3d m;
  m << 1.0, 1.0, 1.0, 1.0, 1.0, -2.0, 1.0, -1.0, 0.0;
  const Eigen::Vector3d scale(
      1.0 / std::sqrt(3.0), 1.0 / std::sqrt(6.0), 1.0 / std::sqrt(2.0));
  return scale.asDiagonal() * m;
}

void ToOpponent(Colors& colors) {
  const Eigen::Matrix3d cones = ConesFromRgb(), opponent = OpponentFromLogCones();
  for (Eigen::Vector3d& color : colors) color = cones * color;
  const Eigen::Array3d floor = (1e-4 * MeanOf(colors)).array().max(1e-12);
  for (Eigen::Vector3d& color : colors) {
    const Eigen::Vector3d logarithm = color.array().max(floor).log10();
    color = opponent * logarithm;
  }
}

// f(Sigma) of a symmetric matrix, by its eigenvalues; below `floor` 0.
template <class Function>
Eigen::Matrix3d OfEigenvalues(const Eigen::Matrix3d& sigma,
                              double floor,
                              const Function& f) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sigma);
  Eigen::Vector3d values = solver.eigenvalues();
  for (double& value : values) value = value > floor ? f(value) : 0.0;
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

cv::Mat3d ReinhardTransfer(const cv::Mat3d& source,
                           const cv::Mat3d& target,
                           const cv::Mat1b& inside) {
  Check(source, target, inside);
  Colors colors = Gather(source, inside), wanted = Gather(target, inside);
  ToOpponent(colors);
  ToOpponent(wanted);
  const Eigen::Vector3d mean_s = MeanOf(colors), mean_t = MeanOf(wanted);
  const Eigen::Array3d s_s =
      CovarianceOf(colors, mean_s).diagonal().array().max(0.0).sqrt();
  const Eigen::Array3d s_t =
      CovarianceOf(wanted, mean_t).diagonal().array().max(0.0).sqrt();
  const Eigen::Array3d stretch = (s_s > 1e-9).select(s_t / s_s.max(1e-9), 1.0);

  // y = s_t / s_s (x - m_s) + m_t                                               (E5)
  const Eigen::Matrix3d rgb = ConesFromRgb().inverse();
  const Eigen::Matrix3d log_cones = OpponentFromLogCones().inverse();
  for (Eigen::Vector3d& color : colors) {
    const Eigen::Vector3d moved = stretch * (color - mean_s).array() + mean_t.array();
    const Eigen::Vector3d logarithm = log_cones * moved;
    const Eigen::Vector3d cones = (logarithm.array() * std::log(10.0)).exp();
    color = rgb * cones;
  }
  return Scatter(colors, source, inside);
}

cv::Mat3d MongeKantorovichTransfer(const cv::Mat3d& source,
                                   const cv::Mat3d& target,
                                   const cv::Mat1b& inside) {
  Check(source, target, inside);
  Colors colors = Gather(source, inside);
  const Colors wanted = Gather(target, inside);
  const Eigen::Vector3d mean_s = MeanOf(colors), mean_t = MeanOf(wanted);
  const Eigen::Matrix3d sigma_s = CovarianceOf(colors, mean_s);
  const Eigen::Matrix3d sigma_t = CovarianceOf(wanted, mean_t);

  // T = S^(-1/2) (S^(1/2) Sigma_t S^(1/2))^(1/2) S^(-1/2), S = Sigma_s          (E6)
  const double floor = 1e-12 * sigma_s.trace();
  const Eigen::Matrix3d root =
      OfEigenvalues(sigma_s, floor, [](double v) { return std::sqrt(v); });
  const Eigen::Matrix3d inverse_root =
      OfEigenvalues(sigma_s, floor, [](double v) { return 1.0 / std::sqrt(v); });
  const Eigen::Matrix3d middle =
      OfEigenvalues(root * sigma_t * root, 0.0, [](double v) { return std::sqrt(v); });
  const Eigen::Matrix3d map = inverse_root * middle * inverse_root;
  for (Eigen::Vector3d& color : colors) color = map * (color - mean_s) + mean_t;
  return Scatter(colors, source, inside);
}

}  // namespace relight
