// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/volume_report.h"

#include "relight/base/parallel.h"
#include "relight/capture/report_page.h"
#include "relight/capture/tree_volume.h"
#include "relight/composite/html_text.h"
#include "relight/volume/ray_traversal.h"
#include "relight/volume/vdb_file.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace relight {
namespace {

constexpr int kLongest_px = 420;

// Extinction that is drawn brightest: few voxels hold more.
float BrightestOf(const ExtinctionGrid& grid) {
  std::vector<float> values;
  for (const float sigma : grid.sigma_per_m) {
    if (sigma > 0) values.push_back(sigma);
  }
  if (values.empty()) return 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

cv::Mat3b Colored(const cv::Mat1f& sigma_per_m, float brightest) {
  cv::Mat1b bytes;
  sigma_per_m.convertTo(bytes, CV_8U, 255 / brightest);
  cv::Mat3b bgr, rgb;
  cv::applyColorMap(bytes, bgr, cv::COLORMAP_INFERNO);
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

// Through the middle of what the volume holds, across one axis; the other two run to the
// right and up.
cv::Mat1f Slice(const ExtinctionGrid& grid, int across, int right, int up) {
  double sum = 0, weighted = 0;
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    const double sigma = grid.sigma_per_m[index];
    sum += sigma;
    weighted += sigma * Eigen::Vector3i(x, y, z)[across];
  });
  Eigen::Vector3i at = Eigen::Vector3i::Zero();
  at[across] = sum > 0 ? static_cast<int>(std::lround(weighted / sum)) : 0;
  cv::Mat1f slice(grid.cells[up], grid.cells[right]);
  for (at[up] = 0; at[up] < grid.cells[up]; ++at[up]) {
    for (at[right] = 0; at[right] < grid.cells[right]; ++at[right]) {
      slice(grid.cells[up] - 1 - at[up], at[right]) = grid.At(at.x(), at.y(), at.z());
    }
  }
  return slice;
}

cv::Mat3b Enlarged(const cv::Mat3b& picture) {
  const double by =
      static_cast<double>(kLongest_px) / std::max(picture.cols, picture.rows);
  cv::Mat3b large;
  cv::resize(picture, large, {}, by, by, cv::INTER_NEAREST);
  return large;
}

// The largest extinction along the ray of each pixel.
cv::Mat1f MaximumDensity(const ExtinctionGrid& grid, const Camera& camera) {
  cv::Mat1f most(camera.height_px, camera.width_px);
  const Eigen::Vector3d eye = camera.PositionInWorld();
  ParallelRanges(camera.height_px, 8, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < camera.width_px; ++column) {
        float largest = 0;
        const Ray ray{eye, camera.RayInWorld({column + 0.5, row + 0.5})};
        TraverseRay(grid, ray, 0.0, [&](std::size_t voxel, double, double) {
          largest = std::max(largest, grid.sigma_per_m[voxel]);
          return true;
        });
        most(row, column) = largest;
      }
    }
  });
  return most;
}

// Red where the volume is denser than the matte, blue where it is thinner.
cv::Mat3b Residuals(const cv::Mat1f& opacity, const cv::Mat1f& alpha) {
  cv::Mat3b picture(alpha.size());
  for (int row = 0; row < alpha.rows; ++row) {
    for (int column = 0; column < alpha.cols; ++column) {
      const float apart = opacity(row, column) - alpha(row, column);
      const auto light = cv::saturate_cast<std::uint8_t>(255 * std::abs(apart));
      const auto half = static_cast<std::uint8_t>(light / 3);
      picture(row, column) =
          apart > 0 ? cv::Vec3b(light, half, half) : cv::Vec3b(half, half, light);
    }
  }
  return picture;
}

cv::Mat3b SideBySide(const std::vector<cv::Mat3b>& pictures) {
  constexpr int kGap_px = 6;
  cv::Mat3b all(
      pictures[0].rows,
      static_cast<int>(pictures.size()) * (pictures[0].cols + kGap_px) - kGap_px,
      cv::Vec3b(27, 27, 26));
  int left = 0;
  for (const cv::Mat3b& picture : pictures) {
    picture.copyTo(all.colRange(left, left + picture.cols));
    left += picture.cols + kGap_px;
  }
  return all;
}

// What (V3) was after each pass; resolutions follow each other, the finest last.
std::string Convergence(const std::vector<double>& objective) {
  constexpr double kWidth = 720, kHeight = 260, kBorder = 50;
  const auto [low, high] = std::minmax_element(objective.begin(), objective.end());
  const double bottom = std::log10(*low),
               top = std::max(std::log10(*high), bottom + 0.01);
  std::string path, dots;
  for (std::size_t i = 0; i < objective.size(); ++i) {
    const double x =
        kBorder + (kWidth - 2 * kBorder) * static_cast<double>(i) /
                      std::max(1.0, static_cast<double>(objective.size() - 1));
    const double y =
        kHeight - kBorder -
        (kHeight - 2 * kBorder) * (std::log10(objective[i]) - bottom) / (top - bottom);
    path += (i == 0 ? "M" : "L") + Fixed(x, 1) + "," + Fixed(y, 1);
    dots += "M" + Fixed(x - 1.5, 1) + "," + Fixed(y, 1) + "h3";
  }
  const auto label = [](double x, double y, const std::string& text) {
    return "<text x=\"" + Fixed(x, 0) + "\" y=\"" + Fixed(y, 0) +
           "\" fill=\"#c9c6bd\" font-size=\"12\">" + text + "</text>";
  };
  return "<svg viewBox=\"0 0 720 260\" width=\"720\" height=\"260\" role=\"img\" "
         "aria-label=\"What was minimised, after each pass\"><path d=\"" +
         path + "\" fill=\"none\" stroke=\"#8fb8e8\" stroke-width=\"1.5\"/><path d=\"" +
         dots + "\" stroke=\"#e89614\" stroke-width=\"3\"/>" +
         label(6, kBorder + 4, Fixed(*high, 0)) +
         label(6, kHeight - kBorder + 4, Fixed(*low, 0)) +
         label(kWidth / 2 - 20, kHeight - 14, "passes") + "</svg>\n";
}

