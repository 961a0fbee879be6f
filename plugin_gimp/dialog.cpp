// SPDX-License-Identifier: Apache-2.0
#include "plugin_gimp/dialog.h"

#include "plugin_gimp/beside.h"
#include "relight/base/error.h"

#include <libgimp/gimp.h>
#include <libgimp/gimpui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <new>
#include <string>

namespace relight::gimp {
namespace {

constexpr int kPreview_px = 440;
constexpr const char* kProcedure = "plug-in-relight-tree";

// As the combo boxes have them.
enum PhotoLight { kByClock, kFromDirection };
enum WantedLight { kAtHour, kToDirection, kLikePicture };
enum ExposureKind { kSame, kAuto, kStops };

std::string TextOfEntry(GtkWidget* entry) { return gtk_entry_get_text(GTK_ENTRY(entry)); }

// "13:05" of 13.09 hours.
std::string Clock(double hours) {
  const int minutes = static_cast<int>(std::lround(hours * 60));
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%02d:%02d", minutes / 60, minutes % 60);
  return text.data();
}

struct Direction {
  GtkWidget *azimuth = nullptr, *elevation = nullptr;
  GtkWidget *azimuth_row = nullptr, *elevation_row = nullptr;
};

class Dialog {
 public:
  Dialog(Relighting& relighting, const Settings& settings);
  ~Dialog() { gtk_widget_destroy(window_); }
  Dialog(const Dialog&) = delete;
  Dialog& operator=(const Dialog&) = delete;

  std::optional<Accepted> Run();

 private:
  // Building
  GtkWidget* Combo(const std::vector<const char*>& choices, int chosen);
  GtkWidget* Row(const char* label, GtkWidget* widget);
  GtkWidget* Slider(double from, double to, double step, double page, double value);
  Direction AddDirection(const char* label, const std::string& text, const char* start);
  void AddLights(const Settings& settings);
  void AddFacts(const Settings& settings);
  void ChooseLights(const Settings& settings);

  // While it is shown
  static void OnChanged(GtkWidget*, gpointer self) {
    static_cast<Dialog*>(self)->Changed();
  }
  static gboolean OnIdle(gpointer self);
  static void OnResponse(GtkDialog*, gint response, gpointer self);
  static gchar* FormatHour(GtkScale*, gdouble value, gpointer) {
    return g_strdup(Clock(value).c_str());
  }
  void Changed();
  void ShowRows();
  void Update();
  Settings Read() const;
  void Say(const std::string& text, bool mistake);
  void Show(const cv::Mat3f& picture);
  bool Tick(double done);
  template <class Work>
  bool Try(Work&& work);

