// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/swept_transmittance.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/sweep_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace relight {
namespace {

constexpr int kBorder = 2;    // Lines beside the grid may still enter it, one voxel off
constexpr int kSlack = 64;    // Empty voxels behind a row, for whole vectors
constexpr int kGroup = 32;    // Directions whose depths are in memory at once
constexpr int kBlock = 1024;  // Voxels a task

// The grid with one axis as the slowest: planes of rows, a border of empty voxels, in
// optical depth per voxel edge. Of a row there is what lines through it and through those
// beside it may read.
struct Planes {
  std::array<int, 3> axis{};   // Of the world: along a row, across rows, across planes.
  std::array<int, 3> cells{};  // In that order.
  std::ptrdiff_t stride = 0;   // Of a row with border and slack.
  std::vector<float> depth_per_edge;
  std::vector<std::ptrdiff_t> zero;  // Per row with border: where its voxel 0 would be,
  std::vector<int> first, last;      // what may be non-empty,
  std::vector<int> from, to;         // and where lines change in it
  std::vector<std::int32_t> row_begin;  // Voxels of a row: [row_begin[r], [r + 1])
  std::vector<std::int32_t> at;         // Their place in the row, border included,
  std::vector<std::int32_t> number;     // and their number among the occupied.

  int Rows() const { return cells[1] + 2 * kBorder; }
};

Planes PlanesAcross(const ExtinctionGrid& grid,
                    const OccupiedVoxels& occupied,
                    int axis) {
  Planes p;
  p.axis = axis == 2   ? std::array{0, 1, 2}
           : axis == 1 ? std::array{0, 2, 1}
                       : std::array{1, 2, 0};
  for (std::size_t a = 0; a < 3; ++a) p.cells[a] = grid.cells[p.axis[a]];
  p.stride = p.cells[0] + 2 * kBorder + kSlack;
  const std::size_t rows =
      static_cast<std::size_t>(p.Rows()) * static_cast<std::size_t>(p.cells[2]);
  p.first.assign(rows, std::numeric_limits<int>::max());
  p.last.assign(rows, -1);
  p.row_begin.assign(rows + 1, 0);
  const auto row_of = [&](const Eigen::Vector3i& cell) {
    return static_cast<std::size_t>(cell[p.axis[2]]) *
               static_cast<std::size_t>(p.Rows()) +
           static_cast<std::size_t>(cell[p.axis[1]] + kBorder);
  };

  // Voxels by rows (counting sort, so that the order is fixed)
  for (const Eigen::Vector3i& cell : occupied.cell) ++p.row_begin[row_of(cell) + 1];
  for (std::size_t r = 0; r < rows; ++r) p.row_begin[r + 1] += p.row_begin[r];
  std::vector<std::int32_t> next(p.row_begin.begin(), p.row_begin.end() - 1);
  p.at.resize(occupied.cell.size());
  p.number.resize(occupied.cell.size());
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& cell = occupied.cell[v];
    const std::size_t row = row_of(cell);
    const int x = cell[p.axis[0]] + kBorder;
    const auto place = static_cast<std::size_t>(next[row]++);
    p.at[place] = x;
    p.number[place] = static_cast<std::int32_t>(v);
    p.first[row] = std::min(p.first[row], x);
    p.last[row] = std::max(p.last[row], x);
  }

  // A line changes in the row itself and where it reaches into one beside it
  p.from.assign(rows, 0);
  p.to.assign(rows, 0);
  for (int k = 0; k < p.cells[2]; ++k) {
    for (int j = 1; j + 1 < p.Rows(); ++j) {
      const auto row = static_cast<std::size_t>(k) * static_cast<std::size_t>(p.Rows()) +
                       static_cast<std::size_t>(j);
      int from = std::numeric_limits<int>::max(), to = -1;
      for (std::size_t r = row - 1; r <= row + 1; ++r) {
        from = std::min(from, p.first[r]);
        to = std::max(to, p.last[r]);
      }
      if (to < 0) continue;
      p.from[row] = from - 1;
      p.to[row] = to + 2;
    }
  }

