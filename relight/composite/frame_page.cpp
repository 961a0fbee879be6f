// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/frame_page.h"

#include "relight/composite/html_text.h"

#include <nlohmann/json.hpp>

#include <numbers>

namespace relight {
namespace {

// JSON inside of <script>: no "</script>" may stand in it.
std::string ScriptJson(const nlohmann::json& json) {
  std::string text = json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; at += 6) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

constexpr const char* kStyle = R"(
  body { margin: 0; background: #1b1b1a; color: #e8e6e1; font: 16px/1.4 system-ui, sans-serif; }
  main { max-width: 1280px; margin: 0 auto; padding: 12px; }
  h1 { font-size: 18px; font-weight: 600; margin: 0 0 8px; }
  #frame { display: block; max-width: 100%; max-height: 78vh; margin: 0 auto; }
  .controls { display: flex; gap: 12px; align-items: center; margin-top: 12px; }
  #hour { flex: 1; accent-color: #e89614; height: 28px; }
  button { font: inherit; padding: 4px 14px; }
  svg { flex: none; }
  output { display: block; margin-top: 6px; }
)";

constexpr const char* kScript = R"(
  const frame = document.getElementById('frame');
  const hour = document.getElementById('hour');
  const label = document.getElementById('label');
  const play = document.getElementById('play');
  const sun = document.getElementById('sun');
  const ray = document.getElementById('ray');
  function show(i) {
    const f = frames[i];
    frame.src = 'data:image/jpeg;base64,' + f.jpeg;
    frame.alt = f.label;
    label.textContent = f.label + ' – ' + f.light;
    hour.setAttribute('aria-valuetext', f.label);
    const out = 20 * (1 - f.elevation / 90), az = f.azimuth * Math.PI / 180;
    sun.setAttribute('cx', 24 + out * Math.sin(az));
    sun.setAttribute('cy', 24 - out * Math.cos(az));
    ray.setAttribute('x1', 24 + out * Math.sin(az));
    ray.setAttribute('y1', 24 - out * Math.cos(az));
    ray.setAttribute('x2', 24 - 16 * Math.sin(az));
    ray.setAttribute('y2', 24 + 16 * Math.cos(az));
  }
  let timer = 0;
  function stop() { clearInterval(timer); timer = 0; play.textContent = 'Play'; }
  hour.addEventListener('input', () => { stop(); show(+hour.value); });
  play.addEventListener('click', () => {
    if (timer) return stop();
    play.textContent = 'Stop';
    timer = setInterval(() => {
      hour.value = (+hour.value + 1) % frames.length;
      show(+hour.value);
    }, 400);
  });
  show(+hour.value);
)";

}  // namespace

std::string FramePage(const std::string& title, const std::vector<PageFrame>& frames) {
  constexpr double kDegFromRad = 180 / std::numbers::pi;
  nlohmann::json list = nlohmann::json::array();
  for (const PageFrame& frame : frames) {
    list.push_back({{"name", frame.name},
                    {"label", frame.label},
                    {"light", frame.light},
                    {"azimuth", frame.sun_from_heading_rad * kDegFromRad},
                    {"elevation", frame.sun_elevation_rad * kDegFromRad},
                    {"jpeg", Base64(frame.jpeg)}});
  }
  const std::string middle = std::to_string(frames.size() / 2);
  const std::string last = std::to_string(frames.empty() ? 0 : frames.size() - 1);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<link rel=\"icon\" href=\"data:,\">\n<title>" +
         HtmlEscaped(title) + "</title>\n<style>" + kStyle +
         "</style>\n</head>\n<body>\n<main>\n<h1>" + HtmlEscaped(title) +
         "</h1>\n<img id=\"frame\" alt=\"\">\n"
         "<div class=\"controls\">\n<button id=\"play\" type=\"button\">Play</button>\n"
         "<input id=\"hour\" type=\"range\" min=\"0\" max=\"" +
         last + "\" step=\"1\" value=\"" + middle +
         "\" aria-label=\"Hour\">\n"
         "<svg width=\"48\" height=\"48\" role=\"img\" aria-label=\"The sun on a plan, "
         "the "
         "camera below, looking up the page\">"
         "<circle cx=\"24\" cy=\"24\" r=\"20\" fill=\"none\" stroke=\"#8a8780\"/>"
         "<line id=\"ray\" stroke=\"#8a8780\"/>"
         "<circle id=\"sun\" r=\"5\" fill=\"#e89614\"/></svg>\n</div>\n"
         "<output id=\"label\" for=\"hour\"></output>\n</main>\n<script>\n  const frames "
         "= " +
         ScriptJson(list) + ";\n" + kScript + "</script>\n</body>\n</html>\n";
}

}  // namespace relight
