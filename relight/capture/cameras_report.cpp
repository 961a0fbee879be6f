// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/cameras_report.h"

#include "relight/base/angles.h"
#include "relight/capture/camera_overlay.h"
#include "relight/capture/capture_times.h"
#include "relight/capture/report_page.h"
#include "relight/composite/frame_preview.h"
#include "relight/composite/html_text.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/color.h"
#include "relight/photo/read_photo.h"
#include "relight/sky/light_in_words.h"
#include "relight/sky/solar_position.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace relight {
namespace {

struct SunOfView {
  std::optional<SolarPosition> sun;
  std::string when;
};

std::map<std::string, SunOfView> SunsOf(const Capture& capture,
                                        const CalibratedScene& scene) {
  std::map<std::string, SunOfView> suns;
  for (const ViewTime& view : ViewTimesOf(capture)) {
    SunOfView of;
    std::optional<Place> place = view.place;
    if (!place && capture.file.place) place = ParsePlace(*capture.file.place);
    if (!place) place = scene.enu_origin;
    if (view.time) of.when = FormatLocal(*view.time);
    if (view.time && place) of.sun = SolarPositionAt(view.time->utc, *place);
    suns[view.view] = of;
  }
  return suns;
}

// From above, north up: cameras with what they see, sparse points, the tree, the sun.
std::string Map(const CamerasSummary& summary,
                const std::map<std::string, SunOfView>& suns) {
  constexpr double kSize = 720, kBorder = 60;
  const Eigen::Vector2d middle = summary.tree.foot.head<2>();
  double reach_m = 1;
  for (const auto& [view, camera] : summary.scene.cameras) {
    reach_m =
        std::max(reach_m, (camera.PositionInWorld().head<2>() - middle).norm() * 1.05);
  }
  const double scale = (kSize / 2 - kBorder) / reach_m;
  const auto at = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return {kSize / 2 + scale * (p.x() - middle.x()),
            kSize / 2 - scale * (p.y() - middle.y())};
  };
  const auto xy = [](const Eigen::Vector2d& p) {
    return Fixed(p.x(), 1) + "," + Fixed(p.y(), 1);
  };
  std::string svg =
      "<svg viewBox=\"0 0 720 720\" width=\"720\" height=\"720\" role=\"img\" "
      "aria-label=\"Map of the cameras from above\">\n";

