// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "relight/scattering/sweep_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Highway's own functions of the vectors of each target
#include <hwy/contrib/math/math-inl.h>

#include "relight/scattering/sweep_kernels.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace relight::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void SweepRowOn(const PlaneStep& step,
                const float* sigma,
                float* line,
                float* depth,
                int from,
                int to) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto half = hn::Set(d, step.half);
  const auto middle = hn::Set(d, step.outer.length[0] + step.inner.length[0]);
  const auto o1 = hn::Set(d, step.outer.length[1]), o2 = hn::Set(d, step.outer.length[2]);
  const auto i1 = hn::Set(d, step.inner.length[1]), i2 = hn::Set(d, step.inner.length[2]);
  const float* so1 = sigma + step.outer.offset[0];
  const float* so2 = sigma + step.outer.offset[1];
  const float* si1 = sigma + step.inner.offset[0];
  const float* si2 = sigma + step.inner.offset[1];
  for (int x = from; x < to; x += lanes) {
    const auto own = hn::LoadU(d, sigma + x);
    auto a = hn::LoadU(d, line + x);
    hn::StoreU(hn::MulAdd(own, half, a), d, depth + x);
    a = hn::MulAdd(own, middle, a);
    a = hn::MulAdd(hn::LoadU(d, so1 + x), o1, a);
    a = hn::MulAdd(hn::LoadU(d, so2 + x), o2, a);
    a = hn::MulAdd(hn::LoadU(d, si1 + x), i1, a);
    a = hn::MulAdd(hn::LoadU(d, si2 + x), i2, a);
    hn::StoreU(a, d, line + x);
  }
}

// exp(-depth): 0 where it is below the least normal float.
template <class D>
hn::Vec<D> Transmittance(D d, hn::Vec<D> depth) {
  const auto least = hn::Set(d, -87.0f);
  const auto x = hn::Neg(depth);
  return hn::IfThenElseZero(hn::Gt(x, least), hn::Exp(d, hn::Max(x, least)));
}

void AddScaledOn(float* sum, float factor, const float* values, std::size_t count) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto f = hn::Set(d, factor);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(
        hn::MulAdd(f, hn::LoadU(d, values + i), hn::LoadU(d, sum + i)), d, sum + i);
  }
  const hn::CappedTag<float, 1> d1;  // Rounded as the vectors are
  for (; i < count; ++i) {
    hn::StoreU(
        hn::MulAdd(
            hn::Set(d1, factor), hn::LoadU(d1, values + i), hn::LoadU(d1, sum + i)),
        d1,
        sum + i);
  }
}

void AddBundleOn(const Bundle& bundle, float* mean) {
  const auto [steps, rays, share, begin, end] = bundle;
  const hn::CappedTag<float, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float edge[16] = {};
  for (int x = begin; x < end; x += lanes) {
    auto a0 = hn::Zero(d), a1 = a0, a2 = a0, a3 = a0, a4 = a0, a5 = a0, a6 = a0, a7 = a0;
    for (const RowStep& step : steps) {
      if (x >= step.to || x + lanes <= step.from) continue;
      auto sigma = hn::Zero(d);
      if (x >= step.from && x + lanes <= step.to) {
        sigma = hn::LoadU(d, step.sigma + x);
      } else {
        for (int l = 0; l < lanes; ++l) {
          edge[l] = x + l >= step.from && x + l < step.to ? step.sigma[x + l] : 0.0f;
        }
        sigma = hn::Load(d, edge);
      }
      const float* length = step.length.data();
      a0 = hn::MulAdd(sigma, hn::Set(d, length[0]), a0);
      a1 = hn::MulAdd(sigma, hn::Set(d, length[1]), a1);
      a2 = hn::MulAdd(sigma, hn::Set(d, length[2]), a2);
      a3 = hn::MulAdd(sigma, hn::Set(d, length[3]), a3);
      a4 = hn::MulAdd(sigma, hn::Set(d, length[4]), a4);
      a5 = hn::MulAdd(sigma, hn::Set(d, length[5]), a5);
      a6 = hn::MulAdd(sigma, hn::Set(d, length[6]), a6);
      a7 = hn::MulAdd(sigma, hn::Set(d, length[7]), a7);
    }
    HWY_ALIGN float depth[kBundle * 16];
    hn::Store(a0, d, depth);
    hn::Store(a1, d, depth + lanes);
    hn::Store(a2, d, depth + 2 * lanes);
    hn::Store(a3, d, depth + 3 * lanes);
    hn::Store(a4, d, depth + 4 * lanes);
    hn::Store(a5, d, depth + 5 * lanes);
    hn::Store(a6, d, depth + 6 * lanes);
    hn::Store(a7, d, depth + 7 * lanes);
    for (int l = 0; l < lanes; ++l) edge[l] = x + l < end ? mean[x + l] : 0.0f;
    auto sum = hn::Load(d, edge);
    for (std::size_t ray = 0; ray < rays; ++ray) {
      const auto tau =
          Transmittance(d, hn::Load(d, depth + ray * static_cast<std::size_t>(lanes)));
      sum = hn::Add(sum, hn::Mul(hn::Set(d, share), tau));
    }
    hn::Store(sum, d, edge);
    for (int l = 0; l < std::min(lanes, end - x); ++l) mean[x + l] = edge[l];
  }
}

