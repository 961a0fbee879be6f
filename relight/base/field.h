// SPDX-License-Identifier: Apache-2.0
#pragma once

// Options are plain structs. Each describes its fields once, in a function
//
//   template <class Visitor> void Describe(XOptions& o, Visitor&& field) {
//     field(o.voxel_size_m, {"voxel-size", "m", "edge of a cubic voxel", Above(0)});
//   }
//
// which checks (CheckFields), command-line flags, help and the record of a run visit.

#include "relight/base/error.h"

#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <type_traits>

namespace relight {

// What a number may be; both ends may be open.
struct FieldRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;
  bool high_open = false;

  bool Holds(double value) const {
    return !std::isnan(value) && (low_open ? value > low : value >= low) &&
           (high_open ? value < high : value <= high);
  }
  // "> 0", "0 to 1", "any".
  std::string InWords() const {
    std::ostringstream words;
    if (std::isfinite(low) && std::isfinite(high)) {
      words << (low_open ? "above " : "") << low << " to " << (high_open ? "below " : "")
            << high;
    } else if (std::isfinite(low)) {
      words << (low_open ? "> " : ">= ") << low;
    } else if (std::isfinite(high)) {
      words << (high_open ? "< " : "<= ") << high;
    } else {
      words << "any number";
    }
    return words.str();
  }
};

inline FieldRange Above(double low) { return {.low = low, .low_open = true}; }
inline FieldRange AtLeast(double low) { return {.low = low}; }
inline FieldRange Between(double low, double high) { return {.low = low, .high = high}; }

struct FieldInfo {
  const char* name;  // As on the command line, without the dashes: "voxel-size".
  const char* unit;  // "m", "deg"; "" for none.
  const char* help;  // One phrase, no full stop.
  FieldRange range = {};
};

// Throws OptionError for the first field out of range:
// "voxel-size must be > 0 m, got -0.1".
template <class Options>
void CheckFields(const Options& options) {
  const auto check = [](double value, const FieldInfo& info) {
    if (info.range.Holds(value)) return;
    std::ostringstream text;
    text << info.name << " must be " << info.range.InWords() << (*info.unit ? " " : "")
         << info.unit << ", got " << value;
    throw OptionError(text.str());
  };
  Options copy = options;
  Describe(copy, [&](const auto& value, const FieldInfo& info) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::optional<double>> ||
                  std::is_same_v<Value, std::optional<int>>) {
      if (value) check(static_cast<double>(*value), info);
    } else if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      check(static_cast<double>(value), info);
    }
  });
}

}  // namespace relight
