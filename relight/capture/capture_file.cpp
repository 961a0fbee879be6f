// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_file.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/view_name.h"
#include "relight/photo/capture_time.h"

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>

namespace relight {
namespace fs = std::filesystem;
namespace {

class Reader {
 public:
  explicit Reader(const fs::path& file) : file_(file) {}

  std::string Where(const toml::node& node) const {
    return file_.string() + ":" + std::to_string(node.source().begin.line);
  }
  [[noreturn]] void Fail(const toml::node& node, const std::string& what) const {
    throw InputError(Where(node) + ": " + what);
  }

  // Every key of `table` is one of `known`.
  void OnlyKnown(const toml::table& table,
                 std::initializer_list<std::string_view> known) const {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string list;
      for (const std::string_view k : known)
        list += (list.empty() ? "" : ", ") + std::string(k);
      Fail(node,
           "unknown key \"" + std::string(key.str()) + "\"; known here are " + list);
    }
  }

  std::optional<std::string> Text(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return std::nullopt;
    if (const auto text = node->value_exact<std::string>()) return *text;
    // TOML has dates and times of its own
    if (node->is_date_time() || node->is_date() || node->is_time()) {
      std::ostringstream out;
      node->visit([&](const auto& value) {
        if constexpr (toml::is_date_time<decltype(value)> ||
                      toml::is_date<decltype(value)> || toml::is_time<decltype(value)>) {
          out << value.get();
        }
      });
      return out.str();
    }
    Fail(*node,
         std::string(key) + " must be a text in quotes, like " + std::string(key) +
             " = \"" + Example(key) + "\"");
  }

  std::optional<double> Number(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return std::nullopt;
    if (!node->is_number()) {
      Fail(*node, std::string(key) + " must be a number without quotes, in degrees");
    }
    return *node->value<double>();
  }

  // Reads the value of `key` with the parser of the command line, whose words are given
  // with the line.
  template <class Parse>
  void Check(const toml::table& table, std::string_view key, Parse&& parse) const {
    try {
      parse();
    } catch (const Error& error) {
      Fail(*table.get(key), error.what());
    }
  }

  std::optional<std::string> PlaceText(const toml::table& table) const {
    const toml::node* node = table.get("place");
    if (node == nullptr) return std::nullopt;
    if (const auto text = node->value_exact<std::string>()) return *text;
    const toml::array* numbers = node->as_array();
    if (numbers == nullptr || numbers->size() < 2 || numbers->size() > 3 ||
        !std::all_of(numbers->begin(), numbers->end(), [](const toml::node& n) {
          return n.is_number();
        })) {
      Fail(*node,
           "place must be [latitude, longitude] or [latitude, longitude, altitude_m], "
           "like "
           "place = [48.85, 2.35]");
    }
    std::ostringstream text;
    text.precision(12);
    for (std::size_t i = 0; i < numbers->size(); ++i) {
      text << (i > 0 ? "," : "") << *(*numbers)[i].value<double>();
    }
    return text.str();
  }

  ViewEntry View(const toml::table& table) const {
    OnlyKnown(table, {"name", "photo", "taken"});
    const auto photo = Text(table, "photo");
    if (!photo) Fail(table, "a view without photo; add photo = \"photos/NAME.jpg\"");
    RequireInsideCapture(*photo, Where(table));
    ViewEntry view{
        Text(table, "name").value_or(ViewNameOf(*photo)), *photo, Text(table, "taken")};
    RequireInsideCapture(view.name, Where(table));
    if (view.taken) Check(table, "taken", [&] { ParseWhen(*view.taken, {}); });
    if (fs::path(view.name).has_parent_path()) {
      Fail(table, "the view's name \"" + view.name + "\" must not hold a folder");
    }
    return view;
  }

  OptionEntry Option(const toml::node& node) const {
    return {OptionText(node), Where(node)};
  }

 private:
  static std::string Example(std::string_view key) {
    return key == "zone"    ? "Europe/Paris"
           : key == "taken" ? "2011-07-22T13:00"
           : key == "photo" ? "photos/NAME.jpg"
                            : "NAME";
  }

