// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every verb that relights a view is told about it, in the same words.

#include "relight/capture/view_plan.h"

#include <CLI/CLI.hpp>

namespace relight::cli {

// Source, --view, --photo, and what the photo does not say itself.
void AddViewOptions(CLI::App& app, ViewRequest& request);

// CaptureOptions: how light, volume and shadow are modelled.
void AddModelOptions(CLI::App& app, ViewRequest& request);

}  // namespace relight::cli
