// SPDX-License-Identifier: Apache-2.0
#pragma once

// The dialog of the plug-in: both lights, a preview, and what is known of the photo.

#include "plugin_gimp/relighting.h"
#include "plugin_gimp/settings.h"

#include <optional>

namespace relight::gimp {

// A layer relit, and by which settings.
struct Accepted {
  Settings settings;
  RelitLayers relit;
};

// Shows the dialog, beginning with `settings`, and relights on OK. Nothing when the user
// cancelled. A mistake is said in the dialog, which stays.
std::optional<Accepted> RunDialog(Relighting& relighting, const Settings& settings);

}  // namespace relight::gimp
