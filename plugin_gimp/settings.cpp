// SPDX-License-Identifier: Apache-2.0
#include "plugin_gimp/settings.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

namespace relight::gimp {
namespace {

void ReplaceAll(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

}  // namespace

std::string TextOf(const Settings& settings) {
  std::string text = "shadow=" + std::string(settings.shadow ? "1" : "0") + "\n";
  for (const TextField& field : kTextFields) {
    std::string value = settings.*field.text;
    std::replace(value.begin(), value.end(), '\n', ' ');
    text += std::string(field.name) + "=" + value + "\n";
  }
  return text;
}

Settings SettingsFrom(const std::string& text) {
  Settings settings;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string name = line.substr(0, equals), value = line.substr(equals + 1);
    if (name == "shadow") settings.shadow = value == "1";
    for (const TextField& field : kTextFields) {
      if (name == field.name) settings.*field.text = value;
    }
  }
  return settings;
}

std::string InWordsOfDialog(std::string message) {
  if (const auto command = message.find("\nwith your own values: ");
      command != std::string::npos) {
    message.erase(command);
  }
  const std::vector<std::pair<std::string, std::string>> sentences = {
      {"its matte holds no tree (no pixel above 0.5); give another with --matte",
       "the layer holds no tree, for nothing of it is opaque; select the layer that "
       "does"},
      {"; give its height with --ground Z_m", "; leave Shadow off"},
  };
  for (const auto& [theirs, ours] : sentences) ReplaceAll(message, theirs, ours);

  // Longer options first: --to is a part of --to-light
  std::vector<TextField> fields(kTextFields.begin(), kTextFields.end());
  std::sort(fields.begin(), fields.end(), [](const TextField& a, const TextField& b) {
    return std::string(a.option).size() > std::string(b.option).size();
  });
  for (const TextField& field : fields) {
    const std::string option = field.option;
    if (option.starts_with("--"))
      ReplaceAll(
          message, option, "\xe2\x80\x9c" + std::string(field.label) + "\xe2\x80\x9d");
  }
  return message;
}

}  // namespace relight::gimp
