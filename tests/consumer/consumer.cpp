// SPDX-License-Identifier: Apache-2.0

// Somebody else's program: calls a compiled function of an installed relight, and one
// that lives in a header, and checks both against what they must be.

#include <relight/base/angles.h>
#include <relight/base/content_hash.h>
#include <relight/base/parallel.h>

#include <cmath>
#include <cstdio>

int main() {
  // XXH3, 128 bits, of no bytes: a published constant of the algorithm (xxHash, seed 0)
  const bool hashes = relight::HashOfText("") == "99aa06d3014798d86001c324468d497f";

  int sum = 0;
  relight::ParallelRanges(10, 10, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) sum += i;
  });

  // Due east on the horizon is +x; 1e-15 is a few roundings of cos(pi / 2)
  const Eigen::Vector3d east =
      relight::DirectionFromAzimuthElevation(relight::RadFromDeg(90.0), 0.0);
  const bool turns = (east - Eigen::Vector3d::UnitX()).norm() < 1e-15;

  std::printf("hash %d, sum %d, east %d\n", hashes, sum, turns);
  return hashes && sum == 45 && turns ? 0 : 1;
}