void ExpOfNegativeOn(float* values, std::size_t count) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(Transmittance(d, hn::LoadU(d, values + i)), d, values + i);
  }
  const hn::CappedTag<float, 1> d1;
  for (; i < count; ++i) {
    hn::StoreU(Transmittance(d1, hn::LoadU(d1, values + i)), d1, values + i);
  }
}

void AddProjectionOn(const float* depth,
                     std::size_t depth_stride,
                     std::size_t directions,
                     const float* factor,
                     std::size_t functions,
                     float* sum,
                     std::size_t sum_stride,
                     std::size_t voxels) {
  constexpr std::size_t kChunk = 64, kMost = 64;  // 16 KB of transmittance in the cache
  const hn::CappedTag<float, kChunk> d;
  const std::size_t lanes = hn::Lanes(d);
  HWY_ALIGN float tau[kChunk * kMost];
  for (std::size_t begin = 0; begin < voxels; begin += kChunk) {
    for (std::size_t first = 0; first < directions; first += kMost) {
      const std::size_t count = std::min(kMost, directions - first);
      for (std::size_t i = 0; i < count; ++i) {
        const float* from = depth + (first + i) * depth_stride + begin;
        for (std::size_t x = 0; x < kChunk; x += lanes) {
          const auto t = Transmittance(d, hn::LoadU(d, from + x));
          hn::Store(t, d, tau + i * kChunk + x);
        }
      }
      const float* f = factor + first * functions;
      for (std::size_t x = 0; x < kChunk; x += lanes) {
        std::size_t c = 0;
        for (; c + 6 <= functions; c += 6) {
          float* to = sum + c * sum_stride + begin + x;
          auto s0 = hn::LoadU(d, to), s1 = hn::LoadU(d, to + sum_stride),
               s2 = hn::LoadU(d, to + 2 * sum_stride),
               s3 = hn::LoadU(d, to + 3 * sum_stride),
               s4 = hn::LoadU(d, to + 4 * sum_stride),
               s5 = hn::LoadU(d, to + 5 * sum_stride);
          for (std::size_t i = 0; i < count; ++i) {
            const auto t = hn::Load(d, tau + i * kChunk + x);
            const float* b = f + i * functions + c;
            s0 = hn::MulAdd(t, hn::Set(d, b[0]), s0);
            s1 = hn::MulAdd(t, hn::Set(d, b[1]), s1);
            s2 = hn::MulAdd(t, hn::Set(d, b[2]), s2);
            s3 = hn::MulAdd(t, hn::Set(d, b[3]), s3);
            s4 = hn::MulAdd(t, hn::Set(d, b[4]), s4);
            s5 = hn::MulAdd(t, hn::Set(d, b[5]), s5);
          }
          hn::StoreU(s0, d, to);
          hn::StoreU(s1, d, to + sum_stride);
          hn::StoreU(s2, d, to + 2 * sum_stride);
          hn::StoreU(s3, d, to + 3 * sum_stride);
          hn::StoreU(s4, d, to + 4 * sum_stride);
          hn::StoreU(s5, d, to + 5 * sum_stride);
        }
        for (; c < functions; ++c) {
          float* to = sum + c * sum_stride + begin + x;
          auto s = hn::LoadU(d, to);
          for (std::size_t i = 0; i < count; ++i) {
            s = hn::MulAdd(
                hn::Load(d, tau + i * kChunk + x), hn::Set(d, f[i * functions + c]), s);
          }
          hn::StoreU(s, d, to);
        }
      }
    }
  }
}

