// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/correction_features.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/sh/sky_coefficients.h"
#include "relight/volume/ray_traversal.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace relight {
namespace {

constexpr int kPatchesInHeight = 40;
constexpr int kMaxPatchesAcross = 160;
constexpr double kFinePatches = 0.8, kWidePatches = 3.0;  // Standard deviations

float Luminance(const cv::Vec3f& c) {
  return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

// Patches over the box of the matte; none when it holds no tree.
PatchGrid PatchesOver(const cv::Mat1f& alpha) {
  const cv::Rect box = cv::boundingRect(cv::Mat1b(alpha > 0.02f));
  PatchGrid patches;
  if (box.empty()) return patches;
  patches.patch_px = std::max({1.0,
                               static_cast<double>(box.height) / kPatchesInHeight,
                               static_cast<double>(box.width) / kMaxPatchesAcross});
  patches.columns = static_cast<int>(std::ceil(box.width / patches.patch_px));
  patches.rows = static_cast<int>(std::ceil(box.height / patches.patch_px));
  patches.left_px = box.x;
  patches.top_px = box.y;
  return patches;
}

cv::Mat1f Blurred(const cv::Mat1f& image, double patches) {
  cv::Mat1f result;
  cv::GaussianBlur(image, result, {}, patches, 0, cv::BORDER_CONSTANT);
  return result;
}

// The means of one size: blurred sums over blurred weights, and a value of the whole
// where there is no weight near.
cv::Mat1f Mean(const cv::Mat1f& sums, const cv::Mat1f& weights, double patches) {
  const double total_weight = cv::sum(weights)[0];
  const auto whole =
      static_cast<float>(total_weight > 0 ? cv::sum(sums)[0] / total_weight : 0);
  const cv::Mat1f blurred_sums = Blurred(sums, patches);
  const cv::Mat1f blurred = Blurred(weights, patches);
  cv::Mat1f mean(sums.size());
  constexpr float kLittle = 1e-3f;
  for (int row = 0; row < mean.rows; ++row) {
    for (int column = 0; column < mean.cols; ++column) {
      mean(row, column) = (blurred_sums(row, column) + kLittle * whole) /
                          (blurred(row, column) + kLittle);
    }
  }
  return mean;
}

cv::Mat1f Log(const cv::Mat1f& image, double smallest) {
  cv::Mat1f result;
  cv::log(cv::max(image, smallest), result);
  return result;
}

// Extinction on at most 48 cells along the longest side, blurred, and its gradient.
class CoarseDensity {
 public:
  CoarseDensity(const ExtinctionGrid& grid, double blur_m) {
    constexpr int kCells = 48;
    const int longest = grid.cells.maxCoeff();
    shrink_ = std::max(1.0, static_cast<double>(longest) / kCells);
    // Room for the blur around the box
    const double blur_cells = blur_m / (grid.cell_m * shrink_);
    margin_ = static_cast<int>(std::ceil(2.5 * blur_cells)) + 2;
    for (int axis = 0; axis < 3; ++axis) {
      size_[axis] = static_cast<int>(std::ceil(grid.cells[axis] / shrink_)) + 2 * margin_;
    }
    values_.assign(static_cast<std::size_t>(size_.prod()), 0.0f);
    const auto share = static_cast<float>(1 / (shrink_ * shrink_ * shrink_));
    ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
      const float sigma = grid.sigma_per_m[index];
      if (sigma > 0) values_[At(Cell(x), Cell(y), Cell(z))] += share * sigma;
    });
    for (int axis = 0; axis < 3; ++axis) BlurAlong(axis, blur_cells);
  }