  Relighting& relighting_;
  GtkWidget* window_ = nullptr;
  GtkWidget *table_ = nullptr, *picture_ = nullptr, *words_ = nullptr, *bar_ = nullptr;
  GtkWidget *photo_light_ = nullptr, *wanted_light_ = nullptr;
  GtkWidget *day_ = nullptr, *hour_ = nullptr, *like_ = nullptr;
  GtkWidget *exposure_ = nullptr, *stops_ = nullptr, *shadow_ = nullptr;
  GtkWidget *day_row_ = nullptr, *hour_row_ = nullptr, *like_row_ = nullptr;
  Direction from_, to_;
  std::map<std::string, GtkWidget*> facts_;  // Entries by the field's name.
  GtkWidget* folder_ = nullptr;
  int rows_ = 0;
  bool chosen_ = false;   // The lights' kinds fit what is known.
  bool stale_ = true;     // Something changed since the preview was begun.
  bool working_ = false;  // Inside Tick's events.
  int response_ = 0;      // Of the user; 0: none yet.
};

// --- Building ------------------------------------------------------------------------

GtkWidget* Dialog::Combo(const std::vector<const char*>& choices, int chosen) {
  GtkWidget* combo = gtk_combo_box_text_new();
  for (const char* choice : choices) {
    gtk_combo_box_text_append_text(GTK_COMBO_BOX_TEXT(combo), choice);
  }
  gtk_combo_box_set_active(GTK_COMBO_BOX(combo), chosen);
  g_signal_connect(combo, "changed", G_CALLBACK(OnChanged), this);
  return combo;
}

// A row of the table; answers the label, which is shown and hidden with the widget.
GtkWidget* Dialog::Row(const char* label, GtkWidget* widget) {
  GtkWidget* text = gtk_label_new_with_mnemonic(label);
  gtk_misc_set_alignment(GTK_MISC(text), 0, 0.5);
  gtk_label_set_mnemonic_widget(GTK_LABEL(text), widget);
  const auto row = static_cast<guint>(rows_++);
  gtk_table_attach(GTK_TABLE(table_), text, 0, 1, row, row + 1, GTK_FILL, GTK_FILL, 0, 0);
  gtk_table_attach(GTK_TABLE(table_),
                   widget,
                   1,
                   2,
                   row,
                   row + 1,
                   static_cast<GtkAttachOptions>(GTK_FILL | GTK_EXPAND),
                   GTK_FILL,
                   0,
                   0);
  return text;
}

GtkWidget* Dialog::Slider(
    double from, double to, double step, double page, double value) {
  GtkWidget* slider = gtk_hscale_new_with_range(from, to, step);
  gtk_range_set_increments(GTK_RANGE(slider), step, page);
  gtk_scale_set_value_pos(GTK_SCALE(slider), GTK_POS_RIGHT);
  gtk_widget_set_size_request(slider, 260, -1);
  gtk_range_set_value(GTK_RANGE(slider), value);
  g_signal_connect(slider, "value-changed", G_CALLBACK(OnChanged), this);
  return slider;
}

Direction Dialog::AddDirection(const char* label,
                               const std::string& text,
                               const char* start) {
  double azimuth_deg = 0, elevation_deg = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf", &azimuth_deg, &elevation_deg) != 2)
    std::sscanf(start, "%lf,%lf", &azimuth_deg, &elevation_deg);
  Direction d;
  d.azimuth = Slider(0, 359, 1, 15, azimuth_deg);
  d.elevation = Slider(1, 90, 1, 10, elevation_deg);
  d.azimuth_row = Row(label, d.azimuth);
  d.elevation_row = Row("      its height", d.elevation);
  gtk_widget_set_tooltip_text(d.azimuth,
                              "Degrees as the camera sees it: 0 straight ahead, 90 from "
                              "the right, 180 from behind you, 270 from the left");
  gtk_widget_set_tooltip_text(d.elevation, "Degrees above the horizon");
  return d;
}

void Dialog::AddLights(const Settings& s) {
  photo_light_ = Combo({"Known by time and place", "From a direction"},
                       s.lit_from.empty() ? kByClock : kFromDirection);
  Row("Light in the _photo:", photo_light_);
  from_ = AddDirection("Light in the photo _from:", s.lit_from, "180,45");
  wanted_light_ = Combo({"At a date and hour", "From a direction", "As in another photo"},
                        !s.like.empty()       ? kLikePicture
                        : !s.to_light.empty() ? kToDirection
                                              : kAtHour);
  Row("Light _wanted:", wanted_light_);

  day_ = gtk_entry_new();
  gtk_entry_set_width_chars(GTK_ENTRY(day_), 12);
  gtk_widget_set_tooltip_text(day_, "2011-09-23; empty: the day of the photo");
  g_signal_connect(day_, "changed", G_CALLBACK(OnChanged), this);
  hour_ = Slider(0, 23.75, 0.25, 1, 17);
  g_signal_connect(hour_, "format-value", G_CALLBACK(FormatHour), nullptr);
  day_row_ = Row("_Date:", day_);
  hour_row_ = Row("_Hour:", hour_);
  int hours = 17, minutes = 0;
  const std::size_t t = s.to.find('T');
  const std::string clock = t == std::string::npos ? s.to : s.to.substr(t + 1);
  if (std::sscanf(clock.c_str(), "%d:%d", &hours, &minutes) == 2)
    gtk_range_set_value(GTK_RANGE(hour_), hours + minutes / 60.0);
  if (t != std::string::npos)
    gtk_entry_set_text(GTK_ENTRY(day_), s.to.substr(0, t).c_str());

  to_ = AddDirection("Light wanted f_rom:", s.to_light, "90,20");
  like_ = gtk_file_chooser_button_new("A photo whose light is wanted",
                                      GTK_FILE_CHOOSER_ACTION_OPEN);
  if (!s.like.empty())
    gtk_file_chooser_set_filename(GTK_FILE_CHOOSER(like_), s.like.c_str());
  g_signal_connect(like_, "selection-changed", G_CALLBACK(OnChanged), this);
  like_row_ = Row("As in the p_icture:", like_);

  const int kind = s.exposure == "same" ? kSame : s.exposure == "auto" ? kAuto : kStops;
  exposure_ = Combo(
      {"As it is at that hour", "As bright as the photo", "Brighter by stops"}, kind);
  Row("_Exposure:", exposure_);
  stops_ = gtk_spin_button_new_with_range(-10, 10, 0.25);
  gtk_spin_button_set_value(GTK_SPIN_BUTTON(stops_),
                            g_ascii_strtod(s.exposure.c_str(), nullptr));
  g_signal_connect(stops_, "value-changed", G_CALLBACK(OnChanged), this);
  Row("      s_tops", stops_);
  shadow_ = gtk_check_button_new_with_mnemonic("_Shadow on the ground, as a layer");
  gtk_toggle_button_set_active(GTK_TOGGLE_BUTTON(shadow_), s.shadow);
  g_signal_connect(shadow_, "toggled", G_CALLBACK(OnChanged), this);
  Row("", shadow_);
}

void Dialog::AddFacts(const Settings& s) {
  Row("", gtk_hseparator_new());
  for (const TextField& field : kTextFields) {
    if (!field.of_photo || field.text == &Settings::lit_from) continue;
    const std::string label = std::string(field.label) + ":";
    if (field.text == &Settings::capture) {
      folder_ = gtk_file_chooser_button_new("Folder of the capture",
                                            GTK_FILE_CHOOSER_ACTION_SELECT_FOLDER);
      if (!s.capture.empty())
        gtk_file_chooser_set_filename(GTK_FILE_CHOOSER(folder_), s.capture.c_str());
      gtk_widget_set_tooltip_text(folder_, field.help);
      g_signal_connect(folder_, "selection-changed", G_CALLBACK(OnChanged), this);
      Row(label.c_str(), folder_);
      continue;
    }
    GtkWidget* entry = gtk_entry_new();
    gtk_entry_set_text(GTK_ENTRY(entry), (s.*field.text).c_str());
    gtk_widget_set_tooltip_text(entry, field.help);
    g_signal_connect(entry, "changed", G_CALLBACK(OnChanged), this);
    Row(label.c_str(), entry);
    facts_[field.name] = entry;
  }
}

Dialog::Dialog(Relighting& relighting, const Settings& settings)
    : relighting_(relighting) {
  gimp_ui_init("relight-tree", FALSE);
  window_ = gimp_dialog_new("Relight Tree",
                            "relight-tree",
                            nullptr,
                            static_cast<GtkDialogFlags>(0),
                            gimp_standard_help_func,
                            kProcedure,
                            "_Cancel",
                            GTK_RESPONSE_CANCEL,
                            "_OK",
                            GTK_RESPONSE_OK,
                            nullptr);
  gimp_window_set_transient(GTK_WINDOW(window_));
  gtk_dialog_set_default_response(GTK_DIALOG(window_), GTK_RESPONSE_OK);
  GtkWidget* all = gtk_vbox_new(FALSE, 12);
  gtk_container_set_border_width(GTK_CONTAINER(all), 12);
  gtk_box_pack_start(
      GTK_BOX(gtk_dialog_get_content_area(GTK_DIALOG(window_))), all, TRUE, TRUE, 0);
  GtkWidget* sides = gtk_hbox_new(FALSE, 12);
  gtk_box_pack_start(GTK_BOX(all), sides, TRUE, TRUE, 0);
  picture_ = gtk_image_new();
  gtk_widget_set_size_request(picture_, kPreview_px, kPreview_px);
  gtk_box_pack_start(GTK_BOX(sides), picture_, TRUE, TRUE, 0);
  table_ = gtk_table_new(24, 2, FALSE);
  gtk_table_set_col_spacings(GTK_TABLE(table_), 8);
  gtk_table_set_row_spacings(GTK_TABLE(table_), 4);
  gtk_box_pack_start(GTK_BOX(sides), table_, FALSE, FALSE, 0);
  AddLights(settings);
  AddFacts(relighting.Completed(settings));

  words_ = gtk_label_new(nullptr);
  gtk_misc_set_alignment(GTK_MISC(words_), 0, 0);
  gtk_label_set_line_wrap(GTK_LABEL(words_), TRUE);
  gtk_label_set_selectable(GTK_LABEL(words_), TRUE);
  gtk_widget_set_can_focus(words_, FALSE);
  gtk_widget_set_size_request(words_, 760, 56);
  gtk_box_pack_start(GTK_BOX(all), words_, FALSE, FALSE, 0);
  bar_ = gtk_progress_bar_new();
  gtk_box_pack_start(GTK_BOX(all), bar_, FALSE, FALSE, 0);
  gtk_widget_show_all(window_);
  ChooseLights(settings);
  ShowRows();
  gtk_widget_grab_focus(gtk_combo_box_get_active(GTK_COMBO_BOX(wanted_light_)) == kAtHour
                            ? hour_
                            : to_.azimuth);
  g_signal_connect(window_, "response", G_CALLBACK(OnResponse), this);
}

// Clocks where they are known; else directions, which anybody can see.
void Dialog::ChooseLights(const Settings& settings) {
  const bool said =
      !settings.lit_from.empty() || !settings.to_light.empty() || !settings.like.empty();
  if (!said) {
    try {
      relighting_.Check(Read());
    } catch (const Error&) {
      if (!relighting_.TimeOfPhoto()) {
        gtk_combo_box_set_active(GTK_COMBO_BOX(photo_light_), kFromDirection);
        gtk_combo_box_set_active(GTK_COMBO_BOX(wanted_light_), kToDirection);
      }
    }
  }
  if (const auto time = relighting_.TimeOfPhoto(); time && TextOfEntry(day_).empty()) {
    gtk_entry_set_text(GTK_ENTRY(day_), FormatLocal(*time).substr(0, 10).c_str());
  }
  chosen_ = true;
  Changed();
}

// --- While it is shown ---------------------------------------------------------------

Settings Dialog::Read() const {
  const auto direction = [](const Direction& d) {
    return std::to_string(std::lround(gtk_range_get_value(GTK_RANGE(d.azimuth)))) + "," +
           std::to_string(std::lround(gtk_range_get_value(GTK_RANGE(d.elevation))));
  };
  const auto file = [](GtkWidget* button) {
    char* name = gtk_file_chooser_get_filename(GTK_FILE_CHOOSER(button));
    const std::string text = name != nullptr ? name : "";
    g_free(name);
    return text;
  };
  Settings s;
  if (gtk_combo_box_get_active(GTK_COMBO_BOX(photo_light_)) == kFromDirection)
    s.lit_from = direction(from_);
  switch (gtk_combo_box_get_active(GTK_COMBO_BOX(wanted_light_))) {
    case kToDirection:
      s.to_light = direction(to_);
      break;
    case kLikePicture:
      s.like = file(like_);
      break;
    default:
      s.to = (TextOfEntry(day_).empty() ? "" : TextOfEntry(day_) + "T") +
             Clock(gtk_range_get_value(GTK_RANGE(hour_)));
  }
  switch (gtk_combo_box_get_active(GTK_COMBO_BOX(exposure_))) {
    case kAuto:
      s.exposure = "auto";
      break;
    case kStops: {
      std::array<char, G_ASCII_DTOSTR_BUF_SIZE> text{};
      s.exposure = g_ascii_formatd(text.data(),
                                   static_cast<gint>(text.size()),
                                   "%.2f",
                                   gtk_spin_button_get_value(GTK_SPIN_BUTTON(stops_)));
      break;
    }
    default:
      s.exposure = "same";
  }
  s.shadow = gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(shadow_)) != FALSE;
  s.capture = file(folder_);
  for (const TextField& field : kTextFields) {
    if (const auto found = facts_.find(field.name); found != facts_.end())
      s.*field.text = TextOfEntry(found->second);
  }
  if (s.capture.empty()) s.view.clear();
  return s;
}

void Dialog::ShowRows() {
  const int photo = gtk_combo_box_get_active(GTK_COMBO_BOX(photo_light_));
  const int wanted = gtk_combo_box_get_active(GTK_COMBO_BOX(wanted_light_));
  const auto show = [](std::initializer_list<GtkWidget*> widgets, bool shown) {
    for (GtkWidget* widget : widgets) gtk_widget_set_visible(widget, shown);
  };
  show({from_.azimuth, from_.elevation, from_.azimuth_row, from_.elevation_row},
       photo == kFromDirection);
  show({day_, hour_, day_row_, hour_row_}, wanted == kAtHour);
  show({to_.azimuth, to_.elevation, to_.azimuth_row, to_.elevation_row},
       wanted == kToDirection);
  show({like_, like_row_}, wanted == kLikePicture);
  gtk_widget_set_sensitive(stops_,
                           gtk_combo_box_get_active(GTK_COMBO_BOX(exposure_)) == kStops);
}

void Dialog::Changed() {
  if (!chosen_) return;
  ShowRows();
  stale_ = true;
  if (!working_) g_idle_add(OnIdle, this);
}

gboolean Dialog::OnIdle(gpointer self) {
  auto* dialog = static_cast<Dialog*>(self);
  if (!dialog->working_ && dialog->stale_ && dialog->response_ == 0) dialog->Update();
  return FALSE;
}

void Dialog::OnResponse(GtkDialog*, gint response, gpointer self) {
  auto* dialog = static_cast<Dialog*>(self);
  if (response == GTK_RESPONSE_HELP) return;
  dialog->response_ = response;
  if (!dialog->working_) gtk_main_quit();
}

// Events, while something is computed. False stops the work.
bool Dialog::Tick(double done) {
  gtk_progress_bar_set_fraction(GTK_PROGRESS_BAR(bar_), std::clamp(done, 0.0, 1.0));
  while (gtk_events_pending()) gtk_main_iteration();
  return response_ == 0 || response_ == GTK_RESPONSE_OK;
}

void Dialog::Say(const std::string& text, bool mistake) {
  char* escaped = g_markup_escape_text(text.c_str(), -1);
  const std::string markup =
      mistake ? "<b>" + std::string(escaped) + "</b>" : std::string(escaped);
  g_free(escaped);
  gtk_label_set_markup(GTK_LABEL(words_), markup.c_str());
}

void Dialog::Show(const cv::Mat3f& picture) {
  GdkPixbuf* pixbuf =
      gdk_pixbuf_new(GDK_COLORSPACE_RGB, FALSE, 8, picture.cols, picture.rows);
  guchar* pixels = gdk_pixbuf_get_pixels(pixbuf);
  const int stride = gdk_pixbuf_get_rowstride(pixbuf);
  cv::Mat3b shown(
      picture.rows, picture.cols, reinterpret_cast<cv::Vec3b*>(pixels), stride);
  picture.convertTo(shown, CV_8U, 255);
  gtk_image_set_from_pixbuf(GTK_IMAGE(picture_), pixbuf);
  g_object_unref(pixbuf);
}

// True when the work was done; a mistake is said, and then OK has to wait.
template <class Work>
bool Dialog::Try(Work&& work) {
  working_ = true;
  bool done = false;
  try {
    work();
    done = true;
  } catch (const Cancelled&) {
  } catch (const Error& error) {
    Say(InWordsOfDialog(error.what()), true);
  } catch (const std::bad_alloc&) {
    Say("There is not enough memory for a layer of this size; scale it down", true);
  } catch (const std::exception& error) {
    Say(std::string(error.what()) + " (an error of Relight Tree; please report it)",
        true);
  }
  working_ = false;
  gtk_progress_bar_set_fraction(GTK_PROGRESS_BAR(bar_), 0);
  return done;
}

void Dialog::Update() {
  while (stale_ && response_ == 0) {
    stale_ = false;
    const bool fine = Try([&] {
      const Settings settings = Read();
      Say(relighting_.Check(settings), false);
      Show(Beside(
          [&](const Progress& progress) {
            return relighting_.Preview(settings, kPreview_px, progress);
          },
          [&](double done) { return Tick(done); }));
    });
    gtk_dialog_set_response_sensitive(GTK_DIALOG(window_), GTK_RESPONSE_OK, fine);
  }
  if (response_ != 0) gtk_main_quit();
}

std::optional<Accepted> Dialog::Run() {
  std::optional<Accepted> accepted;
  while (!accepted) {
    response_ = 0;
    gtk_main();
    if (response_ != GTK_RESPONSE_OK) return {};
    Try([&] {
      const Settings settings = Read();
      RelitLayers relit = Beside(
          [&](const Progress& progress) {
            return relighting_.Relight(settings, progress);
          },
          [&](double done) { return Tick(done); });
      accepted = Accepted{relighting_.Completed(settings), std::move(relit)};
    });
    if (response_ == GTK_RESPONSE_CANCEL || response_ == GTK_RESPONSE_DELETE_EVENT)
      return {};
  }
  return accepted;
}

}  // namespace

std::optional<Accepted> RunDialog(Relighting& relighting, const Settings& settings) {
  return Dialog(relighting, settings).Run();
}

}  // namespace relight::gimp