void ColorProductOn(const std::uint16_t* half,
                    std::size_t stride,
                    const float* color,
                    std::size_t functions,
                    float* out,
                    std::size_t count) {
  const hn::ScalableTag<float> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const std::size_t lanes = hn::Lanes(d);
  const auto* values = reinterpret_cast<const hwy::float16_t*>(half);
  const auto zero = hn::Zero(d);
  const auto store = [&](auto r, auto g, auto b, std::size_t at) HWY_ATTR {
    hn::StoreInterleaved3(
        hn::Max(r, zero), hn::Max(g, zero), hn::Max(b, zero), d, out + 3 * at);
  };
  const auto load = [&](std::size_t c, std::size_t at) HWY_ATTR {
    return hn::PromoteTo(d, hn::LoadU(dh, values + c * stride + at));
  };
  // The products wait for memory longer than a processor looks ahead by itself
  constexpr std::size_t kAhead = 2304, kLine = 32;  // Half floats
  constexpr int kSecondCache = 2;
  std::size_t v = 0;
  // Four vectors at a time: a sum waits for its last product, twelve do not
  for (; v + 4 * lanes <= count; v += 4 * lanes) {
    auto r0 = zero, g0 = zero, b0 = zero, r1 = zero, g1 = zero, b1 = zero;
    auto r2 = zero, g2 = zero, b2 = zero, r3 = zero, g3 = zero, b3 = zero;
    for (std::size_t c = 0; c < functions; ++c) {
      const auto red = hn::Set(d, color[3 * c]), green = hn::Set(d, color[3 * c + 1]);
      const auto blue = hn::Set(d, color[3 * c + 2]);
      const std::uint16_t* ahead = half + c * stride + v + kAhead;
      __builtin_prefetch(ahead, 0, kSecondCache);
      __builtin_prefetch(ahead + kLine, 0, kSecondCache);
      const auto x0 = load(c, v), x1 = load(c, v + lanes);
      const auto x2 = load(c, v + 2 * lanes), x3 = load(c, v + 3 * lanes);
      r0 = hn::MulAdd(x0, red, r0);
      g0 = hn::MulAdd(x0, green, g0);
      b0 = hn::MulAdd(x0, blue, b0);
      r1 = hn::MulAdd(x1, red, r1);
      g1 = hn::MulAdd(x1, green, g1);
      b1 = hn::MulAdd(x1, blue, b1);
      r2 = hn::MulAdd(x2, red, r2);
      g2 = hn::MulAdd(x2, green, g2);
      b2 = hn::MulAdd(x2, blue, b2);
      r3 = hn::MulAdd(x3, red, r3);
      g3 = hn::MulAdd(x3, green, g3);
      b3 = hn::MulAdd(x3, blue, b3);
    }
    store(r0, g0, b0, v);
    store(r1, g1, b1, v + lanes);
    store(r2, g2, b2, v + 2 * lanes);
    store(r3, g3, b3, v + 3 * lanes);
  }
  for (; v + lanes <= count; v += lanes) {
    auto r = zero, g = zero, b = zero;
    for (std::size_t c = 0; c < functions; ++c) {
      const auto x = load(c, v);
      r = hn::MulAdd(x, hn::Set(d, color[3 * c]), r);
      g = hn::MulAdd(x, hn::Set(d, color[3 * c + 1]), g);
      b = hn::MulAdd(x, hn::Set(d, color[3 * c + 2]), b);
    }
    store(r, g, b, v);
  }
  const hn::CappedTag<float, 1> d1;
  const hn::Rebind<hwy::float16_t, decltype(d1)> dh1;
  for (; v < count; ++v) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      auto sum = hn::Zero(d1);
      for (std::size_t c = 0; c < functions; ++c) {
        const auto x = hn::PromoteTo(d1, hn::LoadU(dh1, values + c * stride + v));
        sum = hn::MulAdd(x, hn::Set(d1, color[3 * c + channel]), sum);
      }
      out[3 * v + channel] = std::max(0.0f, hn::GetLane(sum));
    }
  }
}

void ToHalfOn(const float* values, std::uint16_t* half, std::size_t count) {
  const hn::ScalableTag<float> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const std::size_t lanes = hn::Lanes(d);
  auto* to = reinterpret_cast<hwy::float16_t*>(half);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(hn::DemoteTo(dh, hn::LoadU(d, values + i)), dh, to + i);
  }
  const hn::CappedTag<float, 1> d1;
  const hn::Rebind<hwy::float16_t, decltype(d1)> dh1;
  for (; i < count; ++i) {
    hn::StoreU(hn::DemoteTo(dh1, hn::LoadU(d1, values + i)), dh1, to + i);
  }
}

