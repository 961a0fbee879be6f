// SPDX-License-Identifier: Apache-2.0
#pragma once

// Densification of sparse neighbourhoods [Cabral11 §7.1]: each non-empty voxel with fewer
// than 8 non-empty ones among its 26 neighbours gives those of its 6 axial neighbours
// that are empty the mean extinction of the axial ones that are not. An option: with good
// cameras and mattes it costs accuracy (docs/validation.md).

#include "relight/volume/extinction_grid.h"

#include <cstddef>

namespace relight {

// Fills `grid` in place and answers how many voxels it filled. All neighbours are looked
// at as they were before.
std::size_t Densify(ExtinctionGrid& grid);

}  // namespace relight
