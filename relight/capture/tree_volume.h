// SPDX-License-Identifier: Apache-2.0
#pragma once

// The volume of a capture and its transmittance to the sky, made when they are not up to
// date: volume.vdb from the views' mattes and cameras, cache/light.vdb from it.

#include "relight/base/progress.h"
#include "relight/capture/capture.h"
#include "relight/capture/stage_records.h"
#include "relight/scattering/occluder.h"
#include "relight/scattering/sky_transmittance.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/matte_agreement.h"
#include "relight/volume/opacity_estimation.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace relight {

struct Tree {
  ExtinctionGrid grid;
  OccupiedVoxels occupied;
  SkyTransmittance sky_transmittance;
  std::shared_ptr<const Occluder> occluder = {};  // Unset: nothing beside the tree.
};

// The occluder that the options name. Throws InputError as ReadOccluder does.
std::shared_ptr<const Occluder> OccluderOf(const CaptureOptions& options);

// Cameras of the views that the volume is made from (view_selection.h). Throws as
// CamerasOf does.
std::map<std::string, Camera> VolumeCamerasOf(const Capture& capture,
                                              const CaptureOptions& options);

// Their views, and those in `others` that have a camera: all that need a matte.
std::map<std::string, Camera> CamerasToMatte(const Capture& capture,
                                             const CaptureOptions& options,
                                             const std::vector<std::string>& others);

// "mattes and volume are made from 12 of 60 views, …"; empty when they are all.
std::string SelectionNote(const Capture& capture, const CaptureOptions& options);

// The same views with their mattes, no finer than the volume can use.
std::vector<MatteView> MatteViewsOf(const Capture& capture,
                                    const CaptureOptions& options);

// Whether volume.vdb, or cache/light.vdb, would be made now.
bool VolumeIsStale(const Capture& capture,
                   const StageRecords& records,
                   const CaptureOptions& options,
                   bool force);
bool LightIsStale(const Capture& capture,
                  const StageRecords& records,
                  const CaptureOptions& options,
                  bool force);

// Makes volume.vdb. Mattes have to be there. Its box is --box, or as the mattes show the
// tree, helped by the sparse points of cameras/ (point_bounds.h). Throws as
// EstimateOpacity does.
struct MadeVolume {
  OpacitySummary summary;
  std::string box_from;  // In words: "--box", "the mattes".
  MatteAgreement agreement;
  bool box_needed_points = false;
};
// What a user is to know of it; empty when all is well.
std::string AgreementInWords(const MatteAgreement& agreement);
MadeVolume MakeVolume(const Capture& capture,
                      StageRecords& records,
                      const CaptureOptions& options,
                      const Progress& progress);

// A volume made from all views but one, judged by that one's matte (MatteRmse). The
// capture's own volume stays as it is. Throws InputError when there is no such view among
// those that the volume is made from.
struct HeldOut {
  double rmse = 0.0;       // Of the view left out.
  double rmse_used = 0.0;  // Mean over the views used.
  OpacitySummary summary = {};
};
HeldOut JudgeVolume(const Capture& capture,
                    const CaptureOptions& options,
                    const std::string& left_out,
                    const Progress& progress);

// Reads the volume; reads or makes its transmittance to the sky.
Tree TreeOf(const Capture& capture,
            StageRecords& records,
            const CaptureOptions& options,
            bool force,
            const Progress& progress);

// cache/light.vdb, the only thing of a capture that is kept for speed alone: by content
// of the volume and options, and only below kMostLightBytes.
inline constexpr std::uintmax_t kMostLightBytes = std::uintmax_t{1} << 30;
struct LightCache {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  bool is_ours = false;  // As relight made it; anything else is left alone.
};
std::optional<LightCache> LightCacheOf(const Capture& capture);

// Removes it when it is ours, and tells what it was. Throws InputError when cache/ is a
// link out of the capture, or the file cannot be removed.
std::optional<LightCache> CleanLight(const Capture& capture);

// A capture's volume.vdb is not as relight made it: edited since, or somebody's own. Only
// `force` makes such a one again.
bool VolumeIsEdited(const Capture& capture, const StageRecords& records);

}  // namespace relight