void FromHalfOn(const std::uint16_t* half, float* values, std::size_t count) {
  const hn::ScalableTag<float> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const std::size_t lanes = hn::Lanes(d);
  const auto* from = reinterpret_cast<const hwy::float16_t*>(half);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(hn::PromoteTo(d, hn::LoadU(dh, from + i)), d, values + i);
  }
  const hn::CappedTag<float, 1> d1;
  const hn::Rebind<hwy::float16_t, decltype(d1)> dh1;
  for (; i < count; ++i) {
    hn::StoreU(hn::PromoteTo(d1, hn::LoadU(dh1, from + i)), d1, values + i);
  }
}

float SharedSumOn(const std::uint16_t* share,
                  const std::int32_t* index,
                  std::size_t count,
                  const float* values) {
  const hn::CappedTag<float, 8> d;  // Rays are short
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const hn::RebindToSigned<decltype(d)> di;
  const std::size_t lanes = hn::Lanes(d);
  const auto* shares = reinterpret_cast<const hwy::float16_t*>(share);
  auto sums = hn::Zero(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto value = hn::GatherIndex(d, values, hn::LoadU(di, index + i));
    sums = hn::MulAdd(hn::PromoteTo(d, hn::LoadU(dh, shares + i)), value, sums);
  }
  float sum = hn::GetLane(hn::SumOfLanes(d, sums));
  const hn::CappedTag<float, 1> d1;
  const hn::Rebind<hwy::float16_t, decltype(d1)> dh1;
  for (; i < count; ++i) {
    sum += hn::GetLane(hn::PromoteTo(d1, hn::LoadU(dh1, shares + i))) * values[index[i]];
  }
  return sum;
}

std::uint32_t ReadThroughOn(const std::uint16_t* half, std::size_t count) {
  const hn::ScalableTag<std::uint16_t> d;
  const std::size_t lanes = hn::Lanes(d);
  auto a = hn::Zero(d), b = hn::Zero(d);
  std::size_t i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    a = hn::Xor(a, hn::LoadU(d, half + i));
    b = hn::Xor(b, hn::LoadU(d, half + i + lanes));
  }
  HWY_ALIGN std::uint16_t last[HWY_MAX_BYTES / 2] = {};
  hn::Store(hn::Xor(a, b), d, last);
  std::uint32_t sum = 0;
  for (std::size_t l = 0; l < lanes; ++l) sum ^= last[l];
  for (; i < count; ++i) sum ^= half[i];
  return sum;
}

}  // namespace relight::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relight {

HWY_EXPORT(SweepRowOn);
HWY_EXPORT(AddScaledOn);
HWY_EXPORT(AddBundleOn);
HWY_EXPORT(ExpOfNegativeOn);
HWY_EXPORT(AddProjectionOn);
HWY_EXPORT(ColorProductOn);
HWY_EXPORT(ToHalfOn);
HWY_EXPORT(FromHalfOn);
HWY_EXPORT(SharedSumOn);
HWY_EXPORT(ReadThroughOn);

void SweepRow(const PlaneStep& step,
              const float* sigma,
              float* line,
              float* depth,
              int from,
              int to) {
  HWY_DYNAMIC_DISPATCH(SweepRowOn)(step, sigma, line, depth, from, to);
}

void AddScaled(float* sum, float factor, const float* values, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(AddScaledOn)(sum, factor, values, count);
}

void AddBundle(const Bundle& bundle, float* mean) {
  HWY_DYNAMIC_DISPATCH(AddBundleOn)(bundle, mean);
}

void ExpOfNegative(float* values, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(ExpOfNegativeOn)(values, count);
}

void AddProjection(const float* depth,
                   std::size_t depth_stride,
                   std::size_t directions,
                   const float* factor,
                   std::size_t functions,
                   float* sum,
                   std::size_t sum_stride,
                   std::size_t voxels) {
  HWY_DYNAMIC_DISPATCH(AddProjectionOn)
  (depth, depth_stride, directions, factor, functions, sum, sum_stride, voxels);
}

void ColorProduct(const std::uint16_t* half,
                  std::size_t stride,
                  const float* color,
                  std::size_t functions,
                  float* out,
                  std::size_t count) {
  HWY_DYNAMIC_DISPATCH(ColorProductOn)(half, stride, color, functions, out, count);
}

void ToHalf(const float* values, std::uint16_t* half, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(ToHalfOn)(values, half, count);
}

void FromHalf(const std::uint16_t* half, float* values, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(FromHalfOn)(half, values, count);
}

float SharedSum(const std::uint16_t* share,
                const std::int32_t* index,
                std::size_t count,
                const float* values) {
  return HWY_DYNAMIC_DISPATCH(SharedSumOn)(share, index, count, values);
}

std::uint32_t ReadThrough(const std::uint16_t* half, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(ReadThroughOn)(half, count);
}

}  // namespace relight
#endif
