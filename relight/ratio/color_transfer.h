// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colour transfer: a picture given the colour statistics of another, the same map for
// every pixel. What relighting is measured against: it knows the colours of the hour that
// is wanted, and not where the sun stands.
//
//   [Reinhard01] docs/bibliography.md#reinhard01   means and deviations in l-alpha-beta
//   [Pitie07]    docs/bibliography.md#pitie07      the linear map of least displacement
//
// With m, s and Sigma the mean, the deviation per channel and the covariance of the
// colours inside a mask, of source (s) and target (t):
//
//   y(c) = s_t(c) / s_s(c) (x(c) - m_s(c)) + m_t(c),   c of l-alpha-beta          (E5)
//   y = T (x - m_s) + m_t,
//   T = Sigma_s^(-1/2) (Sigma_s^(1/2) Sigma_t Sigma_s^(1/2))^(1/2) Sigma_s^(-1/2)  (E6)
//
// l-alpha-beta is a rotation of log10 of cone responses [Reinhard01]; (E6) is computed in
// linear Rec.709, as the scores are. Colours in and out are linear and straight.

#include <opencv2/core.hpp>

namespace relight {

// (E5). Departs from [Reinhard01]: cone responses are floored at 1e-4 of their mean over
// the mask, for the logarithm of black has no bound. A channel that is constant in the
// source is moved to the target's mean and not stretched. Outside of `inside` the result
// is the source. Throws InputError for sizes that differ and an empty mask.
cv::Mat3d ReinhardTransfer(const cv::Mat3d& source,
                           const cv::Mat3d& target,
                           const cv::Mat1b& inside);

// (E6). Variances of the source below 1e-12 of its largest are not stretched. The same
// mask and errors.
cv::Mat3d MongeKantorovichTransfer(const cv::Mat3d& source,
                                   const cv::Mat3d& target,
                                   const cv::Mat1b& inside);

}  // namespace relight