  // At the voxel (x, y, z) of the grid: density and, away from what is dense, a unit
  // vector (0 where it does not change).
  std::pair<float, Eigen::Vector3f> AtVoxel(const Eigen::Vector3i& voxel) const {
    const Eigen::Vector3d at =
        (voxel.cast<double>().array() + 0.5) / shrink_ + margin_ - 0.5;
    Eigen::Vector3f outward;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = Eigen::Vector3d::Unit(axis);
      outward[axis] = Value(at - step) - Value(at + step);
    }
    const float norm = outward.norm(), value = Value(at);
    if (norm > 1e-6f * (value + 1e-6f)) {
      outward /= norm;
    } else {
      outward.setZero();
    }
    return {value, outward};
  }

 private:
  int Cell(int index) const {
    return static_cast<int>((index + 0.5) / shrink_) + margin_;
  }
  std::size_t At(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size_.x()) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(z));
  }

  float Value(const Eigen::Vector3d& at) const {
    Eigen::Vector3i low;
    Eigen::Vector3f part;
    for (int axis = 0; axis < 3; ++axis) {
      const double inside = std::clamp(at[axis], 0.0, size_[axis] - 1.001);
      low[axis] = static_cast<int>(inside);
      part[axis] = static_cast<float>(inside - low[axis]);
    }
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
      sum += (dx ? part.x() : 1 - part.x()) * (dy ? part.y() : 1 - part.y()) *
             (dz ? part.z() : 1 - part.z()) *
             values_[At(low.x() + dx, low.y() + dy, low.z() + dz)];
    }
    return sum;
  }

  void BlurAlong(int axis, double cells) {
    const int reach = static_cast<int>(std::ceil(2.5 * cells));
    std::vector<float> kernel;
    float total = 0;
    for (int i = -reach; i <= reach; ++i) {
      kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (cells * cells))));
      total += kernel.back();
    }
    const std::vector<float> source = values_;
    const std::array<std::ptrdiff_t, 3> stride = {
        1, size_.x(), static_cast<std::ptrdiff_t>(size_.x()) * size_.y()};
    const std::ptrdiff_t along = stride[static_cast<std::size_t>(axis)];
    ParallelRanges(size_.z(), 4, [&](int begin, int end) {
      for (int z = begin; z < end; ++z) {
        for (int y = 0; y < size_.y(); ++y) {
          for (int x = 0; x < size_.x(); ++x) {
            const int at = axis == 0 ? x : axis == 1 ? y : z;
            const auto index = static_cast<std::ptrdiff_t>(At(x, y, z));
            float sum = 0;
            for (int i = std::max(-reach, -at);
                 i <= std::min(reach, size_[axis] - 1 - at);
                 ++i) {
              sum += kernel[static_cast<std::size_t>(i + reach)] *
                     source[static_cast<std::size_t>(index + i * along)];
            }
            values_[static_cast<std::size_t>(index)] = sum / total;
          }
        }
      }
    });
  }

  double shrink_ = 1;
  int margin_ = 0;
  Eigen::Vector3i size_;
  std::vector<float> values_;
};

// What is summed along view rays, each times the sample's share of the ray.
enum RaySum {
  kShare,
  kSunInput,
  kSunTarget,
  kSunBoth,
  kSunInputSquare,
  kSunTargetSquare,
  kSkyInput,
  kSkyTarget,
  kDepthToSunInput,
  kDepthToSunTarget,
  kNearInput,
  kNearTarget,
  kNearView,
  kFarInput,
  kFarTarget,
  kFarView,
  kFarUp,
  kNearDensity,
  kFarDensity,
  kDepthInCrown,
  kTowardsInput,
  kTowardsTarget,
  kFromAxis,
  kHeight,
  kWood,
  kLightInput,
  kLightTarget,
  kRaySums
};

using Sums = std::array<double, kRaySums>;

