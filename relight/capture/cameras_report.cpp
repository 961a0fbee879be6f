// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/cameras_report.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/capture/camera_overlay.h"
#include "relight/capture/capture_times.h"
#include "relight/capture/photo_heading.h"
#include "relight/capture/report_page.h"
#include "relight/composite/frame_preview.h"
#include "relight/composite/html_text.h"
#include "relight/photo/capture_time.h"
#include "relight/photo/color.h"
#include "relight/photo/photo_facts.h"
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

// What a photo says of itself, apart from its camera.
struct PhotoSays {
  std::optional<SolarPosition> sun;
  std::string when = "no time";
  std::optional<double> compass_deg;  // From true north.
};

std::map<std::string, PhotoSays> PhotosOf(const Capture& capture,
                                          const CalibratedScene& scene) {
  std::map<std::string, PhotoSays> photos;
  for (const ViewTime& view : ViewTimesOf(capture)) {
    PhotoSays of;
    std::optional<Place> place = view.place;
    if (!place && capture.file.place) place = ParsePlace(*capture.file.place);
    if (!place) place = scene.enu_origin;
    if (view.time) of.when = FormatLocal(*view.time);
    if (view.time && place) of.sun = SolarPositionAt(view.time->utc, *place);
    try {
      const PhotoFacts facts =
          ReadPhotoFacts(capture.PhotoOf(FindView(capture, view.view)));
      if (!view.time && facts.local_time) {
        const Instant as_utc(facts.local_time->time_since_epoch());
        of.when = FormatLocal({as_utc, {}}).substr(0, 19) + " of an unknown zone";
      }
      const auto utc = view.time ? std::optional(view.time->utc) : std::nullopt;
      const auto compass = HeadingFromExif(facts, place, utc);
      if (compass) of.compass_deg = compass->heading_deg;
    } catch (const InputError&) {
      // The sheet says it in place of the picture
    }
    photos[view.view] = of;
  }
  return photos;
}

// Of a camera that is neither of a drone nor under the crown.
std::optional<double> HeadingOf(const Camera& camera) {
  const Eigen::Vector3d forward = camera.ForwardInWorld();
  if (std::abs(ElevationOf(forward)) > RadFromDeg(60)) return std::nullopt;
  return AzimuthOf(forward);
}

// " 210°".
std::string HeadingMark(const Camera& camera) {
  const auto heading = HeadingOf(camera);
  return heading ? " " + Fixed(DegFromRad(*heading), 0) + "°" : "";
}

// "looks to 210°"; a camera of a drone looks down.
std::string Looks(const Camera& camera) {
  if (const auto heading = HeadingOf(camera)) {
    return "looks to " + Fixed(DegFromRad(*heading), 0) + "°";
  }
  return camera.ForwardInWorld().z() < 0 ? "looks down" : "looks up";
}

// From above, north up: cameras with what they see, sparse points, the tree, the sun.
std::string Map(const CamerasSummary& summary,
                const std::map<std::string, PhotoSays>& photos) {
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
    const char* const blue =
        " fill=\"#8fb8e8\" fill-opacity=\"0.35\" stroke=\"#8fb8e8\"/>";
    if (const auto azimuth = HeadingOf(camera)) {
      const double half = std::atan(camera.width_px / (2 * camera.focal_px.x()));
      const auto ray = [&](double by) {
        return xy(eye + 26 * Eigen::Vector2d(std::sin(*azimuth + by),
                                             -std::cos(*azimuth + by)));
      };
      svg += "<path d=\"M" + xy(eye) + "L" + ray(-half) + "L" + ray(half) + "Z\"" + blue;
    } else {
      svg += "<circle cx=\"" + Fixed(eye.x(), 1) + "\" cy=\"" + Fixed(eye.y(), 1) +
             "\" r=\"6\"" + blue;
    }
    const std::string label = view + HeadingMark(camera);
    const bool has_room = eye.x() + 6 + 7 * static_cast<double>(label.size()) < kSize;
    svg += "<text x=\"" + Fixed(eye.x() + (has_room ? 6 : -6), 1) + "\" y=\"" +
           Fixed(eye.y() + 4, 1) + (has_room ? "" : "\" text-anchor=\"end") +
           "\" fill=\"#c9d8ea\" font-size=\"11\">" + HtmlEscaped(label) + "</text>\n";
    const auto found = photos.find(view);
    if (!sun && found != photos.end()) sun = found->second.sun;
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

// A photo as a screen shows it, no longer than `longest_px`.
cv::Mat3b Displayed(const cv::Mat3f& pixels, int longest_px) {
  const double shrink =
      std::max(1.0, std::max(pixels.cols, pixels.rows) / static_cast<double>(longest_px));
  const auto shrunk = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(length / shrink)));
  };
  cv::Mat3f small;
  cv::resize(
      pixels, small, {shrunk(pixels.cols), shrunk(pixels.rows)}, 0, 0, cv::INTER_AREA);
  cv::Mat3b display;
  DisplayFromLinear(small).convertTo(display, CV_8U, 255);
  return display;
}

// What became of each photo of the capture, for the contact sheet.
struct Fate {
  std::string words;
  bool is_off = false;
};