  std::string OptionText(const toml::node& node) const {
    if (const auto text = node.value_exact<std::string>()) return *text;
    if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
    if (const auto whole = node.value_exact<std::int64_t>())
      return std::to_string(*whole);
    if (const auto number = node.value_exact<double>()) {
      std::ostringstream text;
      text.precision(17);
      text << *number;
      return text.str();
    }
    Fail(node, "an option must be a number, true, false or a text in quotes");
  }

  fs::path file_;
};

std::string Quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

}  // namespace

CaptureFile ReadCaptureFile(const fs::path& file) {
  constexpr std::size_t kLimitBytes = 10'000'000;
  toml::table table;
  try {
    table = toml::parse(ReadText(file, kLimitBytes), file.string());
  } catch (const toml::parse_error& error) {
    throw InputError(file.string() + ":" + std::to_string(error.source().begin.line) +
                     ": " + std::string(error.description()) + "; mend this line");
  }
  const Reader reader(file);
  reader.OnlyKnown(table, {"place", "zone", "taken", "heading", "view", "options"});
  CaptureFile capture;
  capture.place = reader.PlaceText(table);
  capture.zone = reader.Text(table, "zone");
  capture.taken = reader.Text(table, "taken");
  capture.heading_deg = reader.Number(table, "heading");
  if (capture.place) {
    reader.Check(table, "place", [&] { ParsePlace(*capture.place); });
  }
  if (capture.zone) reader.Check(table, "zone", [&] { ParseZone(*capture.zone); });
  if (capture.taken) reader.Check(table, "taken", [&] { ParseWhen(*capture.taken, {}); });
  if (capture.heading_deg && !(std::abs(*capture.heading_deg) <= 360)) {
    reader.Fail(*table.get("heading"),
                "heading must be in degrees clockwise from true north, 0 to 360");
  }
  if (const toml::node* node = table.get("view")) {
    const toml::array* views = node->as_array();
    if (views == nullptr || !views->is_array_of_tables()) {
      reader.Fail(*node, "views are written as [[view]], each with a photo = \"…\"");
    }
    for (const toml::node& view : *views) {
      capture.views.push_back(reader.View(*view.as_table()));
      const ViewEntry& added = capture.views.back();
      const auto same = std::count_if(
          capture.views.begin(), capture.views.end(), [&](const ViewEntry& v) {
            return v.name == added.name;
          });
      if (same > 1) {
        reader.Fail(view,
                    "a second view named \"" + added.name + "\"; give it another name");
      }
    }
  }
  if (const toml::node* node = table.get("options")) {
    const toml::table* options = node->as_table();
    if (options == nullptr)
      reader.Fail(*node, "options are written below a line [options]");
    for (const auto& [key, value] : *options) {
      capture.options[std::string(key.str())] = reader.Option(value);
    }
  }
  return capture;
}

std::string CaptureFileText(const CaptureFile& capture) {
  std::ostringstream text;
  const auto line =
      [&](const char* key, const std::optional<std::string>& value, const char* example) {
        if (value) {
          text << key << " = " << Quoted(*value) << "\n";
        } else {
          text << "# " << key << " = " << example << "\n";
        }
      };
  text << "# A capture of relight. \"relight info\" says what it lacks.\n\n";
  line("place",
       capture.place,
       "\"40.35,-74.65,20\"   # latitude, longitude, altitude in m");
  line("zone", capture.zone, "\"Europe/Paris\"   # for photos that name no zone");
  line("taken", capture.taken, "\"2011-07-22T13:00\"   # for photos without a time");
  if (capture.heading_deg) text << "heading = " << *capture.heading_deg << "\n";
  text << ViewsText(capture.views);
  if (!capture.options.empty()) {
    text << "\n[options]\n";
    for (const auto& [key, value] : capture.options)
      text << key << " = " << Quoted(value.text) << "\n";
  }
  return text.str();
}

std::string ViewsText(std::span<const ViewEntry> views) {
  std::ostringstream text;
  for (const ViewEntry& view : views) {
    text << "\n[[view]]\n";
    text << "name = " << Quoted(view.name) << "\nphoto = " << Quoted(view.photo.string())
         << "\n";
    if (view.taken) text << "taken = " << Quoted(*view.taken) << "\n";
  }
  return text.str();
}

}  // namespace relight
