// SPDX-License-Identifier: Apache-2.0
#pragma once

// Options by name and text: one way for the command line and for capture.toml, and the
// record of a run, all through Describe (field.h). Choices are enums with a table of
// words:
//
//   inline constexpr EnumWord<Method> kMethodWords[] = {{"default", Method::kDefault},
//   …}; inline std::span<const EnumWord<Method>> EnumWords(Method) { return kMethodWords;
//   }

#include "relight/base/field.h"

#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

namespace relight {

template <class Enum>
struct EnumWord {
  const char* word;
  Enum value;
};

template <class Value>
std::string FieldText(const Value& value) {
  if constexpr (std::is_same_v<Value, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_enum_v<Value>) {
    for (const auto& [word, meant] : EnumWords(value)) {
      if (meant == value) return word;
    }
    return "";
  } else if constexpr (std::is_arithmetic_v<Value>) {
    std::ostringstream text;
    text << value;
    return text.str();
  } else if constexpr (std::is_same_v<Value, std::string>) {
    return value;
  } else {
    return value ? FieldText(*value) : "";  // std::optional
  }
}

// Throws OptionError: "cells must be a whole number, got 1.5".
template <class Value>
void SetFieldFromText(Value& value, const std::string& text, const FieldInfo& info) {
  const auto fail = [&](const std::string& what) {
    throw OptionError(std::string(info.name) + " must be " + what + ", got \"" + text +
                      "\"");
  };
  if constexpr (std::is_same_v<Value, bool>) {
    if (text != "true" && text != "false") fail("true or false");
    value = text == "true";
  } else if constexpr (std::is_enum_v<Value>) {
    std::string words;
    for (const auto& [word, meant] : EnumWords(value)) {
      if (text == word) {
        value = meant;
        return;
      }
      words += (words.empty() ? "" : ", ") + std::string(word);
    }
    fail("one of " + words);
  } else if constexpr (std::is_arithmetic_v<Value>) {
    Value parsed{};
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), parsed);
    if (error != std::errc() || end != text.data() + text.size()) {
      fail(std::is_integral_v<Value> ? "a whole number" : "a number");
    }
    value = parsed;
  } else if constexpr (std::is_same_v<Value, std::string>) {
    value = text;
  } else {
    typename Value::value_type parsed{};
    SetFieldFromText(parsed, text, info);
    value = parsed;
  }
}

// Sets the field called `name`; false when there is none of that name.
template <class Options>
bool SetField(Options& options, const std::string& name, const std::string& text) {
  bool found = false;
  Describe(options, [&](auto& value, const FieldInfo& info) {
    if (name != info.name) return;
    SetFieldFromText(value, text, info);
    found = true;
  });
  return found;
}

// "cells=100 iterations=8 …": all fields, for what a stage depended on.
template <class Options>
std::string FieldsText(const Options& options) {
  Options copy = options;
  std::string text;
  Describe(copy, [&](auto& value, const FieldInfo& info) {
    text += (text.empty() ? "" : " ") + std::string(info.name) + "=" + FieldText(value);
  });
  return text;
}

}  // namespace relight
