// SPDX-License-Identifier: Apache-2.0
#include "matting/color_multigrid.h"

#include <algorithm>
#include <array>
#include <utility>

namespace relight {
namespace {

using Vec4 = Cell::Vec4;
using Block = Cell::Block;

constexpr int kPixels = 4;  // Edge of the finest cells in pixels; twice the reach.

cv::Mat1b CellsOf(const PixelRuns& pixels, cv::Size image) {
  cv::Mat1b inside((image.height + kPixels - 1) / kPixels,
                   (image.width + kPixels - 1) / kPixels,
                   std::uint8_t{0});
  for (const PixelRun& run : pixels.runs) {
    const int first = run.x / kPixels, last = (run.x + run.length - 1) / kPixels;
    for (int x = first; x <= last; ++x) inside(run.y / kPixels, x) = 1;
  }
  return inside;
}

}  // namespace

// Calls body(cell, x, slot, phi) for the pixels of a row.
template <class Body>
void ColorMultigrid::ForPixels(const CellGrid& grid, int row, const Body& body) const {
  int cell = grid.first_of_row[row / kPixels];
  for (const PixelRun& run : a_.pixels->OfRow(row)) {
    for (int i = 0; i < run.length; ++i) {
      const int x = run.x + i;
      while (grid.cells[cell].column < x / kPixels) ++cell;
      const cv::Vec3f& color = image_(row, x);
      const Eigen::Vector3f& mean = mean_[cell];
      body(cell,
           x,
           run.below[0] + i,
           Phi(1, color[0] - mean[0], color[1] - mean[1], color[2] - mean[2]));
    }
  }
}

// Calls body(first cell, end cell, first row of pixels, end row) for the rows of cells.
template <class Body>
void ColorMultigrid::ForCellRows(const CellGrid& grid,
                                 const Body& body,
                                 const Progress& progress) const {
  ForStripes(
      grid.size.height,
      false,
      [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
          body(grid.first_of_row[y],
               grid.first_of_row[y + 1],
               y * kPixels,
               std::min((y + 1) * kPixels, image_.rows));
        }
      },
      progress);
}

ColorMultigrid::ColorMultigrid(const StencilMatrix& a,
                               const cv::Mat3f& image,
                               const Progress& progress)
    : a_(a), image_(image), rest_(static_cast<std::size_t>(a.pixels->slots)) {
  progress.Report(0);
  CellGrid finest(CellsOf(*a.pixels, image.size()), progress.Part(0, 0));
  progress.Report(0);
  const auto colors = FindColors(finest, progress.Part(0, 0.4));
  Project(finest, progress.Part(0.4, 0.9));
  grids_ = std::make_unique<CellGrids>(std::move(finest), colors, progress.Part(0.9, 1));
  progress.Report(1);
}

// Means, then T and R of (M6).
std::vector<CellColors> ColorMultigrid::FindColors(const CellGrid& grid,
                                                   const Progress& progress) {
  std::vector<CellColors> colors(grid.cells.size());
  mean_.assign(colors.size(), Eigen::Vector3f::Zero());
  t_.assign(colors.size(), Block::Zero());
  ForCellRows(
      grid,
      [&](int first, int last, int begin, int end) {
        for (int y = begin; y < end; ++y) {
          ForPixels(grid, y, [&](int cell, int, std::int32_t, const Phi& phi) {
            colors[cell].pixels += 1;
            colors[cell].mean += phi.tail<3>().cast<double>();
          });
        }
        for (int c = first; c < last; ++c) {
          mean_[c] = (colors[c].mean / colors[c].pixels).cast<float>();
          colors[c].mean = mean_[c].cast<double>();
        }
        std::vector<Eigen::Matrix4d> gram(last - first, Eigen::Matrix4d::Zero());
        for (int y = begin; y < end; ++y) {
          ForPixels(grid, y, [&](int cell, int, std::int32_t, const Phi& phi) {
            const Eigen::Vector4d exact = phi.cast<double>();
            gram[cell - first] += exact * exact.transpose();
          });
        }
        for (int c = first; c < last; ++c) {
          const OrthonormalBasis basis(gram[c - first]);
          colors[c].r = basis.r;
          t_[c] = basis.t.cast<float>();
        }
      },
      progress);
  return colors;
}

