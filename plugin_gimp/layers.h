// SPDX-License-Identifier: Apache-2.0
#pragma once

// Layers of GIMP to linear pixels and back, and what stays with a layer.

#include "plugin_gimp/relighting.h"
#include "plugin_gimp/settings.h"

#include <libgimp/gimp.h>

#include <optional>

namespace relight::gimp {

// The layer without its offsets, in linear Rec.709 whatever the image's precision and
// profile; its mask, where it is applied, is a part of its alpha. Throws InputError, with
// the remedy, for what is no layer of colour, and for what does not fit into the memory.
LayerPicture ReadLayer(gint32 image, gint32 drawable);

// What was said of this layer before.
std::optional<Settings> SettingsOf(gint32 layer);

// One step of undo: the group "Relit WHEN" over the hidden layer, with "Tree WHEN" and
// "Shadow WHEN". The layer keeps its pixels, and `settings`. Answers the tree's layer.
gint32 AddLayers(gint32 image,
                 gint32 layer,
                 const RelitLayers& relit,
                 const Settings& settings);

}  // namespace relight::gimp