std::vector<double> NumbersIn(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number; stream >> number;) {
    if (std::isfinite(number) && number > 0) numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

std::string VolumeReport(const Capture& capture,
                         const CaptureOptions& options,
                         const Progress& progress) {
  const auto file = capture.folder / "volume.vdb";
  const ExtinctionGrid grid = ReadVolume(file);
  Metadata noted = ReadMetadata(file);
  const float brightest = BrightestOf(grid);
  const std::string name =
      std::filesystem::absolute(capture.folder).lexically_normal().filename().string();

  std::string page = ReportHead(name + ": volume") + "<h1>" + HtmlEscaped(name) +
                     ": the volume</h1>\n<table>\n";
  page += ReportRow(
      "voxels",
      std::to_string(grid.cells.x()) + " x " + std::to_string(grid.cells.y()) + " x " +
          std::to_string(grid.cells.z()) + " of " + Fixed(grid.cell_m, 3) + " m; " +
          std::to_string(FindOccupied(grid).cell.size()) + " hold tree");
  page += ReportRow("brightest", Fixed(brightest, 2) + " per m of extinction");
  for (const auto& [key, words] :
       {std::pair{"software", "made by"},
        std::pair{"residual_rms", "mattes met within, rms"},
        std::pair{"hidden_voxels", "voxels no photo sees, filled from around"},
        std::pair{"options", "options"}}) {
    if (!noted[key].empty()) page += ReportRow(words, noted[key]);
  }
  page +=
      "</table>\n<h2>Slices</h2>\n<p>Through the middle of the tree.</p>\n"
      "<div class=\"photos\">\n";
  page += ReportFigure("level",
                       "level slice",
                       "level: north is up, east to the right",
                       Enlarged(Colored(Slice(grid, 2, 0, 1), brightest)));
  page += ReportFigure("south",
                       "upright slice, east to the right",
                       "upright: as seen from the south, east to the right",
                       Enlarged(Colored(Slice(grid, 1, 0, 2), brightest)));
  page += ReportFigure("east",
                       "upright slice, north to the right",
                       "upright: as seen from the east, north to the right",
                       Enlarged(Colored(Slice(grid, 0, 1, 2), brightest)));
  page +=
      "</div>\n<h2>Photos</h2>\n<p>Each: the largest density along the ray of each "
      "pixel; "
      "the matte; where they part, red: the volume is denser than the matte, blue: it "
      "is thinner. A view whose colours are much stronger than the others' has a "
      "matte or a camera to look at.</p>\n<div class=\"photos wide\">\n";
  const std::vector<MatteView> views = MatteViewsOf(capture, options);
  for (std::size_t i = 0; i < views.size(); ++i) {
    progress.Report(static_cast<double>(i) / static_cast<double>(views.size()));
    const MatteView& view = views[i];
    const double shrink = std::max(
        1.0,
        std::max(view.alpha.cols, view.alpha.rows) / static_cast<double>(kLongest_px));
    const cv::Size size(std::max(1, static_cast<int>(view.alpha.cols / shrink)),
                        std::max(1, static_cast<int>(view.alpha.rows / shrink)));
    const Camera camera = view.camera.Resized(size.width, size.height);
    cv::Mat1f alpha;
    cv::resize(view.alpha, alpha, size, 0, 0, cv::INTER_AREA);
    cv::Mat1b bytes;
    alpha.convertTo(bytes, CV_8U, 255);
    cv::Mat3b matte;
    cv::cvtColor(bytes, matte, cv::COLOR_GRAY2RGB);
    page += ReportFigure(view.name,
                         view.name + ": density, matte and difference",
                         view.name + ": " + Fixed(MatteRmse(grid, view), 3) +
                             " rms apart over 0.10 m at the tree",
                         SideBySide({Colored(MaximumDensity(grid, camera), brightest),
                                     matte,
                                     Residuals(RenderOpacity(grid, camera), alpha)}));
  }
  page += "</div>\n";
  if (const auto objective = NumbersIn(noted["objective"]); objective.size() > 1) {
    page +=
        "<h2>Convergence</h2>\n<p>What was minimised, after each pass: from coarse "
        "voxels to fine ones, which begin where the coarse ones end.</p>\n" +
        Convergence(objective);
  }
  progress.Report(1);
  return page + ReportFoot();
}

}  // namespace relight
