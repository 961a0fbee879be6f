// SPDX-License-Identifier: Apache-2.0
#include "plugin_gimp/layers.h"

#include "relight/base/error.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace relight::gimp {
namespace {

constexpr const char* kSettings = "relight-tree";       // Parasite of an original.
constexpr const char* kResult = "relight-tree-result";  // Of what was made from it.
constexpr int kRowsAtOnce = 64;

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
using Buffer = std::unique_ptr<GeglBuffer, Unref>;

std::string Taken(char* text) {
  const std::string copy = text != nullptr ? text : "";
  g_free(text);
  return copy;
}

// What the work holds at once, in float: photo, colours, result and shadow of three
// channels, the alpha, and copies on the way.
void RequireMemory(const std::string& name, int width, int height) {
  constexpr double kBytesPerPixel = 100;
  const double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<double>(sysconf(_SC_PAGE_SIZE));
  const double needed = kBytesPerPixel * width * height;
  if (needed <= there) return;
  const auto gigabytes = [](double bytes) {
    return std::to_string(static_cast<int>(std::ceil(bytes / 1e9))) + " GB";
  };
  throw InputError(name + " is " + std::to_string(width) + " x " +
                   std::to_string(height) + " pixels, which takes some " +
                   gigabytes(needed) + " of memory, and this computer has " +
                   gigabytes(there) +
                   "; crop the layer to the tree (Layer > Crop to Content) or scale it "
                   "down");
}

void RequireColourLayer(gint32 drawable, const std::string& name) {
  if (!gimp_item_is_layer(drawable)) {
    throw InputError(name +
                     " is a channel or a mask; select the layer that shows the tree");
  }
  if (gimp_item_is_group(drawable)) {
    throw InputError(
        name +
        " is a layer group; select a layer in it, or merge it first (Layer > "
        "Merge Layer Group)");
  }
  if (!gimp_drawable_is_rgb(drawable)) {
    throw InputError(name +
                     " is grey or of indexed colours; convert the image first: Image > "
                     "Mode > RGB");
  }
  GimpParasite* result = gimp_item_get_parasite(drawable, kResult);
  if (result == nullptr) return;
  gimp_parasite_free(result);
  throw InputError(
      name +
      " is a result of Relight Tree, and a result is not relit again; select "
      "the layer that it was made from");
}

// The pixels of a layer or mask. libgimp 2.10 gives them as sRGB whatever the image's
// profile is, so that a layer's own is said here.
Buffer BufferOf(gint32 drawable) {
  Buffer buffer(gimp_drawable_get_buffer(drawable));
  GimpColorProfile* profile =
      gimp_item_is_layer(drawable)
          ? gimp_image_get_color_profile(gimp_item_get_image(drawable))
          : nullptr;
  if (profile == nullptr) return buffer;
  const Babl* space = gimp_color_profile_get_space(
      profile, GIMP_COLOR_RENDERING_INTENT_RELATIVE_COLORIMETRIC, nullptr);
  g_object_unref(profile);
  if (space == nullptr) {
    throw InputError(
        "the image's colour profile cannot be computed with; convert it first: Image > "
        "Color Management > Convert to Color Profile");
  }
  const Babl* format = gegl_buffer_get_format(buffer.get());
  gegl_buffer_set_format(buffer.get(),
                         babl_format_with_space(babl_format_get_encoding(format), space));
  return buffer;
}

// In bands of rows: band(first_row, rows, values).
template <class Band>
void ReadBands(gint32 drawable, const Babl* format, int channels, Band&& band) {
  const Buffer buffer = BufferOf(drawable);
  const int width = gimp_drawable_width(drawable);
  const int height = gimp_drawable_height(drawable);
  std::vector<float> values(static_cast<std::size_t>(width) * kRowsAtOnce *
                            static_cast<std::size_t>(channels));
  for (int row = 0; row < height; row += kRowsAtOnce) {
    const int rows = std::min(kRowsAtOnce, height - row);
    const GeglRectangle where = {0, row, width, rows};
    gegl_buffer_get(buffer.get(),
                    &where,
                    1.0,
                    format,
                    values.data(),
                    GEGL_AUTO_ROWSTRIDE,
                    GEGL_ABYSS_NONE);
    band(row, rows, values.data());
  }
}

// A new layer of the image's own precision, of these colours.
gint32 NewLayer(gint32 image,
                const std::string& name,
                const cv::Mat3f& colors,
                const cv::Mat1f& alpha,
                GimpLayerMode mode) {
  const int width = colors.cols, height = colors.rows;
  const bool has_alpha = !alpha.empty();
  const gint32 layer = gimp_layer_new(image,
                                      name.c_str(),
                                      width,
                                      height,
                                      has_alpha ? GIMP_RGBA_IMAGE : GIMP_RGB_IMAGE,
                                      100,
                                      mode);
  const Buffer buffer = BufferOf(layer);
  const Babl* format = babl_format("RGBA float");
  std::vector<cv::Vec4f> band(static_cast<std::size_t>(width) * kRowsAtOnce);
  for (int row = 0; row < height; row += kRowsAtOnce) {
    const int rows = std::min(kRowsAtOnce, height - row);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < width; ++x) {
        const cv::Vec3f& c = colors(row + y, x);
        band[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(x)] = {
            c[0], c[1], c[2], has_alpha ? alpha(row + y, x) : 1.0f};
      }
    }
    const GeglRectangle where = {0, row, width, rows};
    gegl_buffer_set(buffer.get(), &where, 0, format, band.data(), GEGL_AUTO_ROWSTRIDE);
  }
  gegl_buffer_flush(buffer.get());
  return layer;
}