// Names in the order in which Under() adds its planes.
const std::vector<std::string> kNames = {"photo_fine",
                                         "photo_wide",
                                         "photo_contrast",
                                         "photo_dark",
                                         "photo_bright",
                                         "photo_red_fine",
                                         "photo_blue_fine",
                                         "photo_red_wide",
                                         "photo_blue_wide",
                                         "light_input_fine",
                                         "light_target_fine",
                                         "light_input_wide",
                                         "light_target_wide",
                                         "ratio_fine",
                                         "ratio_wide",
                                         "residual_fine",
                                         "residual_wide",
                                         "sun_input_fine",
                                         "sun_target_fine",
                                         "sun_input_wide",
                                         "sun_target_wide",
                                         "sun_covariance",
                                         "sun_input_spread",
                                         "sun_target_spread",
                                         "sky_input",
                                         "sky_target",
                                         "depth_to_sun_input",
                                         "depth_to_sun_target",
                                         "depth_to_sun_input_w",
                                         "depth_to_sun_target_w",
                                         "near_facing_input",
                                         "near_facing_target",
                                         "near_facing_view",
                                         "far_facing_input",
                                         "far_facing_target",
                                         "far_facing_view",
                                         "far_facing_up",
                                         "near_density",
                                         "far_density",
                                         "depth_in_crown",
                                         "towards_input",
                                         "towards_target",
                                         "from_axis",
                                         "height",
                                         "wood",
                                         "share_fine",
                                         "share_wide",
                                         "cover_fine",
                                         "cover_wide",
                                         "elevation_input",
                                         "elevation_target",
                                         "view_to_sun_input",
                                         "view_to_sun_target",
                                         "sun_to_sun",
                                         "sun_to_sky_input",
                                         "sun_to_sky_target"};

}  // namespace

const std::vector<std::string>& CorrectionFeatureNames() { return kNames; }

std::optional<PhotoContrast> ContrastOfPhoto(const CorrectionFeatures& features) {
  if (features.planes.empty()) return std::nullopt;
  const auto plane = [&](const char* name) {
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    return features.planes[static_cast<std::size_t>(found - kNames.begin())];
  };
  const double covered = std::max(1e-9, cv::sum(features.cover)[0]);
  const auto mean = [&](const cv::Mat1f& of) { return of.dot(features.cover) / covered; };
  const cv::Mat1f step = plane("photo_fine") - plane("photo_wide");
  const double mean_step = mean(step);
  return PhotoContrast{
      mean(plane("photo_contrast")),
      std::sqrt(std::max(0.0, mean(step.mul(step)) - mean_step * mean_step))};
}