  // Points, thinned to some thousand
  const auto& points = summary.scene.points;
  const std::size_t step = points.size() / 3000 + 1;
  std::string dots;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector2d p = points[i].position.head<2>();
    if ((p - middle).norm() > 1.2 * reach_m) continue;
    dots += "M" + xy(at(p)) + "h1";
  }
  svg += "<path d=\"" + dots + "\" stroke=\"#7c7a70\" stroke-width=\"1.5\"/>\n";

  // A ring each 5, 10, 20 or 50 m
  double ring_m = 5;
  while (ring_m * 5 < reach_m) ring_m *= 2;
  for (int n = 1; n * ring_m <= 1.1 * reach_m; ++n) {
    const Eigen::Vector2d c = at(middle);
    svg += "<circle cx=\"" + Fixed(c.x(), 1) + "\" cy=\"" + Fixed(c.y(), 1) + "\" r=\"" +
           Fixed(scale * n * ring_m, 1) +
           "\" fill=\"none\" stroke=\"#45443f\"/><text x=\"" + Fixed(c.x() + 4, 1) +
           "\" y=\"" + Fixed(c.y() - scale * n * ring_m - 3, 1) +
           "\" fill=\"#8f8d84\" font-size=\"12\">" + Fixed(n * ring_m, 0) + " m</text>\n";
  }
  const Eigen::Vector2d tree = at(middle);
  svg += "<circle cx=\"" + Fixed(tree.x(), 1) + "\" cy=\"" + Fixed(tree.y(), 1) +
         "\" r=\"7\" fill=\"#7fc06a\"/>\n";

  std::optional<SolarPosition> sun;
  for (const auto& [view, camera] : summary.scene.cameras) {
    const Eigen::Vector2d eye = at(camera.PositionInWorld().head<2>());
    const double azimuth = AzimuthOf(camera.ForwardInWorld());
    const double half = std::atan(camera.width_px / (2 * camera.focal_px.x()));
    const auto ray = [&](double by) {
      return xy(eye +
                26 * Eigen::Vector2d(std::sin(azimuth + by), -std::cos(azimuth + by)));
    };
    svg += "<path d=\"M" + xy(eye) + "L" + ray(-half) + "L" + ray(half) +
           "Z\" fill=\"#8fb8e8\" fill-opacity=\"0.35\" stroke=\"#8fb8e8\"/><text x=\"" +
           Fixed(eye.x() + 6, 1) + "\" y=\"" + Fixed(eye.y() + 4, 1) +
           "\" fill=\"#c9d8ea\" font-size=\"11\">" + HtmlEscaped(view) + "</text>\n";
    const auto found = suns.find(view);
    if (!sun && found != suns.end()) sun = found->second.sun;
  }

  // The sun of the first photo: from its side, its light falls to the tree
  if (sun && sun->elevation_rad > 0) {
    const Eigen::Vector2d towards(std::sin(sun->azimuth_rad),
                                  -std::cos(sun->azimuth_rad));
    const Eigen::Vector2d disc = tree + (kSize / 2 - 24) * towards;
    const Eigen::Vector2d end = tree + 20 * towards;
    svg += "<path d=\"M" + xy(disc) + "L" + xy(end) +
           "\" stroke=\"#e89614\" stroke-width=\"2\" stroke-dasharray=\"7 5\"/><circle "
           "cx=\"" +
           Fixed(disc.x(), 1) + "\" cy=\"" + Fixed(disc.y(), 1) +
           "\" r=\"11\" fill=\"#e89614\"/>\n";
  }
  svg +=
      "<path d=\"M36 70L36 22M27 36L36 20L45 36\" stroke=\"#ff6f61\" fill=\"none\" "
      "stroke-width=\"3\"/><text x=\"30\" y=\"88\" fill=\"#ff6f61\" "
      "font-size=\"16\">N</text>\n</svg>\n";
  return svg;
}

// ", looks to 210°"; a camera of a drone looks down.
std::string Looks(const Camera& camera) {
  const Eigen::Vector3d forward = camera.ForwardInWorld();
  const double elevation_deg = DegFromRad(ElevationOf(forward));
  if (elevation_deg < -60) return ", looks down";
  if (elevation_deg > 60) return ", looks up";
  return ", looks to " + Fixed(DegFromRad(AzimuthOf(forward)), 0) + "°";
}

std::string Residuals(const Georeference& found) {
  std::string table =
      "<table><tr><th>photo</th><th>GPS, m off</th><th>compass, deg off</th></tr>\n";
  for (const ViewResidual& view : found.residuals) {
    if (!view.gps_m && !view.compass_rad) continue;
    const auto cell = [](const std::string& text, bool is_outlier) {
      return std::string(is_outlier ? "<td class=\"off\">" : "<td>") + text +
             (is_outlier ? ", left out</td>" : "</td>");
    };
    table += "<tr><td>" + HtmlEscaped(view.view) + "</td>" +
             cell(view.gps_m ? Fixed(*view.gps_m, 1) : "", view.gps_is_outlier) +
             cell(view.compass_rad ? Fixed(DegFromRad(*view.compass_rad), 1) : "",
                  view.compass_is_outlier) +
             "</tr>\n";
  }
  return table + "</table>\n";
}

}  // namespace