  // Lines read one voxel to each side, and whole vectors
  p.zero.assign(rows, 0);
  std::ptrdiff_t size = 0;
  for (int k = 0; k < p.cells[2]; ++k) {
    const int plane = k * p.Rows(), end = plane + p.Rows();
    for (int row = plane; row < end; ++row) {
      int from = std::numeric_limits<int>::max(), to = 0;
      for (int beside = std::max(plane, row - 1); beside < std::min(end, row + 2);
           ++beside) {
        const auto r = static_cast<std::size_t>(beside);
        if (p.from[r] >= p.to[r]) continue;
        from = std::min(from, p.from[r] - 1);
        to = std::max(to, p.to[r] + 1 + kSlack);
      }
      if (to == 0) continue;
      p.zero[static_cast<std::size_t>(row)] = size - from;
      size += to - from;
    }
  }
  p.depth_per_edge.assign(static_cast<std::size_t>(size), 0.0f);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::int32_t v = p.row_begin[r]; v < p.row_begin[r + 1]; ++v) {
      const auto place = static_cast<std::size_t>(v);
      const Eigen::Vector3i& cell =
          occupied.cell[static_cast<std::size_t>(p.number[place])];
      p.depth_per_edge[static_cast<std::size_t>(p.zero[r] + p.at[place])] =
          grid.At(cell.x(), cell.y(), cell.z()) * static_cast<float>(grid.cell_m);
    }
  }
  return p;
}

// Where all lines go in half a plane's thickness: along the row to the next voxel, to the
// row above (else to the one below), and which of both comes first.
struct HalfWay {
  std::ptrdiff_t along = 1;
  bool up = false, along_first = false;

  // `above`, `below`: from a voxel to those of the rows beside its own.
  void Lead(std::ptrdiff_t above, std::ptrdiff_t below, HalfStep& half) const {
    const std::ptrdiff_t across = up ? above : below;
    half.offset[0] = along_first ? along : across;
    half.offset[1] = along + across;
  }
};

// The at most three voxels that all lines cross in half a plane's thickness: from `at` in
// their voxel, moving by `move`, both in voxel edges. Lengths go to `half`.
HalfWay CrossHalf(const std::array<double, 2>& at,
                  const std::array<double, 2>& move,
                  double length,
                  HalfStep& half) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::array<double, 2> crossing{};
  for (std::size_t a = 0; a < 2; ++a) {
    crossing[a] = move[a] > 0   ? (1 - at[a]) / move[a]
                  : move[a] < 0 ? at[a] / -move[a]
                                : kFar;
  }
  const std::size_t first = crossing[0] <= crossing[1] ? 0 : 1, second = 1 - first;
  const double one = std::min(1.0, crossing[first]);
  const double two = std::min(1.0, crossing[second]);
  half.length[0] = static_cast<float>(length * one);
  half.length[1] = static_cast<float>(length * (two - one));
  half.length[2] = static_cast<float>(length * (1 - two));
  return {move[0] > 0 ? 1 : -1, move[1] > 0, first == 0};
}

// (S6) for one direction; depths in the order of the planes' voxels.
void SweepDepths(const Planes& p,
                 const Eigen::Vector3d& direction,
                 std::vector<float>& lines,
                 float* depths) {
  const std::array<double, 3> d = {
      direction[p.axis[0]], direction[p.axis[1]], direction[p.axis[2]]};
  const double length = 1 / std::abs(d[2]);
  const std::array<double, 2> slope = {d[0] * length, d[1] * length};

  // Where the lines are on each plane, counted from the outermost
  const auto shift = [&](int t, std::size_t a) { return 0.5 - t * slope[a]; };
  const int planes = p.cells[2];
  std::array<int, 2> low{}, high{};
  for (std::size_t a = 0; a < 2; ++a) {
    const int end = static_cast<int>(std::floor(shift(planes - 1, a)));
    low[a] = std::min(0, end);
    high[a] = std::max(0, end);
  }
  const std::ptrdiff_t line_stride = p.stride + high[0] - low[0];
  const std::ptrdiff_t line_rows = p.Rows() + high[1] - low[1];
  lines.assign(static_cast<std::size_t>(line_stride * line_rows + kSlack), 0.0f);

  std::vector<float> row_depths(static_cast<std::size_t>(p.stride));
  for (int t = 0; t < planes; ++t) {
    const int k = d[2] > 0 ? planes - 1 - t : t;
    const int ox = static_cast<int>(std::floor(shift(t, 0)));
    const int oy = static_cast<int>(std::floor(shift(t, 1)));
    const std::array<double, 2> at = {shift(t, 0) - ox, shift(t, 1) - oy};
    PlaneStep step;
    step.half = static_cast<float>(length / 2);
    const HalfWay outer =
        CrossHalf(at, {slope[0] / 2, slope[1] / 2}, length / 2, step.outer);
    const HalfWay inner =
        CrossHalf(at, {-slope[0] / 2, -slope[1] / 2}, length / 2, step.inner);
    for (int j = 1; j + 1 < p.Rows(); ++j) {
      const auto row = static_cast<std::size_t>(k) * static_cast<std::size_t>(p.Rows()) +
                       static_cast<std::size_t>(j);
      if (p.from[row] >= p.to[row]) continue;
      float* line = lines.data() + (j - oy + high[1]) * line_stride - ox + high[0];
      const float* sigma = p.depth_per_edge.data() + p.zero[row];
      const std::ptrdiff_t above = p.zero[row + 1] - p.zero[row];
      const std::ptrdiff_t below = p.zero[row - 1] - p.zero[row];
      outer.Lead(above, below, step.outer);
      inner.Lead(above, below, step.inner);
      SweepRow(step, sigma, line, row_depths.data(), p.from[row], p.to[row]);
      for (std::int32_t v = p.row_begin[row]; v < p.row_begin[row + 1]; ++v) {
        const auto place = static_cast<std::size_t>(v);
        depths[place] = row_depths[static_cast<std::size_t>(p.at[place])];
      }
    }
  }
}