CorrectionView::CorrectionView(const ExtinctionGrid& grid,
                               const OccupiedVoxels& occupied,
                               const Camera& camera,
                               const cv::Mat3f& colors,
                               const cv::Mat1f& alpha)
    : extinction_(grid), occupied_(occupied), camera_(camera) {
  Require(alpha.cols == camera.width_px && alpha.rows == camera.height_px &&
              colors.size() == alpha.size(),
          "colours and matte have the camera's size");
  patches_ = PatchesOver(alpha);
  if (patches_.rows == 0 || occupied.cell.empty()) {
    patches_ = {};
    return;
  }
  const cv::Size size(patches_.columns, patches_.rows);
  const auto column_of = [&](int column) {
    return std::clamp(
        static_cast<int>((column + 0.5 - patches_.left_px) / patches_.patch_px),
        0,
        size.width - 1);
  };
  const auto row_of = [&](int row) {
    return std::clamp(static_cast<int>((row + 0.5 - patches_.top_px) / patches_.patch_px),
                      0,
                      size.height - 1);
  };
  const cv::Rect box(
      static_cast<int>(patches_.left_px),
      static_cast<int>(patches_.top_px),
      std::min(alpha.cols - static_cast<int>(patches_.left_px),
               static_cast<int>(std::ceil(patches_.columns * patches_.patch_px))),
      std::min(alpha.rows - static_cast<int>(patches_.top_px),
               static_cast<int>(std::ceil(patches_.rows * patches_.patch_px))));

  // Sums over the pixels of each patch; a row of patches belongs to one thread
  const auto zeros = [&] { return cv::Mat1f(cv::Mat1f::zeros(size)); };
  photo_ = {zeros(), zeros(), zeros(), zeros(), zeros(), zeros(), zeros()};
  std::vector<int> first_row(static_cast<std::size_t>(size.height) + 1,
                             box.y + box.height);
  for (int row = box.y + box.height - 1; row >= box.y; --row) {
    first_row[static_cast<std::size_t>(row_of(row))] = row;
  }
  const auto over_pixels = [&](auto&& visit) {
    ParallelRanges(size.height, 1, [&](int begin, int end) {
      for (int patch_row = begin; patch_row < end; ++patch_row) {
        for (int row = first_row[static_cast<std::size_t>(patch_row)];
             row < box.y + box.height && row_of(row) == patch_row;
             ++row) {
          for (int column = box.x; column < box.x + box.width; ++column) {
            const float a = alpha(row, column);
            if (a > 0) visit(patch_row, column_of(column), a, colors(row, column));
          }
        }
      }
    });
  };
  over_pixels([&](int row, int column, float a, const cv::Vec3f& color) {
    photo_.alpha(row, column) += a;
    photo_.red(row, column) += a * color[0];
    photo_.green(row, column) += a * color[1];
    photo_.blue(row, column) += a * color[2];
    const float luminance = Luminance(color);
    photo_.square(row, column) += a * luminance * luminance;
  });
  const double total = cv::sum(photo_.alpha)[0];
  mean_luminance_ = (0.2126 * cv::sum(photo_.red)[0] + 0.7152 * cv::sum(photo_.green)[0] +
                     0.0722 * cv::sum(photo_.blue)[0]) /
                    std::max(total, 1e-9);
  const auto dark = static_cast<float>(0.4 * mean_luminance_);
  const auto bright = static_cast<float>(1.8 * mean_luminance_);
  over_pixels([&](int row, int column, float a, const cv::Vec3f& color) {
    const float luminance = Luminance(color);
    if (luminance < dark) photo_.dark(row, column) += a;
    if (luminance > bright) photo_.bright(row, column) += a;
  });

  // The crown's own measures, by where its extinction is
  double sum = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero(), square = moment;
  double low = 1e30, high = -1e30;
  for (const Eigen::Vector3i& cell : occupied.cell) {
    const double sigma = grid.sigma_per_m[grid.Index(cell.x(), cell.y(), cell.z())];
    const Eigen::Vector3d at = grid.Center(cell.x(), cell.y(), cell.z());
    sum += sigma;
    moment += sigma * at;
    square += sigma * at.cwiseProduct(at);
    low = std::min(low, at.z());
    high = std::max(high, at.z());
  }
  crown_center_ = moment / sum;
  const Eigen::Vector3d spread = square / sum - crown_center_.cwiseProduct(crown_center_);
  crown_radius_m_ =
      std::max(grid.cell_m, std::sqrt(std::max(0.0, spread.x() + spread.y())));
  crown_low_m_ = low;
  crown_height_m_ = std::max(grid.cell_m, high - low);
  mean_extinction_per_m_ = sum / static_cast<double>(occupied.cell.size());

  const CoarseDensity near(grid, std::max(grid.cell_m, 0.02 * crown_height_m_));
  const CoarseDensity far(grid, std::max(grid.cell_m, 0.07 * crown_height_m_));
  surroundings_.resize(occupied.cell.size());
  ParallelRanges(static_cast<int>(occupied.cell.size()), 4096, [&](int begin, int end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
         ++v) {
      Surroundings& s = surroundings_[v];
      std::tie(s.near_per_m, s.outward_near) = near.AtVoxel(occupied.cell[v]);
      std::tie(s.far_per_m, s.outward_far) = far.AtVoxel(occupied.cell[v]);
    }
  });
}

