// SPDX-License-Identifier: Apache-2.0
#pragma once

// Flags from Describe (relight/base/field.h): help shows unit, range and default from the
// options struct itself. What the user gives is kept as text by name, to be laid over
// capture.toml's [options] later.

#include "relight/base/field_text.h"

#include <CLI/CLI.hpp>

#include <map>
#include <optional>
#include <string>

namespace relight::cli {

template <class Value>
inline constexpr bool kIsNumber = std::is_arithmetic_v<Value>;
template <class Value>
inline constexpr bool kIsNumber<std::optional<Value>> = std::is_arithmetic_v<Value>;

template <class Options>
void AddFlags(CLI::App& app,
              const Options& defaults,
              const std::string& group,
              std::map<std::string, std::string>& given) {
  Options copy = defaults;
  Describe(copy, [&](const auto& value, const FieldInfo& info) {
    using Value = std::decay_t<decltype(value)>;
    const std::string name = info.name, flag = "--" + name;
    if constexpr (std::is_same_v<Value, bool>) {
      app.add_flag_callback(
             flag, [&given, name] { given[name] = "true"; }, info.help)
          ->group(group);
    } else {
      std::string help = info.help;
      const std::string range = info.range.InWords();
      if (kIsNumber<Value> && range != "any number") help += ", " + range;
      const std::string standard = FieldText(value);
      if (!standard.empty()) help += " [" + standard + "]";
      app.add_option_function<std::string>(
             flag, [&given, name](const std::string& text) { given[name] = text; }, help)
          ->type_name(*info.unit != 0 ? info.unit : (kIsNumber<Value> ? "N" : "NAME"))
          ->group(group);
    }
  });
}

}  // namespace relight::cli
