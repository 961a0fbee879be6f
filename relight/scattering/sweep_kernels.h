// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inner loops of transmittance.h, swept_transmittance.h and view_transport.h, as vectors
// of the widest kind that the machine has, chosen when the program runs (Highway).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace relight {

// Lengths of all lines in half a plane's thickness: in the voxel that they are in, in
// the one at offset[0] from it, and in the one at offset[1].
struct HalfStep {
  std::ptrdiff_t offset[2] = {0, 0};
  float length[3] = {0, 0, 0};
};

struct PlaneStep {
  HalfStep outer, inner;
  float half = 0;  // l / 2 of (S6), in voxel edges.
};

// One plane for the voxels [from, to) of a row. May go on to the end of a vector, up to
// 64 values further, where `sigma` has to be 0.
void SweepRow(const PlaneStep& step,
              const float* sigma,
              float* line,
              float* depth,
              int from,
              int to);

// sum[i] += factor * values[i].
void AddScaled(float* sum, float factor, const float* values, std::size_t count);

// Rays that go together from each voxel of a row.
inline constexpr std::size_t kBundle = 8;

// A voxel on their way: of the row's voxel x it is sigma[x], for x in [from, to).
struct RowStep {
  const float* sigma = nullptr;
  int from = 0, to = 0;
  std::array<float, kBundle> length{};  // Of each ray inside of it.
};

// Their way from the voxels [begin, end) of a row.
struct Bundle {
  std::span<const RowStep> steps;  // In the order of the rays.
  std::size_t rays = kBundle;      // The first of kBundle.
  float share = 1;                 // Of each ray in the mean.
  int begin = 0, end = 0;
};

// mean[x] += share * sum over the rays of exp(-sum over steps of length sigma), for x in
// [begin, end).
void AddBundle(const Bundle& bundle, float* mean);

// values[i] = exp(-values[i]).
void ExpOfNegative(float* values, std::size_t count);

// For `voxels` (a multiple of 64) of them:
//   sum[c * sum_stride + v] += factor[d * functions + c] exp(-depth[d * depth_stride +
//   v])
void AddProjection(const float* depth,
                   std::size_t depth_stride,
                   std::size_t directions,
                   const float* factor,
                   std::size_t functions,
                   float* sum,
                   std::size_t sum_stride,
                   std::size_t voxels);

// Products of half floats with one colour a function:
//   out[v * 3 + channel] = max(0, sum over c of color[c * 3 + channel] half[c * stride +
//   v])
// for v in [0, count).
void ColorProduct(const std::uint16_t* half,
                  std::size_t stride,
                  const float* color,
                  std::size_t functions,
                  float* out,
                  std::size_t count);

// Values to half floats, to the nearest, and back.
void ToHalf(const float* values, std::uint16_t* half, std::size_t count);
void FromHalf(const std::uint16_t* half, float* values, std::size_t count);

// The sum of share[i] values[index[i]], shares as half floats.
float SharedSum(const std::uint16_t* share,
                const std::int32_t* index,
                std::size_t count,
                const float* values);

// The sum of half floats as 32-bit words: what reading them alone costs, for benchmarks.
std::uint32_t ReadThrough(const std::uint16_t* half, std::size_t count);

}  // namespace relight