// P^T A P of the finest cells.
void ColorMultigrid::Project(CellGrid& grid, const Progress& progress) const {
  const auto wide = static_cast<std::size_t>(image_.cols);
  ForCellRows(
      grid,
      [&](int, int, int begin, int end) {
        // P of the pixels of the row, and of those below that they reach
        const int reach = std::min(end + 2, image_.rows);
        std::vector<Vec4> p(wide * static_cast<std::size_t>(reach - begin), Vec4::Zero());
        const auto basis = [&](int x, int y) -> Vec4& {
          return p[static_cast<std::size_t>(y - begin) * wide +
                   static_cast<std::size_t>(x)];
        };
        for (int y = begin; y < reach; ++y) {
          ForPixels(grid, y, [&](int cell, int x, std::int32_t, const Phi& phi) {
            basis(x, y).noalias() = t_[cell].transpose() * phi;
          });
        }
        for (int y = begin; y < end; ++y) {
          ForPixels(grid, y, [&](int cell, int x, std::int32_t slot, const Phi&) {
            ProjectPixel(grid, cell, {x, y}, slot, basis);
          });
        }
      },
      progress);
}

template <class Basis>
void ColorMultigrid::ProjectPixel(
    CellGrid& grid, int cell, cv::Point at, std::int32_t slot, const Basis& basis) const {
  // A P of the neighbours that come later, cell by cell: left, own, right; those below
  std::array<Vec4, 6> sum;
  std::array<bool, 6> any{};
  for (int k = 0; k < kStencil; ++k) {
    const float value = a_.entry[k][slot];
    if (value == 0) continue;  // Also what would be outside the image
    const auto [dx, dy] = kStencilOffset[k];
    const int to = ((at.y + dy) / kPixels - at.y / kPixels) * 3 +
                   (at.x + dx + kPixels) / kPixels - at.x / kPixels;
    if (!any[to]) sum[to].setZero();
    any[to] = true;
    // Its own cell takes both halves of the symmetric A: the diagonal is in each
    sum[to] += (k == 0 ? 0.5f : 1.0f) * value * basis(at.x + dx, at.y + dy);
  }
  const Vec4 own = basis(at.x, at.y);
  for (int to = 0; to < 6; ++to) {
    if (!any[to]) continue;
    const Block block = own * sum[to].transpose();
    const Cell& here = grid.cells[cell];
    switch (to) {
      case 0:  // The cell on the left comes earlier
        grid.cells[here.earlier[1]].a[1] += block.transpose();
        break;
      case 1:
        grid.cells[cell].a[0] += block + block.transpose();
        break;
      default:  // Right; below on the left, below, below on the right
        grid.cells[cell].a[to - 1] += block;
    }
  }
}

void ColorMultigrid::Apply(std::span<const float> r,
                           std::span<float> z,
                           const Progress& progress) {
  std::fill(z.begin(), z.end(), 0.0f);
  Relax(a_, r, z, false, progress);
  Multiply<float>(a_, z, rest_, progress);
  CellGrid& grid = grids_->finest();
  ForCellRows(
      grid,
      [&](int first, int last, int begin, int end) {
        for (int c = first; c < last; ++c) grid.cells[c].b.setZero();
        for (int y = begin; y < end; ++y) {
          ForPixels(grid, y, [&](int cell, int, std::int32_t slot, const Phi& phi) {
            grid.cells[cell].b += (r[slot] - rest_[slot]) * phi;
          });
        }
        for (int c = first; c < last; ++c) {
          grid.cells[c].b = (t_[c].transpose() * grid.cells[c].b).eval();
        }
      },
      progress);
  grids_->Solve(progress);
  ForCellRows(
      grid,
      [&](int first, int last, int begin, int end) {
        for (int c = first; c < last; ++c)
          grid.cells[c].x = (t_[c] * grid.cells[c].x).eval();
        for (int y = begin; y < end; ++y) {
          ForPixels(grid, y, [&](int cell, int, std::int32_t slot, const Phi& phi) {
            z[slot] += grid.cells[cell].x.dot(phi);
          });
        }
      },
      progress);
  Relax(a_, r, z, true, progress);
}

}  // namespace relight
