// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a user of the plug-in says: the arguments of the procedure, the fields of the
// dialog, what stays with a layer and what is repeated.

#include <array>
#include <string>

namespace relight::gimp {

// Texts as on the command line (relight/capture/hour_plan.h); empty: not said.
struct Settings {
  std::string to, to_light, like;
  std::string exposure = "same";
  bool shadow = true;
  std::string lit_from;
  std::string capture, view;
  std::string place, zone, taken, heading;
};

struct TextField {
  std::string Settings::*text;
  const char* name;    // Of the procedure's argument, and what it is stored under.
  const char* option;  // Of the command line, as messages of the library name it.
  const char* label;   // In the dialog.
  const char* help;
  bool of_photo;  // A fact of the layer; else of the light that is wanted.
};

// All texts, in the order of the procedure's arguments.
inline constexpr std::array<TextField, 11> kTextFields = {{
    {&Settings::to,
     "to",
     "--to",
     "Date and hour",
     "Wanted hour: 17:00, 2011-09-23T17:00, +3h",
     false},
    {&Settings::exposure,
     "exposure",
     "--exposure",
     "Exposure",
     "same (evening is dark), auto, or stops; empty: same",
     false},
    {&Settings::lit_from,
     "lit-from",
     "--lit-from",
     "Light in the photo from",
     "AZ,EL in degrees as the camera sees it, when no clock is known",
     true},
    {&Settings::to_light,
     "to-light",
     "--to-light",
     "Light wanted from",
     "AZ,EL in degrees as the camera sees it, in place of the hour",
     false},
    {&Settings::like,
     "like",
     "--like",
     "As in the picture",
     "File of a photo whose light is wanted, in place of the hour",
     false},
    {&Settings::capture,
     "capture",
     "DIR",
     "Capture folder",
     "Folder of the capture; empty: found beside the image file, or none",
     true},
    {&Settings::view,
     "view",
     "--view",
     "View",
     "Which photo of the capture the layer is; empty: by its name",
     true},
    {&Settings::place, "place", "--place", "Place", "LAT,LON of the photo", true},
    {&Settings::zone,
     "zone",
     "--zone",
     "Time zone",
     "Of the photo: Europe/Paris or +02:00",
     true},
    {&Settings::taken,
     "taken",
     "--taken",
     "Taken",
     "When the photo was taken: 2011-07-22T13:00",
     true},
    {&Settings::heading,
     "heading",
     "--heading",
     "Heading",
     "Where the camera looked: 210 or SW",
     true},
}};

// One line a field; what `text` does not know keeps its value.
std::string TextOf(const Settings& settings);
Settings SettingsFrom(const std::string& text);

// A message of the library in the words of the dialog: fields in place of options, and
// without the command that would give them.
std::string InWordsOfDialog(std::string message);

}  // namespace relight::gimp