CorrectionFeatures CorrectionView::Under(const FeatureLight& input,
                                         const FeatureLight& target) const {
  CorrectionFeatures features;
  features.grid = patches_;
  if (patches_.rows == 0) return features;
  const cv::Size size(patches_.columns, patches_.rows);
  const auto patch_area = static_cast<float>(patches_.patch_px * patches_.patch_px);

  // Light of voxels without a unit: shares of the sun and of the open sky
  const auto green = [](const Eigen::Array3d& color) {
    return static_cast<float>(std::max(1e-6, color[1]));
  };
  const float sun_in = green(input.daylight.sun_irradiance);
  const float sun_out = green(target.daylight.sun_irradiance);
  const float sky_in = green(HorizontalSkyIrradiance(input.daylight));
  const float sky_out = green(HorizontalSkyIrradiance(target.daylight));
  const auto luminance_of = [](const Eigen::Array3f& c) {
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
  };
  const Eigen::Vector3f to_sun_in = input.daylight.sun_direction.cast<float>();
  const Eigen::Vector3f to_sun_out = target.daylight.sun_direction.cast<float>();
  const auto level = [](const Eigen::Vector3d& direction) {
    Eigen::Vector3d flat(direction.x(), direction.y(), 0);
    return flat.norm() > 1e-9 ? Eigen::Vector3d(flat.normalized()) : flat;
  };
  const Eigen::Vector3d level_in = level(input.daylight.sun_direction);
  const Eigen::Vector3d level_out = level(target.daylight.sun_direction);

  // Two by two rays a patch
  std::vector<cv::Mat1f> sums(kRaySums);
  for (cv::Mat1f& plane : sums) plane = cv::Mat1f::zeros(size);
  const Eigen::Vector3d eye = camera_.PositionInWorld();
  const Eigen::Vector3d to_center = (crown_center_ - eye).normalized();
  constexpr float kDeepest = 8.0f;
  ParallelRanges(size.height, 1, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < size.width; ++column) {
        if (photo_.alpha(row, column) <= 0.02f * patch_area) continue;
        Sums patch{};
        for (int part = 0; part < 4; ++part) {
          const Eigen::Vector2d pixel(
              patches_.left_px + (column + 0.25 + 0.5 * (part & 1)) * patches_.patch_px,
              patches_.top_px + (row + 0.25 + 0.5 * (part >> 1)) * patches_.patch_px);
          const Ray ray{eye, camera_.RayInWorld(pixel)};
          const Eigen::Vector3f to_eye = (-ray.direction).cast<float>();
          double tau = 1.0;
          TraverseRay(extinction_,
                      ray,
                      0.0,
                      [&](std::size_t cell, double entry, double length_m) {
                        const int found = occupied_.of_cell[cell];
                        if (found < 0) return true;
                        const auto v = static_cast<std::size_t>(found);
                        const float sigma = extinction_.sigma_per_m[cell];
                        const double share = -tau * std::expm1(-length_m * sigma);
                        tau -= share;
                        const Surroundings& s = surroundings_[v];
                        const float a = std::min(1.0f, input.arriving.sun[v][1] / sun_in);
                        const float b =
                            std::min(1.0f, target.arriving.sun[v][1] / sun_out);
                        const Eigen::Vector3d at =
                            ray.origin + (entry + length_m / 2) * ray.direction;
                        const Eigen::Vector3d from_center = at - crown_center_;
                        const auto add = [&](RaySum what, double value) {
                          patch[what] += share * value;
                        };
                        add(kShare, 1);
                        add(kSunInput, a);
                        add(kSunTarget, b);
                        add(kSunBoth, a * b);
                        add(kSunInputSquare, a * a);
                        add(kSunTargetSquare, b * b);
                        add(kSkyInput, input.arriving.sky[v][1] / sky_in);
                        add(kSkyTarget, target.arriving.sky[v][1] / sky_out);
                        add(kDepthToSunInput, std::min(kDeepest, -std::log(a + 1e-6f)));
                        add(kDepthToSunTarget, std::min(kDeepest, -std::log(b + 1e-6f)));
                        add(kNearInput, s.outward_near.dot(to_sun_in));
                        add(kNearTarget, s.outward_near.dot(to_sun_out));
                        add(kNearView, s.outward_near.dot(to_eye));
                        add(kFarInput, s.outward_far.dot(to_sun_in));
                        add(kFarTarget, s.outward_far.dot(to_sun_out));
                        add(kFarView, s.outward_far.dot(to_eye));
                        add(kFarUp, s.outward_far.z());
                        add(kNearDensity, s.near_per_m);
                        add(kFarDensity, s.far_per_m);
                        add(kDepthInCrown, from_center.dot(to_center) / crown_radius_m_);
                        add(kTowardsInput, from_center.dot(level_in) / crown_radius_m_);
                        add(kTowardsTarget, from_center.dot(level_out) / crown_radius_m_);
                        add(kFromAxis, from_center.head<2>().norm() / crown_radius_m_);
                        add(kHeight, (at.z() - crown_low_m_) / crown_height_m_);
                        add(kWood, sigma * extinction_.cell_m > 2 ? 1 : 0);
                        const auto light = [&](const ArrivingLight& l) {
                          return luminance_of(l.sun[v] + l.sky[v] + l.indirect[v]);
                        };
                        add(kLightInput, light(input.arriving));
                        add(kLightTarget, light(target.arriving));
                        return tau > 1e-3;
                      });
        }
        for (int i = 0; i < kRaySums; ++i) {
          sums[static_cast<std::size_t>(i)](row, column) =
              static_cast<float>(patch[static_cast<std::size_t>(i)] / 4);
        }
      }
    }
  });

  // Planes, in the order of kNames
  std::vector<cv::Mat1f>& planes = features.planes;
  const auto add = [&](const cv::Mat1f& plane) { planes.push_back(plane); };
  const auto add_number = [&](double value) {
    planes.push_back(cv::Mat1f(size, static_cast<float>(value)));
  };
  const auto photo = [&](const cv::Mat1f& of, double patches) {
    return Mean(of, photo_.alpha, patches);
  };
  const auto along = [&](RaySum of, double patches) {
    return Mean(sums[of], sums[kShare], patches);
  };
  const cv::Mat1f luminance =
      0.2126f * photo_.red + 0.7152f * photo_.green + 0.0722f * photo_.blue;
  const double dim = std::max(1e-9, 0.02 * mean_luminance_);
  const double log_mean = std::log(std::max(1e-9, mean_luminance_));
  const cv::Mat1f photo_fine = photo(luminance, kFinePatches);
  const cv::Mat1f photo_wide = photo(luminance, kWidePatches);
  const cv::Mat1f log_photo_fine = Log(photo_fine, dim) - log_mean;
  const cv::Mat1f log_photo_wide = Log(photo_wide, dim) - log_mean;
  add(log_photo_fine);
  add(log_photo_wide);
  cv::Mat1f contrast = photo(photo_.square, kFinePatches);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double m = std::max<double>(dim, photo_fine(row, column));
      contrast(row, column) = static_cast<float>(
          std::min(3.0, std::sqrt(std::max(0.0, contrast(row, column) / (m * m) - 1))));
    }
  }
  add(contrast);
  add(photo(photo_.dark, kFinePatches));
  add(photo(photo_.bright, kFinePatches));
  const auto crown_color = [&](const cv::Mat1f& of) {
    return std::log((cv::sum(of)[0] + 1e-9) / (cv::sum(photo_.green)[0] + 1e-9));
  };
  for (const double patches : {kFinePatches, kWidePatches}) {
    const cv::Mat1f g = Log(photo(photo_.green, patches), dim);
    for (const cv::Mat1f& of : {photo_.red, photo_.blue}) {
      const cv::Mat1f color = Log(photo(of, patches), 0.1 * dim) - g;
      add(cv::max(-2.0, cv::min(2.0, cv::Mat1f(color - crown_color(of)))));
    }
  }

  // The two lights, each to its own mean
  std::array<cv::Mat1f, 4> log_light;  // Input and target, fine; then wide.
  std::array<double, 2> mean_light{};
  for (std::size_t i = 0; i < 4; ++i) {
    const RaySum of = i % 2 == 0 ? kLightInput : kLightTarget;
    mean_light[i % 2] = cv::sum(sums[of])[0] / std::max(1e-9, cv::sum(sums[kShare])[0]);
    const double mean = std::max(1e-9, mean_light[i % 2]);
    log_light[i] =
        Log(along(of, i < 2 ? kFinePatches : kWidePatches), 0.01 * mean) - std::log(mean);
    add(log_light[i]);
  }
  const cv::Mat1f ratio_fine = log_light[1] - log_light[0];
  add(ratio_fine);
  add(log_light[3] - log_light[2]);
  add(log_photo_fine - log_light[0]);
  add(log_photo_wide - log_light[2]);

  // Sun and sky at the samples of the rays
  const cv::Mat1f sun_in_fine = along(kSunInput, kFinePatches);
  const cv::Mat1f sun_out_fine = along(kSunTarget, kFinePatches);
  add(sun_in_fine);
  add(sun_out_fine);
  add(along(kSunInput, kWidePatches));
  add(along(kSunTarget, kWidePatches));
  add(along(kSunBoth, kFinePatches) - sun_in_fine.mul(sun_out_fine));
  add(along(kSunInputSquare, kFinePatches) - sun_in_fine.mul(sun_in_fine));
  add(along(kSunTargetSquare, kFinePatches) - sun_out_fine.mul(sun_out_fine));
  add(along(kSkyInput, kFinePatches));
  add(along(kSkyTarget, kFinePatches));
  add(along(kDepthToSunInput, kFinePatches));
  add(along(kDepthToSunTarget, kFinePatches));
  add(along(kDepthToSunInput, kWidePatches));
  add(along(kDepthToSunTarget, kWidePatches));
  for (const RaySum of :
       {kNearInput, kNearTarget, kNearView, kFarInput, kFarTarget, kFarView, kFarUp}) {
    add(along(of, kFinePatches));
  }
  const double dense = std::max(1e-9, mean_extinction_per_m_);
  add(along(kNearDensity, kFinePatches) / dense);
  add(along(kFarDensity, kFinePatches) / dense);
  for (const RaySum of :
       {kDepthInCrown, kTowardsInput, kTowardsTarget, kFromAxis, kHeight, kWood}) {
    add(along(of, kFinePatches));
  }
  cv::Mat1f hit(size, 0.0f);
  hit.setTo(1.0f, photo_.alpha > 0.02f * patch_area);
  features.cover = cv::min(1.0, cv::Mat1f(photo_.alpha / patch_area));
  features.volume_share = Mean(sums[kShare], hit, kFinePatches);
  add(features.volume_share);
  add(Mean(sums[kShare], hit, kWidePatches));
  add(Blurred(features.cover, kFinePatches));
  add(Blurred(features.cover, kWidePatches));

  // What is one number for the whole picture
  const Eigen::Vector3d forward = to_center;
  add_number(input.daylight.sun_direction.z());
  add_number(target.daylight.sun_direction.z());
  add_number(level(forward).dot(level_in));
  add_number(level(forward).dot(level_out));
  add_number(input.daylight.sun_direction.dot(target.daylight.sun_direction));
  const auto to_sky = [](const Daylight& daylight, float sun, float sky) {
    return std::log((sun * std::max(0.0, daylight.sun_direction.z()) + 1e-3) /
                    (sky + 1e-3));
  };
  add_number(to_sky(input.daylight, sun_in, sky_in));
  add_number(to_sky(target.daylight, sun_out, sky_out));
  Require(planes.size() == kNames.size(), "each plane has its name");
  return features;
}

}  // namespace relight
