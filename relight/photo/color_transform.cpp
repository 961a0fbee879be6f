// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/color_transform.h"

#include "relight/base/error.h"
#include "relight/photo/color.h"
#include "relight/photo/icc_profile.h"
#include "relight_ocio.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace relight {
namespace ocio = OCIO_NAMESPACE;
namespace {

constexpr char kLinearRec709[] = "Linear Rec.709";
constexpr char kSrgb[] = "sRGB";

const ocio::ConstConfigRcPtr& OwnConfig() {
  static const ocio::ConstConfigRcPtr config = [] {
    std::istringstream text(kRelightOcio);
    ocio::ConstConfigRcPtr read = ocio::Config::CreateFromStream(text);
    read->validate();
    return read;
  }();
  return config;
}

// What the environment variable OCIO names; empty when it is unset.
std::string GivenConfigPath() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the environment is not written
  const char* given = std::getenv("OCIO");
  return given != nullptr ? given : "";
}

[[noreturn]] void RefuseConfig(const std::string& path, const std::string& reason) {
  throw InputError(path + ": cannot be used as the OpenColorIO config that OCIO names: " +
                   reason + "; mend it, or unset OCIO to use relight's own");
}

ocio::ConstConfigRcPtr GivenConfig(const std::string& path) {
  try {
    ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(path.c_str());
    config->validate();
    if (!config->hasRole(ocio::ROLE_SCENE_LINEAR)) {
      RefuseConfig(path, "it has no role scene_linear");
    }
    return config;
  } catch (const ocio::Exception& e) {
    RefuseConfig(path, e.what());
  }
}

std::vector<std::string> NamesOf(const ocio::ConstConfigRcPtr& config) {
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(config->getNumColorSpaces()));
  for (int i = 0; i < config->getNumColorSpaces(); ++i) {
    names.emplace_back(config->getColorSpaceNameByIndex(i));
  }
  return names;
}

std::string CheckedSpace(const ocio::ConstConfigRcPtr& config, const std::string& name) {
  if (const auto space = config->getColorSpace(name.c_str())) return space->getName();
  std::string known;
  for (const std::string& each : NamesOf(config))
    known += (known.empty() ? "" : ", ") + each;
  throw OptionError("color-space must be one of " + known + "; got " + name);
}

// Without the fast approximations of exp and log, so that values are as exact as floats.
ColorTransform FromProcessor(const ocio::ConstProcessorRcPtr& processor) {
  ColorTransform transform;
  const ocio::ConstCPUProcessorRcPtr cpu =
      processor->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
  if (cpu->isNoOp()) return transform;
  transform.mixes_channels = cpu->hasChannelCrosstalk();
  transform.apply = [cpu](float* rgb, std::size_t pixels) {
    ocio::PackedImageDesc packed(rgb, static_cast<long>(pixels), 1, 3);
    cpu->apply(packed);
  };
  return transform;
}

// The space of our own config with these primaries; empty when there is none.
std::string SpaceOfChromaticities(const std::vector<double>& xy) {
  struct Known {
    const char* space;
    std::array<double, 8> xy;
  };
  static constexpr Known kKnown[] = {
      {kLinearRec709, {.64, .33, .30, .60, .15, .06, .3127, .3290}},
      {"Linear Rec.2020", {.708, .292, .170, .797, .131, .046, .3127, .3290}},
      {"ACEScg", {.713, .293, .165, .830, .128, .044, .32168, .33767}},
      {"ACES2065-1", {.7347, .2653, 0, 1, .0001, -.0770, .32168, .33767}},
  };
  for (const Known& known : kKnown) {
    const bool same = std::equal(
        known.xy.begin(), known.xy.end(), xy.begin(), xy.end(), [](double a, double b) {
          return std::abs(a - b) <
                 1e-3;  // Standards are written with three digits or four
        });
    if (same) return known.space;
  }
  return {};
}

// The space of a file by our own config: what the file says, else sRGB or linear Rec.709.
std::string OwnSpaceOf(const FileColorHints& hints, std::vector<std::string>& notes) {
  if (hints.developed_raw) return kLinearRec709;
  if (hints.scene_linear) {
    if (hints.chromaticities.size() != 8) return kLinearRec709;
    if (std::string known = SpaceOfChromaticities(hints.chromaticities); !known.empty()) {
      return known;
    }
    notes.push_back(
        "Its primaries are none that relight knows; the colours are taken as Rec.709. "
        "Give --color-space if they are not.");
    return kLinearRec709;
  }
  const std::string& icc = hints.icc_description;
  if (icc.empty() && hints.icc_profile.empty()) return kSrgb;
  if (icc.find("sRGB") != std::string::npos) return kSrgb;
  if (icc.find("Display P3") != std::string::npos) return "Display P3";
  if (icc.find("Adobe RGB") != std::string::npos) return "Adobe RGB (1998)";
  notes.push_back("Its colour profile " + (icc.empty() ? "" : "\"" + icc + "\" ") +
                  "is none that relight knows; the colours are taken as sRGB. "
                  "Give --color-space if they are not.");
  return kSrgb;
}

