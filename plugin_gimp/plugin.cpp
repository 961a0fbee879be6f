// SPDX-License-Identifier: Apache-2.0

// plug-in-relight-tree: Filters > Light and Shadow > Relight Tree… of GIMP 2.10.

#include "plugin_gimp/beside.h"
#include "plugin_gimp/dialog.h"
#include "plugin_gimp/layers.h"
#include "plugin_gimp/relighting.h"
#include "plugin_gimp/settings.h"
#include "relight/base/error.h"
#include "relight/base/version.h"

#include <libgimp/gimp.h>
#include <libgimp/gimpui.h>

#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace relight::gimp {
namespace {

constexpr const char* kProcedure = "plug-in-relight-tree";
constexpr int kFirstText = 3;  // After run mode, image and drawable: texts, then shadow.

void Query() {
  const auto param = [](GimpPDBArgType type, const char* name, const char* help) {
    return GimpParamDef{type, const_cast<char*>(name), const_cast<char*>(help)};
  };
  std::vector<GimpParamDef> arguments = {
      param(GIMP_PDB_INT32,
            "run-mode",
            "The run mode { RUN-INTERACTIVE (0), RUN-NONINTERACTIVE (1), "
            "RUN-WITH-LAST-VALS (2) }"),
      param(GIMP_PDB_IMAGE, "image", "The image"),
      param(GIMP_PDB_DRAWABLE,
            "drawable",
            "The layer: a photo of a capture, or a tree cut out with alpha")};
  for (const TextField& field : kTextFields)
    arguments.push_back(param(GIMP_PDB_STRING, field.name, field.help));
  arguments.push_back(
      param(GIMP_PDB_INT32, "shadow", "A layer with the tree's shadow { FALSE, TRUE }"));
  const GimpParamDef result = param(GIMP_PDB_LAYER, "tree", "The relit tree's layer");
  gimp_install_procedure(
      kProcedure,
      "Relight a photographed tree to another hour",
      "Adds a layer group with the tree as the sun and sky of another hour would light "
      "it, "
      "and with its shadow; the layer itself is hidden and keeps its pixels. Texts are "
      "as "
      "for the program relight; an empty one is not said, or taken from what was said of "
      "this layer before. One of to, to-light and like has to be given.",
      "The authors of relight",
      "The authors of relight, Apache-2.0",
      "2026",
      "Relight _Tree...",
      "*",
      GIMP_PLUGIN,
      static_cast<gint>(arguments.size()),
      1,
      arguments.data(),
      &result);
  gimp_plugin_menu_register(kProcedure, "<Image>/Filters/Light and Shadow");
}

// Of this session of GIMP.
std::optional<Settings> LastValues() {
  const gint size = gimp_get_data_size(kProcedure);
  if (size <= 0) return {};
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!gimp_get_data(kProcedure, text.data())) return {};
  return SettingsFrom(text);
}

void RememberValues(const Settings& settings) {
  const std::string text = TextOf(settings);
  gimp_set_data(kProcedure, text.data(), static_cast<guint32>(text.size()));
}

// The photo's facts of one, the wanted light of the other.
Settings Joined(const std::optional<Settings>& photo, const Settings& wanted) {
  Settings joined = wanted;
  for (const TextField& field : kTextFields) {
    if (field.of_photo && photo) joined.*field.text = (*photo).*field.text;
  }
  return joined;
}

Settings ArgumentsOf(gint count,
                     const GimpParam* values,
                     const std::optional<Settings>& kept) {
  const auto texts = static_cast<gint>(kTextFields.size());
  if (count != kFirstText + texts + 1) {
    throw OptionError(
        "plug-in-relight-tree takes " + std::to_string(kFirstText + texts + 1) +
        " arguments (see the procedure browser), got " + std::to_string(count));
  }
  Settings s;
  for (gint i = 0; i < texts; ++i) {
    const TextField& field = kTextFields[static_cast<std::size_t>(i)];
    const char* text = values[kFirstText + i].data.d_string;
    s.*field.text = text != nullptr ? text : "";
    // The layer's light and its facts stay with it
    if (field.of_photo && (s.*field.text).empty() && kept)
      s.*field.text = (*kept).*field.text;
  }
  s.shadow = values[kFirstText + texts].data.d_int32 != 0;
  return s;
}