void Attach(gint32 layer, const char* name, const std::string& text) {
  GimpParasite* parasite =
      gimp_parasite_new(name,
                        GIMP_PARASITE_PERSISTENT | GIMP_PARASITE_UNDOABLE,
                        static_cast<guint32>(text.size()),
                        text.data());
  gimp_item_attach_parasite(layer, parasite);
  gimp_parasite_free(parasite);
}

}  // namespace

LayerPicture ReadLayer(gint32 image, gint32 drawable) {
  LayerPicture layer;
  layer.name = Taken(gimp_item_get_name(drawable));
  RequireColourLayer(drawable, layer.name);
  const int width = gimp_drawable_width(drawable);
  const int height = gimp_drawable_height(drawable);
  RequireMemory(layer.name, width, height);

  layer.pixels.pixels.create(height, width);
  cv::Mat1f alpha(height, width);
  ReadBands(drawable,
            babl_format("RGBA float"),
            4,
            [&](int first_row, int rows, const float* values) {
              for (int y = first_row; y < first_row + rows; ++y) {
                for (int x = 0; x < width; ++x, values += 4) {
                  layer.pixels.pixels(y, x) = {values[0], values[1], values[2]};
                  alpha(y, x) = values[3];
                }
              }
            });
  const gint32 mask = gimp_layer_get_mask(drawable);
  if (mask != -1 && gimp_layer_get_apply_mask(drawable)) {
    ReadBands(
        mask, babl_format("Y float"), 1, [&](int row, int rows, const float* values) {
          cv::Mat1f part = alpha.rowRange(row, row + rows);
          cv::multiply(part, cv::Mat1f(rows, width, const_cast<float*>(values)), part);
        });
  }
  cv::patchNaNs(layer.pixels.pixels, 0);
  // A photo that was only given an alpha channel has none that says anything
  if (cv::countNonZero(alpha < 1.0f) > 0) layer.pixels.alpha = alpha;

  for (char* uri : {gimp_image_get_imported_uri(image), gimp_image_get_uri(image)}) {
    const std::string text = Taken(uri);
    if (text.empty() || !layer.file.empty()) continue;
    layer.file = Taken(g_filename_from_uri(text.c_str(), nullptr, nullptr));
  }
  return layer;
}

std::optional<Settings> SettingsOf(gint32 layer) {
  GimpParasite* parasite = gimp_item_get_parasite(layer, kSettings);
  if (parasite == nullptr) return {};
  const std::string text(static_cast<const char*>(gimp_parasite_data(parasite)),
                         static_cast<std::size_t>(gimp_parasite_data_size(parasite)));
  gimp_parasite_free(parasite);
  return SettingsFrom(text);
}

gint32 AddLayers(gint32 image,
                 gint32 layer,
                 const RelitLayers& relit,
                 const Settings& settings) {
  // Pixels first: whatever fails there has not touched the image
  const gint32 tree = NewLayer(image,
                               "Tree " + relit.when,
                               relit.layers.tree,
                               relit.layers.alpha,
                               GIMP_LAYER_MODE_NORMAL_LEGACY);
  gint32 shadow = -1;
  if (!relit.layers.shadow.empty()) {
    shadow = NewLayer(image,
                      "Shadow " + relit.when,
                      relit.layers.shadow,
                      {},
                      GIMP_LAYER_MODE_MULTIPLY_LEGACY);
  }
  gint x = 0, y = 0;
  gimp_drawable_offsets(layer, &x, &y);

  gimp_image_undo_group_start(image);
  const gint32 group = gimp_layer_group_new(image);
  gimp_item_set_name(group, ("Relit " + relit.when).c_str());
  gimp_layer_set_mode(group, GIMP_LAYER_MODE_PASS_THROUGH);  // A shadow falls below it
  gimp_image_insert_layer(image,
                          group,
                          gimp_item_get_parent(layer),
                          gimp_image_get_item_position(image, layer));
  int position = 0;
  for (const gint32 part : {tree, shadow}) {
    if (part == -1) continue;
    Attach(part, kResult, relit.when);
    gimp_layer_set_offsets(part, x, y);
    gimp_image_insert_layer(image, part, group, position++);
  }
  gimp_item_set_visible(layer, FALSE);
  Attach(layer, kSettings, TextOf(settings));
  gimp_image_set_active_layer(image, tree);
  gimp_image_undo_group_end(image);
  return tree;
}

}  // namespace relight::gimp