ColorTransform OwnTransform(const std::string& space) {
  if (space == kLinearRec709) return {};
  if (space == kSrgb) {
    // OpenColorIO derives slope and break of the curve from its exponent, which is 2.5e-4
    // off [sRGB] in the shadows: the closed form instead.
    ColorTransform transform;
    transform.apply = [](float* rgb, std::size_t pixels) {
      for (std::size_t i = 0; i < 3 * pixels; ++i) rgb[i] = LinearFromSrgb(rgb[i]);
    };
    return transform;
  }
  return FromProcessor(OwnConfig()->getProcessor(space.c_str(), ocio::ROLE_SCENE_LINEAR));
}

// By the profile's own curves and primaries.
ColorTransform ProfileTransform(const IccProfile& profile) {
  ColorTransform transform;
  transform.mixes_channels = true;
  transform.apply = [profile](float* rgb, std::size_t pixels) {
    for (std::size_t i = 0; i < pixels; ++i, rgb += 3) {
      std::array<double, 3> linear{};
      for (int c = 0; c < 3; ++c)
        linear[static_cast<std::size_t>(c)] = profile.Linear(c, rgb[c]);
      for (std::size_t row = 0; row < 3; ++row) {
        const std::array<double, 3>& m = profile.rec709_from_rgb[row];
        rgb[row] =
            static_cast<float>(m[0] * linear[0] + m[1] * linear[1] + m[2] * linear[2]);
      }
    }
  };
  return transform;
}

// The profile that a display-encoded file brings, when it is other than sRGB.
std::optional<IccProfile> ProfileOf(const FileColorHints& hints) {
  if (hints.scene_linear || hints.icc_profile.empty()) return std::nullopt;
  return ReadIccProfile(hints.icc_profile);
}

}  // namespace

ColorTransform SceneLinearFromFile(const FileColorHints& hints,
                                   const std::optional<std::string>& chosen_space) {
  const std::string path = GivenConfigPath();
  if (path.empty() || hints.developed_raw) {
    if (const auto profile = ProfileOf(hints); profile && !chosen_space) {
      return profile->IsSrgb() ? OwnTransform(kSrgb) : ProfileTransform(*profile);
    }
    std::vector<std::string> notes;
    const std::string space = chosen_space && !hints.developed_raw
                                  ? CheckedSpace(OwnConfig(), *chosen_space)
                                  : OwnSpaceOf(hints, notes);
    ColorTransform transform = OwnTransform(space);
    transform.notes = std::move(notes);
    return transform;
  }

  // A config of the user's: its rule for the file, its scene_linear, and from there to
  // Rec.709 through ACES2065-1 where it says how
  const ocio::ConstConfigRcPtr config = GivenConfig(path);
  const std::string space =
      chosen_space ? CheckedSpace(config, *chosen_space)
                   : config->getColorSpaceFromFilepath(hints.file_name.c_str());
  try {
    const bool interchange = config->hasRole(ocio::ROLE_INTERCHANGE_SCENE);
    ColorTransform transform = FromProcessor(
        interchange ? ocio::Config::GetProcessorFromConfigs(
                          config, space.c_str(), OwnConfig(), ocio::ROLE_SCENE_LINEAR)
                    : config->getProcessor(space.c_str(), ocio::ROLE_SCENE_LINEAR));
    transform.notes.push_back("Colour space " + space + ", by the OpenColorIO config " +
                              path + ".");
    if (!interchange) {
      transform.notes.push_back(
          "That config has no role aces_interchange, so its scene_linear is taken as it "
          "is: "
          "as linear Rec.709.");
    }
    return transform;
  } catch (const ocio::Exception& e) {
    RefuseConfig(path, e.what());
  }
}

std::vector<std::string> ColorSpaceNames() {
  const std::string path = GivenConfigPath();
  return NamesOf(path.empty() ? OwnConfig() : GivenConfig(path));
}

}  // namespace relight