// The tree's layer; nothing when the user cancelled.
std::optional<gint32> RelightLayer(gint count, const GimpParam* values) {
  const auto mode = static_cast<GimpRunMode>(values[0].data.d_int32);
  const gint32 image = values[1].data.d_image, layer = values[2].data.d_drawable;
  const std::optional<Settings> kept = SettingsOf(layer), last = LastValues();

  Relighting relighting(ReadLayer(image, layer));
  std::optional<Accepted> accepted;
  if (mode == GIMP_RUN_INTERACTIVE) {
    Settings wanted = kept ? *kept : last.value_or(Settings());
    if (!kept) wanted = Joined(Settings(), wanted);  // Of this layer nothing was said yet
    accepted = RunDialog(relighting, wanted);
    if (!accepted) return {};
  } else {
    if (mode == GIMP_RUN_WITH_LAST_VALS && !last) {
      throw OptionError(
          "nothing to repeat yet; use Filters > Light and Shadow > Relight Tree... "
          "first");
    }
    const Settings settings = mode == GIMP_RUN_WITH_LAST_VALS
                                  ? Joined(kept, *last)
                                  : ArgumentsOf(count, values, kept);
    gimp_progress_init("Relighting the tree");
    accepted = Accepted{relighting.Completed(settings),
                        Beside(
                            [&](const Progress& progress) {
                              return relighting.Relight(settings, progress);
                            },
                            [](double done) {
                              gimp_progress_update(done);
                              return true;
                            })};
  }
  const gint32 tree = AddLayers(image, layer, accepted->relit, accepted->settings);
  RememberValues(accepted->settings);
  if (mode != GIMP_RUN_NONINTERACTIVE) gimp_displays_flush();
  return tree;
}

void Run(const gchar*,
         gint count,
         const GimpParam* values,
         gint* results_count,
         GimpParam** results) {
  static GimpParam result[2];
  static std::string message;
  result[0].type = GIMP_PDB_STATUS;
  *results = result;
  *results_count = 2;
  const auto fail = [&](GimpPDBStatusType status, const std::string& text) {
    message = text;
    result[0].data.d_status = status;
    result[1].type = GIMP_PDB_STRING;
    result[1].data.d_string = message.data();
  };
  try {
    gegl_init(nullptr, nullptr);
    if (const auto tree = RelightLayer(count, values)) {
      result[0].data.d_status = GIMP_PDB_SUCCESS;
      result[1].type = GIMP_PDB_LAYER;
      result[1].data.d_layer = *tree;
    } else {
      result[0].data.d_status = GIMP_PDB_CANCEL;
      *results_count = 1;
    }
  } catch (const Cancelled&) {
    result[0].data.d_status = GIMP_PDB_CANCEL;
    *results_count = 1;
  } catch (const OptionError& error) {
    fail(GIMP_PDB_CALLING_ERROR, InWordsOfDialog(error.what()));
  } catch (const Error& error) {
    fail(GIMP_PDB_EXECUTION_ERROR, InWordsOfDialog(error.what()));
  } catch (const std::bad_alloc&) {
    fail(GIMP_PDB_EXECUTION_ERROR,
         "There is not enough memory for a layer of this size; scale it down");
  } catch (const std::exception& error) {
    fail(GIMP_PDB_EXECUTION_ERROR,
         std::string(error.what()) + " (an error of Relight Tree; please report it)");
  }
}

}  // namespace
}  // namespace relight::gimp

int main(int argc, char** argv) {
  // For `relight gimp --check`, which asks whether it starts at all
  if (argc == 2 && std::string_view(argv[1]) == "--version") {
    std::fprintf(stderr, "relight-tree %s\n", relight::Version());
    return 0;
  }
  const GimpPlugInInfo info = {
      nullptr, nullptr, relight::gimp::Query, relight::gimp::Run};
  return gimp_main(&info, argc, argv);
}
