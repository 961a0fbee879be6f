// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which views a volume is made from, when there are many: each costs a matte and its
// share of every pass, and views between two others add little to them (docs/capture.md).

#include "relight/base/field.h"
#include "relight/cameras/camera.h"

#include <map>
#include <string>
#include <vector>

namespace relight {

struct ViewSelectionOptions {
  int most_views = 12;  // For mattes and volume.
};

template <class Visitor>
void Describe(ViewSelectionOptions& o, Visitor&& field) {
  field(o.most_views,
        FieldInfo{"most-views",
                  "",
                  "views that mattes and volume are made from, evenly around the tree",
                  Between(2, 10000)});
}

// All cameras when there are no more than `most_views`; else so many whose azimuths
// around the tree's foot, the origin of the world, are farthest apart: of all choices the
// one whose smallest step is largest, the first by name among equals. So a full circle is
// taken in even steps, half a circle with its ends.
std::map<std::string, Camera> EvenlySpreadViews(
    const std::map<std::string, Camera>& cameras, const ViewSelectionOptions& options);

}  // namespace relight
