// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/report_page.h"

#include "relight/composite/contact_sheet.h"
#include "relight/composite/html_text.h"

#include <cctype>
#include <cstdio>
#include <cstring>

namespace relight {
namespace {

constexpr const char* kStyle = R"(
  body { margin: 0; background: #1b1b1a; color: #e8e6e1; font: 16px/1.45 system-ui, sans-serif; }
  main { max-width: 1280px; margin: 0 auto; padding: 16px; }
  h1 { font-size: 20px; } h2 { font-size: 17px; margin-top: 28px; }
  table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; }
  .off { color: #ff9b7a; }
  .photos { display: grid; gap: 12px;
            grid-template-columns: repeat(auto-fill, minmax(280px, 1fr)); }
  .wide { grid-template-columns: repeat(auto-fill, minmax(560px, 1fr)); }
  figure { margin: 0; } figure img { width: 100%; cursor: zoom-in; }
  figure.large { grid-column: 1 / -1; } figure.large img { cursor: zoom-out; }
  figcaption { font-size: 14px; }
  .sheet { display: grid; gap: 10px;
           grid-template-columns: repeat(auto-fill, minmax(150px, 1fr)); }
  .thumb { color: inherit; text-decoration: none; font-size: 13px; line-height: 1.3; }
  .thumb img, .thumb .none { display: block; height: 120px; max-width: 100%; }
  .thumb b, .thumb span { display: block; }
  svg { max-width: 100%; height: auto; background: #262624; }
)";

constexpr const char* kScript = R"(
  for (const figure of document.querySelectorAll('figure'))
    figure.addEventListener('click', () => figure.classList.toggle('large'));
  for (const thumb of document.querySelectorAll('a.thumb'))
    thumb.addEventListener('click', () =>
        document.getElementById(decodeURIComponent(thumb.hash.slice(1))).classList.add('large'));
)";

// As a link's fragment may hold it.
std::string PercentEncoded(const std::string& text) {
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x80 && std::isalnum(byte) != 0) || c == '-' || c == '_' || c == '.') {
      encoded += c;
      continue;
    }
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X", byte);
    encoded += code;
  }
  return encoded;
}

}  // namespace

std::string ReportHead(const std::string& title) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width\"><title>" +
         HtmlEscaped(title) + "</title><style>" + kStyle +
         "</style></head><body><main>\n";
}

std::string ReportFoot() {
  return "</main><script>" + std::string(kScript) + "</script></body></html>\n";
}

std::string ReportRow(const std::string& what, const std::string& value) {
  return "<tr><th>" + HtmlEscaped(what) + "</th><td>" + HtmlEscaped(value) +
         "</td></tr>\n";
}

std::string ReportFigure(const std::string& id,
                         const std::string& alt,
                         const std::string& caption,
                         const cv::Mat3b& picture) {
  return "<figure id=\"" + HtmlEscaped(id) + "\"><img alt=\"" + HtmlEscaped(alt) +
         "\" src=\"data:image/jpeg;base64," + Base64(JpegOf(picture, 80)) +
         "\"><figcaption>" + HtmlEscaped(caption) + "</figcaption></figure>\n";
}

std::string ReportThumbnail(const std::string& figure_id,
                            const std::string& alt,
                            const std::vector<std::string>& lines,
                            bool is_off,
                            const cv::Mat3b& picture) {
  const std::string tag = figure_id.empty() ? "div" : "a";
  std::string html = "<" + tag + " class=\"thumb\"";
  if (!figure_id.empty()) html += " href=\"#" + PercentEncoded(figure_id) + "\"";
  html += ">";
  if (picture.empty()) {
    html += "<span class=\"none\"></span>";
  } else {
    html += "<img alt=\"" + HtmlEscaped(alt) + "\" src=\"data:image/jpeg;base64," +
            Base64(JpegOf(picture, 75)) + "\">";
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool is_last = i + 1 == lines.size();
    html += i == 0 ? "<b>" : is_last && is_off ? "<span class=\"off\">" : "<span>";
    html += HtmlEscaped(lines[i]) + (i == 0 ? "</b>" : "</span>");
  }
  return html + "</" + tag + ">\n";
}

std::string Fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  const bool is_zero = std::strpbrk(text, "123456789n") == nullptr;
  return is_zero && text[0] == '-' ? text + 1 : text;
}

}  // namespace relight
