// SPDX-License-Identifier: Apache-2.0
#include "cli/view_options.h"

#include "cli/flags.h"
#include "relight/capture/transport_options.h"

namespace relight::cli {

void AddViewOptions(CLI::App& app, ViewRequest& r) {
  app.add_option("source", r.source, "capture folder, or one photo")
      ->required()
      ->type_name("DIR|PHOTO");
  app.add_option("--view", r.view, "which photo of the capture [the first]")
      ->type_name("NAME");
  app.add_option(
         "--photo", r.photo, "a retouched or rendered picture in place of the view's own")
      ->type_name("FILE");

  const char* facts = "What the photo does not say itself";
  app.add_option(
         "--place", r.place, "where: latitude and longitude, north and east positive")
      ->type_name("LAT,LON")
      ->group(facts);
  app.add_option("--zone", r.zone, "time zone: Europe/Paris or +02:00")
      ->type_name("NAME")
      ->group(facts);
  app.add_option("--taken", r.taken, "when the photo was taken")
      ->type_name("WHEN")
      ->group(facts);
  app.add_option("--heading", r.heading, "where the camera looked, from true north")
      ->type_name("DEG|SW")
      ->group(facts);
  app.add_option(
         "--lit-from", r.lit_from, "in place of all these: the sun as the camera saw it")
      ->type_name("AZ,EL")
      ->group(facts);
  app.add_option(
         "--matte", r.matte, "which pixels are tree: a grey picture, or one with alpha")
      ->type_name("FILE")
      ->group(facts);
  app.add_option("--distance",
                 r.distance_m,
                 "one photo alone: camera to tree; left out, the tree is 8 m high")
      ->type_name("M")
      ->check(CLI::PositiveNumber.description(""))
      ->group(facts);
}

void AddModelOptions(CLI::App& app, ViewRequest& r) {
  AddFlags(app, LightOptions(), "Light", r.options);
  AddFlags(app, OurTransport(), "Light", r.options);
  AddFlags(app, NeighbourOptions(), "Light", r.options);
  AddFlags(app, CorrectionOptions(), "Light", r.options);
  AddFlags(app, LightFitOptions(), "Light", r.options);
  AddFlags(app, ReadPhotoOptions(), "Photo", r.options);
  AddFlags(app, MatteOptions(), "Matte", r.options);
  AddFlags(app, OpacityOptions(), "Volume", r.options);
  AddFlags(app, VolumeBoxOptions(), "Volume", r.options);
  AddFlags(app, ViewSelectionOptions(), "Volume", r.options);
  AddFlags(app, CrownOptions(), "Volume", r.options);
  AddFlags(app, SkyTransmittanceOptions(), "Volume", r.options);
  AddFlags(app, GroundShadowOptions(), "Shadow", r.options);
  AddFlags(app, OldShadowOptions(), "Shadow", r.options);
}

}  // namespace relight::cli