std::string CamerasReport(const Capture& capture,
                          const CamerasSummary& summary,
                          const Progress& progress) {
  const std::map<std::string, SunOfView> suns = SunsOf(capture, summary.scene);
  const std::string name =
      std::filesystem::absolute(capture.folder).lexically_normal().filename().string();
  std::string page = ReportHead(name + ": cameras") + "<h1>" + HtmlEscaped(name) + ": " +
                     std::to_string(summary.scene.cameras.size()) + " cameras of " +
                     std::to_string(capture.file.views.size()) +
                     " photos</h1>\n<table>\n";
  page += ReportRow("made by", summary.made_by);
  if (const auto& found = summary.georeference) {
    page += ReportRow("north",
                      "from " + found->north_from + ", sure to " +
                          Fixed(DegFromRad(found->north_error_rad), 1) + " deg");
    page += ReportRow("up",
                      "from " + found->up_from + ", sure to " +
                          Fixed(DegFromRad(found->up_error_rad), 1) + " deg");
    page += ReportRow("scale",
                      "from " + found->scale_from + ", sure to " +
                          Fixed(100 * found->scale_error, 1) + " %");
  }
  page += ReportRow("ground",
                    "from " + summary.tree.ground_from + ", " +
                        Fixed(DegFromRad(summary.tree.slope_rad), 1) + " deg steep");
  if (const auto& origin = summary.scene.enu_origin) {
    page += ReportRow(
        "origin",
        Fixed(origin->latitude_deg, 6) + ", " + Fixed(origin->longitude_deg, 6));
  }
  page += "</table>\n";
  std::vector<std::string> notes = summary.notes;
  for (const std::string& doubt : DoubtsOfCapture(capture)) notes.push_back(doubt);
  if (!notes.empty()) {
    page += "<ul>\n";
    for (const std::string& note : notes) page += "<li>" + HtmlEscaped(note) + "</li>\n";
    page += "</ul>\n";
  }
  page +=
      "<h2>From above</h2>\n<p>North is up. Blue: cameras and what they see; green: "
      "the tree's foot; orange: the sun when the first photo was taken.</p>\n" +
      Map(summary, suns);
  if (summary.georeference && !summary.georeference->residuals.empty()) {
    page += "<h2>What is left over</h2>\n" + Residuals(*summary.georeference);
  }
  page +=
      "<h2>Photos</h2>\n<p>Each with the horizon, north, a grid of 10 m on the ground, "
      "the sun, and the shadow that a pole at the tree's foot would cast: when one of "
      "these lies elsewhere in the photo, the camera or the time is wrong. A click "
      "makes a photo large.</p>\n<div class=\"photos\">\n";
  double done = 0;
  for (const auto& [view, camera] : summary.scene.cameras) {
    progress.Report(done / static_cast<double>(summary.scene.cameras.size()));
    done += 1;
    const Photo photo = ReadPhoto(capture.PhotoOf(FindView(capture, view)));
    constexpr int kLongest_px = 1100;
    const double shrink = std::max(1.0,
                                   std::max(photo.pixels.cols, photo.pixels.rows) /
                                       static_cast<double>(kLongest_px));
    cv::Mat3f small;
    cv::resize(photo.pixels,
               small,
               {static_cast<int>(std::lround(photo.pixels.cols / shrink)),
                static_cast<int>(std::lround(photo.pixels.rows / shrink))},
               0,
               0,
               cv::INTER_AREA);
    cv::Mat3b display;
    DisplayFromLinear(small).convertTo(display, CV_8U, 255);
    CameraOverlayOptions options;
    options.ground_z_m = summary.tree.foot.z();
    options.longest_px = kLongest_px;
    if (summary.tree.is_looked_at) options.trunk_foot_in_world = summary.tree.foot;
    std::string words;
    const auto of = suns.find(view);
    if (of != suns.end() && of->second.sun) {
      const SolarPosition& sun = *of->second.sun;
      options.sun_in_world =
          DirectionFromAzimuthElevation(sun.azimuth_rad, sun.elevation_rad);
      words = LightInWords(sun.azimuth_rad - AzimuthOf(camera.ForwardInWorld()),
                           sun.elevation_rad);
    }
    const cv::Mat3b overlay = CameraOverlay(display, camera, options);
    std::string caption = view + Looks(camera);
    if (of != suns.end() && !of->second.when.empty()) caption += ", " + of->second.when;
    if (!words.empty()) caption += ", sun: " + words;
    page += ReportFigure(view, view + " with its overlay", caption, overlay);
  }
  page += "</div>\n" + ReportFoot();
  progress.Report(1);
  return page;
}

}  // namespace relight
