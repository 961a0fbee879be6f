// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/evaluated_hours.h"
#include "relight/capture/report_page.h"
#include "relight/composite/html_text.h"

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

struct Curve {
  const char* figure;
  const char* what;
  int digits;
  std::optional<double> right;  // Where a perfect picture is, when that is near.
};

constexpr Curve kCurves[] = {
    {"psnr_low", "low frequencies after the best gain [dB], more is better", 1, {}},
    {"corr_low", "correlation of the low luminance, 1 is right", 2, 1.0},
    {"contrast", "local contrast as a ratio to the truth's, 1 is right", 2, 1.0},
    {"level", "mean luminance as a ratio to the truth's, 1 is right", 2, 1.0}};

std::string ColorOfRow(const std::string& row) {
  if (row == "result") return "#ffd24a";
  if (row == "nothing") return "#9a988f";
  if (row == "histogram") return "#6fb7e9";
  return row == "reinhard" ? "#d98fd0" : "#7fd08a";
}

// Hours in minutes where all names have one and they rise, else one after the other.
std::vector<double> PlacesOf(const std::vector<EvaluatedHour>& hours) {
  std::vector<double> places;
  for (const EvaluatedHour& hour : hours) {
    const bool rises =
        hour.pair.hour && (places.empty() || *hour.pair.hour > places.back());
    if (!rises) {
      places.clear();
      for (std::size_t i = 0; i < hours.size(); ++i) places.push_back(double(i));
      return places;
    }
    places.push_back(*hour.pair.hour);
  }
  return places;
}

