// SPDX-License-Identifier: Apache-2.0
#pragma once

// A capture folder (docs/architecture.md): capture.toml, photos/, cameras/, trimaps/,
// scribbles/, mattes/, volume.vdb, cache/, out/. Every file in it may come from anywhere:
// names that lead out of the folder are refused.

#include "relight/base/field_text.h"
#include "relight/cameras/camera.h"
#include "relight/capture/capture_file.h"
#include "relight/capture/light_options.h"
#include "relight/capture/photo_matte.h"
#include "relight/capture/transport_options.h"
#include "relight/capture/view_selection.h"
#include "relight/composite/ground_shadow.h"
#include "relight/composite/old_shadow.h"
#include "relight/photo/write_photo.h"
#include "relight/ratio/correction.h"
#include "relight/ratio/light_fit.h"
#include "relight/volume/opacity_estimation.h"
#include "relight/volume/silhouette_volume.h"
#include "relight/volume/visual_hull.h"

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace relight {

// All that capture.toml's [options] and the command line may set, under one name each.
struct CaptureOptions {
  LightOptions light;
  CorrectionOptions correction;
  LightFitOptions fit;
  OpacityOptions volume;
  VolumeBoxOptions box;
  CrownOptions crown;
  ViewSelectionOptions selection;
  SkyTransmittanceOptions sky_transmittance;
  ArrivingLightOptions transport = OurTransport();  // Of the default method.
  NeighbourOptions neighbours;
  ReadPhotoOptions photo;
  MatteOptions matte;
  GroundShadowOptions shadow;
  OldShadowOptions old_shadow;
};

template <class Visitor>
void Describe(CaptureOptions& o, Visitor&& field) {
  Describe(o.light, field);
  Describe(o.correction, field);
  Describe(o.fit, field);
  Describe(o.volume, field);
  Describe(o.box, field);
  Describe(o.crown, field);
  Describe(o.selection, field);
  Describe(o.sky_transmittance, field);
  Describe(o.transport, field);
  Describe(o.neighbours, field);
  Describe(o.photo, field);
  Describe(o.matte, field);
  Describe(o.shadow, field);
  Describe(o.old_shadow, field);
}

// Options by name, those of the user over those of capture.toml. Throws OptionError that
// names the option and what it may be; for one of capture.toml InputError with its line.
CaptureOptions OptionsFrom(const CaptureFile& file,
                           const std::map<std::string, std::string>& from_user);

struct Capture {
  std::filesystem::path folder;
  CaptureFile file;

  std::filesystem::path PhotoOf(const ViewEntry& view) const {
    return folder / view.photo;
  }
};

// Throws InputError: no folder, or no capture.toml in it ("relight init" makes one), and
// as ReadCaptureFile does.
Capture OpenCapture(const std::filesystem::path& folder);

// Throws InputError that lists the views there are.
const ViewEntry& FindView(const Capture& capture, const std::string& name);

// The capture that a photo lies in (its folder, or the one above) and the view it is: its
// file, else the view of its name without extension. Nothing when there is none.
struct CaptureView {
  std::filesystem::path folder;
  std::string view;
};
std::optional<CaptureView> CaptureOfPhoto(const std::filesystem::path& photo);

// The photo's own file below `subfolder` (mattes, trimaps), whatever its extension among
// those of images; nothing when there is none.
std::optional<std::filesystem::path> FileOfView(const Capture& capture,
                                                const std::string& subfolder,
                                                const std::string& view);

// Cameras of the views that have one, from cameras/. Throws InputError: none there (make
// them), a camera without photo; each with the command that mends it.
std::map<std::string, Camera> CamerasOf(const Capture& capture);

// Makes or completes the capture in `folder` from photos (files, or folders of them):
// copies photos that lie elsewhere into photos/, writes capture.toml. What is there
// already is kept as it is. Throws InputError: no photo, two photos of one name (given,
// or already in photos/), a result of relight.
Capture InitCapture(const std::filesystem::path& folder,
                    std::span<const std::filesystem::path> photos);

}  // namespace relight