Fate FateOf(const std::string& view,
            const Camera* camera,
            const std::map<std::string, Camera>& of_volume,
            const CamerasSummary& summary) {
  if (camera == nullptr) return {"no camera: left out", true};
  const std::string use = of_volume.contains(view)
                              ? "has a camera; the volume is made from it"
                              : "has a camera; the volume is made without it";
  if (!summary.georeference) return {use};
  for (const ViewResidual& residual : summary.georeference->residuals) {
    if (residual.view != view) continue;
    if (residual.gps_is_outlier) return {use + "; its GPS is left out", true};
    if (residual.compass_is_outlier) return {use + "; its compass is left out", true};
  }
  return {use};
}

// A thumbnail of every photo, and a figure of each that has a camera. A photo that cannot
// be read has the reason in place of its picture.
void AppendPhotos(const Capture& capture,
                  const CamerasSummary& summary,
                  const std::map<std::string, PhotoSays>& photos,
                  const Progress& progress,
                  std::string& sheet,
                  std::string& figures) {
  constexpr int kLongest_px = 1100, kThumbnail_px = 200;
  const CaptureOptions given = OptionsFrom(capture.file, {});
  std::map<std::string, Camera> cameras;
  for (const auto& [view, camera] : summary.scene.cameras) cameras.insert({view, camera});
  const auto of_volume = EvenlySpreadViews(cameras, given.selection);
  double done = 0;
  for (const ViewEntry& entry : capture.file.views) {
    progress.Report(done / static_cast<double>(capture.file.views.size()));
    done += 1;
    const std::string& view = entry.name;
    const auto found = cameras.find(view);
    const Camera* const camera = found == cameras.end() ? nullptr : &found->second;
    const PhotoSays& of = photos.at(view);
    std::vector<std::string> lines = {view, of.when};
    if (camera != nullptr) {
      lines.push_back(Looks(*camera));
    } else {
      lines.push_back(of.compass_deg ? "compass " + Fixed(*of.compass_deg, 0) + "°"
                                     : "no compass");
    }
    Fate fate = FateOf(view, camera, of_volume, summary);
    cv::Mat3b display;
    try {
      display =
          Displayed(ReadPhoto(capture.PhotoOf(entry), given.photo).pixels, kLongest_px);
    } catch (const InputError& error) {
      lines.emplace_back(error.what());
      sheet += ReportThumbnail("", view, lines, true, {});
      continue;
    }
    lines.push_back(fate.words);
    cv::Mat3b thumbnail;
    const double shrink =
        static_cast<double>(kThumbnail_px) / std::max(display.cols, display.rows);
    cv::resize(display, thumbnail, {}, shrink, shrink, cv::INTER_AREA);
    sheet += ReportThumbnail(
        camera == nullptr ? "" : view, view, lines, fate.is_off, thumbnail);
    if (camera == nullptr) continue;

    CameraOverlayOptions options;
    options.ground_z_m = summary.tree.foot.z();
    options.longest_px = kLongest_px;
    if (summary.tree.is_looked_at) options.trunk_foot_in_world = summary.tree.foot;
    std::string caption = view + ", " + Looks(*camera) + ", " + of.when;
    if (of.sun) {
      options.sun_in_world =
          DirectionFromAzimuthElevation(of.sun->azimuth_rad, of.sun->elevation_rad);
      if (const auto heading = HeadingOf(*camera)) {
        caption +=
            ", " + LightInWords(of.sun->azimuth_rad - *heading, of.sun->elevation_rad);
      }
    }
    figures += ReportFigure(view,
                            view + " with its overlay",
                            caption,
                            CameraOverlay(display, *camera, options));
  }
}

}  // namespace

std::string CamerasReport(const Capture& capture,
                          const CamerasSummary& summary,
                          const Progress& progress) {
  const std::map<std::string, PhotoSays> photos = PhotosOf(capture, summary.scene);
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
  const bool knows_sun = std::any_of(photos.begin(), photos.end(), [](const auto& of) {
    return of.second.sun.has_value();
  });
  std::string sheet, figures;
  AppendPhotos(capture, summary, photos, progress, sheet, figures);
  page +=
      "<h2>Contact sheet</h2>\n<p>All photos of the capture, when they were taken, which "
      "way they look, and whether they have a camera. A click leads to the photo "
      "below.</p>\n<div class=\"sheet\">\n" +
      sheet + "</div>\n";
  page +=
      std::string(
          "<h2>From above</h2>\n<p>North is up. Blue: cameras, what they see and "
          "their heading; green: the tree's foot; ") +
      (knows_sun
           ? "orange: the sun when the first photo was taken."
           : "the sun is not drawn, for no photo's time and place are known (zone, taken "
             "and place in capture.toml).") +
      "</p>\n" + Map(summary, photos);
  page += "<h2>What is left over</h2>\n";
  const bool is_compared =
      summary.georeference && std::any_of(summary.georeference->residuals.begin(),
                                          summary.georeference->residuals.end(),
                                          [](const ViewResidual& view) {
                                            return view.gps_m || view.compass_rad;
                                          });
  page += is_compared ? Residuals(*summary.georeference)
                      : "<p>Nothing: neither GPS nor a compass was compared with these "
                        "cameras.</p>\n";
  page +=
      "<h2>Photos</h2>\n<p>Each with the horizon, north, a grid of 10 m on the ground, "
      "the sun, and the shadow that a pole at the tree's foot would cast: when one of "
      "these lies elsewhere in the photo, the camera or the time is wrong. A click "
      "makes a photo large.</p>\n<div class=\"photos\">\n" +
      figures + "</div>\n" + ReportFoot();
  progress.Report(1);
  return page;
}

}  // namespace relight