std::string CurveSvg(const Curve& curve, const std::vector<EvaluatedHour>& hours) {
  constexpr double kWidth = 600, kHeight = 300, kLeft = 52, kRight = 24, kTop = 40,
                   kBottom = 30;
  const std::vector<double> places = PlacesOf(hours);
  double low = curve.right.value_or(1e9), high = curve.right.value_or(-1e9);
  for (const EvaluatedHour& hour : hours) {
    for (const auto& [name, figures] : RowsOf(hour.score)) {
      const double value = *FigureOf(figures, curve.figure);
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  const double margin = std::max(0.05 * (high - low), 1e-3);
  low -= margin;
  high += margin;
  const double span = std::max(places.back() - places.front(), 1e-9);
  const auto x = [&](std::size_t i) {
    if (places.size() == 1) return (kLeft + kWidth - kRight) / 2.0;
    return kLeft + (places[i] - places.front()) / span * (kWidth - kLeft - kRight);
  };
  const auto y = [&](double value) {
    return kHeight - kBottom - (value - low) / (high - low) * (kHeight - kTop - kBottom);
  };
  std::string svg = "<figure><svg id=\"curve_" + std::string(curve.figure) +
                    "\" viewBox=\"0 0 600 300\" role=\"img\" font-size=\"12\" "
                    "fill=\"#e8e6e1\" aria-label=\"" +
                    HtmlEscaped(curve.what) + "\">\n";
  for (int i = 0; i <= 4; ++i) {
    const double value = low + (high - low) * i / 4.0;
    svg += "<path d=\"M52 " + Fixed(y(value), 1) +
           "H576\" stroke=\"#44433e\"/><text x=\"46\" "
           "y=\"" +
           Fixed(y(value) + 4, 1) + "\" text-anchor=\"end\">" +
           Fixed(value, curve.digits) + "</text>\n";
  }
  if (curve.right) {
    svg += "<path d=\"M52 " + Fixed(y(*curve.right), 1) +
           "H576\" stroke=\"#8a887f\" stroke-dasharray=\"4 4\"/>\n";
  }
  const std::size_t step = (hours.size() + 7) / 8;
  for (std::size_t i = 0; i < hours.size(); i += step) {
    std::string label = hours[i].pair.name;
    if (hours[i].pair.hour) label = label.substr(label.size() - 5);
    svg += "<text x=\"" + Fixed(x(i), 1) + "\" y=\"290\" text-anchor=\"middle\">" +
           HtmlEscaped(label) + "</text>\n";
  }
  double legend = kLeft;
  for (const auto& [name, unused] : RowsOf(hours.front().score)) {
    std::string line, dots;
    const std::string color = ColorOfRow(name);
    for (std::size_t i = 0; i < hours.size(); ++i) {
      for (const auto& [row, figures] : RowsOf(hours[i].score)) {
        if (row != name) continue;
        const std::string at =
            Fixed(x(i), 1) + " " + Fixed(y(*FigureOf(figures, curve.figure)), 1);
        line += (line.empty() ? "M" : "L") + at;
        dots += "M" + at + "h0";
      }
    }
    svg += "<path d=\"" + line + "\" fill=\"none\" stroke=\"" + color +
           "\" stroke-width=\"2\"/><path d=\"" + dots + "\" stroke=\"" + color +
           "\" stroke-width=\"7\" stroke-linecap=\"round\"/>\n<text x=\"" +
           Fixed(legend, 0) + "\" y=\"20\" fill=\"" + color + "\">" + name + "</text>\n";
    legend += 14.0 + 7.5 * double(name.size());
  }
  return svg + "</svg><figcaption>" + curve.figure + ": " + HtmlEscaped(curve.what) +
         "</figcaption></figure>\n";
}

std::string TableRow(const std::string& head,
                     const std::string& row,
                     const RelightingFigures& figures) {
  std::string line =
      "<tr><th>" + HtmlEscaped(head) + "</th><td>" + HtmlEscaped(row) + "</td>";
  for (const std::string& name : FigureNames()) {
    const std::optional<double> value = FigureOf(figures, name);
    const bool decibel = name == "psnr_low" || name == "ring" || name == "psnr";
    line += "<td>" + (value ? Fixed(*value, decibel ? 2 : 3) : "–") + "</td>";
  }
  return line + "</tr>\n";
}

std::string TableOf(const std::vector<EvaluatedHour>& hours) {
  std::string table = "<table id=\"figures\"><tr><th></th><th></th>";
  for (const std::string& name : FigureNames()) table += "<th>" + name + "</th>";
  table += "</tr>\n";
  if (hours.size() > 1) {
    for (const auto& [name, figures] : RowsOf(MeanScore(hours)))
      table += TableRow("mean", name, figures);
  }
  for (const EvaluatedHour& hour : hours) {
    for (const auto& [name, figures] : RowsOf(hour.score))
      table += TableRow(hour.pair.name, name, figures);
  }
  return table + "</table>\n";
}

}  // namespace

std::string EvaluationPage(const std::string& title,
                           const std::vector<EvaluatedHour>& hours) {
  std::string page = ReportHead(title) + "<h1>" + HtmlEscaped(title) + "</h1>\n";
  page += "<div class=\"photos wide\">\n";
  for (const Curve& curve : kCurves) page += CurveSvg(curve, hours);
  page +=
      "</div>\n<h2>Pictures</h2>\n<p>Result and truth under one exposure, the "
      "truth's. Difference: signed error of luminance after the gain that fits best; "
      "white is right, red too bright, blue too dark, full colour at half of the "
      "truth's 99th percentile and beyond.</p>\n<div class=\"photos\" "
      "style=\"grid-template-columns: repeat(3, 1fr)\">\n";
  for (std::size_t i = 0; i < hours.size(); ++i) {
    const EvaluatedHour& hour = hours[i];
    const std::string id = std::to_string(i), at = hour.pair.name;
    const std::string figures = "psnr_low " + Fixed(hour.score.result.psnr_low, 2) +
                                " dB, corr_low " + Fixed(hour.score.result.corr_low, 3);
    page += ReportFigure("result_" + id, "result at " + at, at + ", result", hour.result);
    page += ReportFigure("truth_" + id, "truth at " + at, at + ", truth", hour.truth);
    page += ReportFigure(
        "difference_" + id, "difference at " + at, "difference: " + figures, hour.error);
  }
  return page + "</div>\n<h2>Figures</h2>\n" + TableOf(hours) + ReportFoot();
}

}  // namespace relight
