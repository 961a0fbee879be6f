// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/accuracy_notes.h"

#include "relight/base/angles.h"

#include <cmath>
#include <sstream>

namespace relight {
namespace {

constexpr double kLowSun_rad = RadFromDeg(25);   // [Cabral11, §8] warns below it
constexpr double kAgainst_rad = RadFromDeg(60);  // Between view and sun
constexpr std::size_t kFewViews = 8;
// Above them trees of other kinds than those learned from came out that much worse than
// below: relight/ratio/training/train --judge (docs/validation.md)
constexpr double kGlistening = 0.9, kLargeLeaves = 0.25;
constexpr double kLittleTrust = 0.6;
constexpr double kClearMisfit = 0.15;  // As sky_turbidity.h has it

}  // namespace

std::vector<std::string> AccuracyNotes(const AccuracyFacts& facts,
                                       const Correction& correction) {
  std::vector<std::string> notes;
  std::ostringstream text;
  text.precision(2);
  const double low_deg = DegFromRad(facts.input.elevation_rad);
  if (facts.input.elevation_rad < kLowSun_rad) {
    text << "the sun of the photo is low, at " << low_deg
         << " deg: on rendered trees other hours came out 0.1 to 0.8 dB worse, in the "
            "mean, than from a photo of about noon";
    notes.push_back(text.str());
  }
  if (facts.views > 1 && facts.views < kFewViews) {
    text.str("");
    text << "the volume is made from " << facts.views
         << " photos: 6 cost 0.5 dB on rendered trees, 4 cost 1.3; more, from all sides, "
            "are better";
    notes.push_back(text.str());
  }
  const Eigen::Vector3d view = DirectionFromAzimuthElevation(facts.heading_rad, 0);
  if (AngleBetween(view, facts.input.direction) < kAgainst_rad) {
    notes.push_back(
        "the photo is taken against the sun: most of the leaves that it shows are in "
        "shade, and what lights them is known less well than the sun");
  }
  if (facts.air && facts.air->misfit > kClearMisfit) {
    notes.push_back(
        "the sky of the photos is not clear: a photo under an overcast sky that is taken "
        "for a clear one costs 3 dB; --input-sky overcast says so");
  }
  if (facts.contrast && facts.contrast->inside_patches > kGlistening) {
    text.str("");
    text << "the tree's leaves glisten or catch the sun singly (local contrast "
         << facts.contrast->inside_patches << ", up to " << kGlistening
         << " is usual): such rendered trees came out 2.4 dB less exact";
    notes.push_back(text.str());
  }
  if (facts.contrast && facts.contrast->between_patches > kLargeLeaves) {
    text.str("");
    text << "leaves or their clusters are many times larger than a voxel (contrast over "
            "1/40 of the height "
         << facts.contrast->between_patches << ", up to " << kLargeLeaves
         << " is usual): such rendered trees came out 3.4 dB less exact";
    notes.push_back(text.str());
  }
  if (correction.mean_trust < kLittleTrust) {
    text.str("");
    text
        << "this tree or its light is unlike those that the correction has learned from: "
           "it counts "
        << std::lround(100 * correction.mean_trust)
        << " %, the rest is the simulation alone";
    notes.push_back(text.str());
  }
  return notes;
}

}  // namespace relight
