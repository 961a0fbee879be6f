// SPDX-License-Identifier: Apache-2.0
#pragma once

// A CSV file of figures with one line of column names, for tests.

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace relight::tests {

class CsvRow {
 public:
  explicit CsvRow(std::map<std::string, std::string> cells) : cells_(std::move(cells)) {}
  const std::string& Text(const std::string& column) const { return cells_.at(column); }
  double operator[](const std::string& column) const { return std::stod(Text(column)); }

 private:
  std::map<std::string, std::string> cells_;
};

// Every row but repeated lines of column names.
inline std::vector<CsvRow> ReadCsv(const std::filesystem::path& file) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) throw std::runtime_error(file.string() + ": empty");
  const std::vector<std::string> names = split(line);
  std::vector<CsvRow> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = split(line);
    if (cells.size() != names.size() || cells == names) continue;
    std::map<std::string, std::string> row;
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = cells[i];
    rows.emplace_back(std::move(row));
  }
  return rows;
}

}  // namespace relight::tests