int AxisMostAlong(const Eigen::Vector3d& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

}  // namespace

std::vector<std::vector<float>> ProjectSwept(const ExtinctionGrid& grid,
                                             const OccupiedVoxels& occupied,
                                             std::span<const Eigen::Vector3d> directions,
                                             std::span<const float> basis,
                                             const Progress& progress,
                                             const FurtherDepth& further,
                                             double clumping) {
  Require(!directions.empty() && basis.size() % directions.size() == 0,
          "as many functions of every direction");
  const std::size_t functions = basis.size() / directions.size();
  const std::size_t voxels = occupied.cell.size();
  std::vector<std::vector<float>> result(functions, std::vector<float>(voxels, 0.0f));
  if (voxels == 0) return result;
  const std::size_t padded = (voxels + kBlock - 1) / kBlock * kBlock;
  std::vector<float> depths(padded * kGroup, 0.0f), sums;
  std::size_t done = 0;
  for (int axis = 2; axis >= 0; --axis) {
    std::vector<std::size_t> chosen;
    for (std::size_t d = 0; d < directions.size(); ++d) {
      if (AxisMostAlong(directions[d]) == axis) chosen.push_back(d);
    }
    if (chosen.empty()) continue;
    const Planes planes = PlanesAcross(grid, occupied, axis);
    sums.assign(padded * functions, 0.0f);
    for (std::size_t begin = 0; begin < chosen.size(); begin += kGroup) {
      const std::size_t size = std::min<std::size_t>(kGroup, chosen.size() - begin);
      ParallelRanges(static_cast<int>(size), 1, [&](int from, int to) {
        std::vector<float> lines;
        for (int d = from; d < to; ++d) {
          const auto place = static_cast<std::size_t>(d);
          const Eigen::Vector3d& direction = directions[chosen[begin + place]];
          float* depth = &depths[place * padded];
          SweepDepths(planes, direction, lines, depth);
          for (std::size_t v = 0; clumping > 0 && v < voxels; ++v) {
            depth[v] = static_cast<float>(std::log1p(clumping * depth[v]) / clumping);
          }
          if (!further) continue;
          std::vector<float> more(voxels, 0.0f);
          further(direction, more);
          for (std::size_t v = 0; v < voxels; ++v) {
            depth[v] += more[static_cast<std::size_t>(planes.number[v])];
          }
        }
      });
      std::vector<float> factors;
      for (std::size_t d = begin; d < begin + size; ++d) {
        const float* b = &basis[chosen[d] * functions];
        factors.insert(factors.end(), b, b + functions);
      }
      ParallelRanges(static_cast<int>(padded / kBlock), 1, [&](int from, int to) {
        for (int block = from; block < to; ++block) {
          const std::size_t first = static_cast<std::size_t>(block) * kBlock;
          AddProjection(&depths[first],
                        padded,
                        size,
                        factors.data(),
                        functions,
                        &sums[first],
                        padded,
                        kBlock);
        }
      });
      done += size;
      progress.Report(static_cast<double>(done) / static_cast<double>(directions.size()));
    }
    ParallelRanges(static_cast<int>(functions), 1, [&](int from, int to) {
      for (int c = from; c < to; ++c) {
        const float* sum = &sums[static_cast<std::size_t>(c) * padded];
        std::vector<float>& out = result[static_cast<std::size_t>(c)];
        for (std::size_t v = 0; v < voxels; ++v) {
          out[static_cast<std::size_t>(planes.number[v])] += sum[v];
        }
      }
    });
  }
  return result;
}

std::vector<float> TransmittanceSwept(const ExtinctionGrid& grid,
                                      const OccupiedVoxels& occupied,
                                      const Eigen::Vector3d& direction) {
  const float one = 1.0f;
  return ProjectSwept(grid, occupied, {&direction, 1}, {&one, 1}).front();
}

}  // namespace relight
