// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers in the text of a camera format, whatever the user's locale is. "nan" and "inf"
// are no numbers here: no format means them.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace relight {

inline constexpr std::string_view kBlanks = " \t\r\n";

inline std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

// Nothing when `text`, without the blanks around it, is not one finite number.
inline std::optional<double> NumberFrom(std::string_view text) {
  text = Trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(number)) return std::nullopt;
  return number;
}

// Numbers between blanks; nothing when one of the words is none.
inline std::optional<std::vector<double>> NumbersFrom(std::string_view text) {
  std::vector<double> numbers;
  for (text = Trimmed(text); !text.empty(); text = Trimmed(text)) {
    const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
    const std::optional<double> number = NumberFrom(text.substr(0, end));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    text.remove_prefix(end);
  }
  return numbers;
}

}  // namespace relight
