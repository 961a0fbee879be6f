// SPDX-License-Identifier: Apache-2.0
#pragma once

// Transmittance of the volume from each voxel to the whole sphere, in real spherical
// harmonics (docs/conventions.md#sh), made once for a tree:
//
//   c_lm(u) = integral over the full sphere of tau(u, w) Y_lm(w) dw       (S1)
//
// so that the light of any sky is a product of coefficients: the inner part of
// [Cabral11, Eq. 16], whose outer integral along the view ray is linear and done in
// single_scattering.h. tau is never cut at the horizon (a step there would cost bands);
// the sky itself is zero below it. The integral is the mean over directions spread
// evenly, each swept through the whole grid at once (swept_transmittance.h). Kept as half
// floats: 72 bytes a voxel with 6 bands.

#include "relight/base/field.h"
#include "relight/base/progress.h"
#include "relight/scattering/occluder.h"
#include "relight/volume/extinction_grid.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace relight {

struct SkyTransmittanceOptions {
  int bands = 6;          // [Cabral11 §5]: 6 bands, 36 coefficients.
  int directions = 1024;  // Over the full sphere, for (S1).
};

template <class Visitor>
void Describe(SkyTransmittanceOptions& o, Visitor&& field) {
  field(o.bands,
        FieldInfo{"sh-bands", "", "bands of spherical harmonics", Between(1, 8)});
  field(o.directions,
        FieldInfo{"sh-directions",
                  "",
                  "directions that transmittance is projected from",
                  Between(64, 65536)});
}

struct SkyTransmittance {
  int bands = 0;
  std::size_t voxels = 0;           // The non-empty ones, in the order of FindOccupied.
  std::vector<std::uint16_t> half;  // c_lm as half floats, [bands^2][voxel].

  float Coefficient(int function, std::size_t voxel) const;
};

// To half floats, to the nearest, and back. values[bands^2][voxel].
SkyTransmittance PackedSky(int bands, const std::vector<std::vector<float>>& values);
std::vector<std::vector<float>> UnpackedSky(const SkyTransmittance& sky);

// The first bands of more.
SkyTransmittance FirstBands(const SkyTransmittance& sky, int bands);

// With `occluder`, where given, beside the tree; `clumping`: k of (S9), arriving_light.h.
// Throws OptionError, Cancelled. The result does not depend on the threads.
SkyTransmittance ProjectTransmittance(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const SkyTransmittanceOptions& options = {},
                                      const Progress& progress = {},
                                      const Occluder* occluder = nullptr,
                                      double clumping = 0.0);

}  // namespace relight
