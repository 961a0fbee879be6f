// SPDX-License-Identifier: Apache-2.0
#include "matting/cell_grids.h"

#include "matting/stencil_matrix.h"
#include "relight/base/error.h"

#include <Eigen/LU>

#include <cmath>
#include <utility>

namespace relight {
namespace {

using Vec4 = Cell::Vec4;
using Block = Cell::Block;

constexpr int kDirectCells = 500;  // The coarsest grid has no more.

// Steps on a grid for one of the next finer one. With one, convergence slows with every
// grid more, for cells share nothing at their borders; with two it does not.
constexpr int kSteps = 2;

// Calls body(cell), stripe by stripe (stencil_matrix.h). Stripes have an even number of
// rows, so that no parent has children in two.
template <class Body>
void ForCells(CellGrid& grid,
              bool backwards,
              const Body& body,
              const Progress& progress) {
  ForStripes(
      grid.size.height,
      backwards,
      [&](int begin, int end) {
        const int first = grid.first_of_row[begin], last = grid.first_of_row[end];
        for (int n = 0; n < last - first; ++n) {
          body(grid.cells[backwards ? last - 1 - n : first + n]);
        }
      },
      progress);
}

// Numbers that hold nothing are given a 1 on the diagonal; they stay 0.
void TakeInverses(CellGrid& grid, const Progress& progress) {
  ForCells(
      grid,
      false,
      [](Cell& cell) {
        for (int d = 0; d < 4; ++d) {
          if (cell.a[0](d, d) <= 0) cell.a[0](d, d) = 1;
        }
        cell.inverse = cell.a[0].inverse();
      },
      progress);
}

// (A v) of one cell, without its own block.
Vec4 FromNeighbours(const CellGrid& grid, const Cell& cell, Vec4 Cell::*v) {
  Vec4 sum = Vec4::Zero();
  for (int link = 1; link < kLinks; ++link) {
    if (const int n = cell.later[link]; n >= 0) {
      sum.noalias() += cell.a[link] * grid.cells[n].*v;
    }
    if (const int n = cell.earlier[link]; n >= 0) {
      sum.noalias() += grid.cells[n].a[link].transpose() * grid.cells[n].*v;
    }
  }
  return sum;
}

void Relax(CellGrid& grid, bool backwards, const Progress& progress) {
  ForCells(
      grid,
      backwards,
      [&](Cell& cell) {
        cell.z = cell.inverse * (cell.r - FromNeighbours(grid, cell, &Cell::z));
      },
      progress);
}

double Dot(const CellGrid& grid, Vec4 Cell::*u, Vec4 Cell::*v) {
  double sum = 0;
  for (const Cell& cell : grid.cells) sum += (cell.*u).dot(cell.*v);
  return sum;
}

}  // namespace

OrthonormalBasis::OrthonormalBasis(const Eigen::Matrix4d& gram) {
  // What is less than 1e-4 of a function's own size is lost in the noise of 8 bits, and
  // colours within 1e-6 of each other are one
  constexpr double kDependent = 1e-8, kOneColor = 1e-12;
  for (int d = 0; d < 4; ++d) {
    for (int e = 0; e < d; ++e) {
      if (r(e, e) == 0) continue;
      r(e, d) = (gram(e, d) - r.col(e).head(e).dot(r.col(d).head(e))) / r(e, e);
    }
    const double rest = gram(d, d) - r.col(d).head(d).squaredNorm();
    if (rest <= kDependent * gram(d, d) || rest <= kOneColor * gram(0, 0)) continue;
    r(d, d) = std::sqrt(rest);
    t.col(d) = Eigen::Vector4d::Unit(d);
    for (int e = 0; e < d; ++e) t.col(d) -= r(e, d) * t.col(e);
    t.col(d) /= r(d, d);
  }
}

CellGrid::CellGrid(const cv::Mat1b& inside, const Progress& progress)
    : size(inside.size()) {
  cv::Mat1i index(inside.size(), -1);
  first_of_row.reserve(static_cast<std::size_t>(inside.rows) + 1);
  cells.reserve(static_cast<std::size_t>(cv::countNonZero(inside)));
  for (int y = 0; y < inside.rows; ++y) {
    progress.Report(0);
    first_of_row.push_back(static_cast<int>(cells.size()));
    for (int x = 0; x < inside.cols; ++x) {
      if (!inside(y, x)) continue;
      index(y, x) = static_cast<int>(cells.size());
      cells.emplace_back();
      cells.back().column = x;
      cells.back().row = y;
      cells.back().a.fill(Block::Zero());
    }
  }
  first_of_row.push_back(static_cast<int>(cells.size()));
  const cv::Rect all({0, 0}, inside.size());
  const auto at = [&](int x, int y) { return all.contains({x, y}) ? index(y, x) : -1; };
  for (Cell& cell : cells) {
    if (cell.column == 0) progress.Report(0);
    for (int link = 0; link < kLinks; ++link) {
      const auto [dx, dy] = kLinkOffset[link];
      cell.later[link] = at(cell.column + dx, cell.row + dy);
      cell.earlier[link] = at(cell.column - dx, cell.row - dy);
    }
  }
}

void CellGrid::Couple(int n, int m, const Block& block) {
  for (int link = 0; link < kLinks; ++link) {
    if (cells[n].later[link] == m) {
      cells[n].a[link] += block;
      return;
    }
    if (cells[m].later[link] == n) {
      cells[m].a[link] += block.transpose();
      return;
    }
  }
  Require(false, "cells that are coupled are neighbours");
}

CellGrids::CellGrids(CellGrid finest,
                     const std::vector<CellColors>& colors,
                     const Progress& progress) {
  grids_.push_back(std::move(finest));
  TakeInverses(grids_.back(), progress.Part(0, 0));
  std::vector<CellColors> at = colors;
  while (static_cast<int>(grids_.back().cells.size()) > kDirectCells) {
    at = AddCoarser(at, progress.Part(0, 0));
    TakeInverses(grids_.back(), progress.Part(0, 0));
  }
  FactoriseCoarsest();
}

std::vector<CellColors> CellGrids::AddCoarser(const std::vector<CellColors>& fine_colors,
                                              const Progress& progress) {
  CellGrid& fine = grids_.back();
  cv::Mat1b inside(
      (fine.size.height + 1) / 2, (fine.size.width + 1) / 2, std::uint8_t{0});
  for (const Cell& cell : fine.cells) inside(cell.row / 2, cell.column / 2) = 1;
  CellGrid coarse(inside, progress);
  for (int y = 0; y < fine.size.height; ++y) {
    int c = coarse.first_of_row[y / 2];
    for (int n = fine.first_of_row[y]; n < fine.first_of_row[y + 1]; ++n) {
      while (coarse.cells[c].column < fine.cells[n].column / 2) ++c;
      fine.cells[n].parent = c;
    }
  }

  // Long loops look now and then whether to go on
  const auto look = [&](std::size_t n) {
    if (n % 0x8000 == 0) progress.Report(0);
  };
  std::vector<CellColors> colors(coarse.cells.size());
  for (std::size_t n = 0; n < fine.cells.size(); ++n) {
    look(n);
    CellColors& of = colors[fine.cells[n].parent];
    of.pixels += fine_colors[n].pixels;
    of.mean += fine_colors[n].pixels * fine_colors[n].mean;
  }
  for (CellColors& of : colors) of.mean /= of.pixels;

  // The parent's phi in a cell's numbers: means differ, so phi_parent = phi S
  const auto parent_phi = [&](std::size_t n) {
    Eigen::Matrix4d shift = Eigen::Matrix4d::Identity();
    shift.block<1, 3>(0, 1) =
        (fine_colors[n].mean - colors[fine.cells[n].parent].mean).transpose();
    return Eigen::Matrix4d(fine_colors[n].r * shift);
  };
  std::vector<Eigen::Matrix4d> gram(coarse.cells.size(), Eigen::Matrix4d::Zero());
  for (std::size_t n = 0; n < fine.cells.size(); ++n) {
    look(n);
    const Eigen::Matrix4d phi = parent_phi(n);
    gram[fine.cells[n].parent] += phi.transpose() * phi;
  }
  std::vector<Eigen::Matrix4d> t(coarse.cells.size());
  for (std::size_t c = 0; c < coarse.cells.size(); ++c) {
    look(c);
    const OrthonormalBasis basis(gram[c]);
    colors[c].r = basis.r;
    t[c] = basis.t;
  }
  for (std::size_t n = 0; n < fine.cells.size(); ++n) {
    look(n);
    fine.cells[n].from_parent = (parent_phi(n) * t[fine.cells[n].parent]).cast<float>();
  }

  // P^T A P
  for (int y = 0; y < fine.size.height; ++y) {
    progress.Report(0);
    for (int n = fine.first_of_row[y]; n < fine.first_of_row[y + 1]; ++n) {
      const Cell& cell = fine.cells[n];
      for (int link = 0; link < kLinks; ++link) {
        if (cell.later[link] < 0) continue;
        const Cell& other = fine.cells[cell.later[link]];
        Block block = cell.from_parent.transpose() * cell.a[link] * other.from_parent;
        if (link > 0 && cell.parent == other.parent) block += block.transpose().eval();
        coarse.Couple(cell.parent, other.parent, block);
      }
    }
  }
  grids_.push_back(std::move(coarse));
  return colors;
}

void CellGrids::FactoriseCoarsest() {
  const CellGrid& grid = grids_.back();
  std::vector<Eigen::Triplet<double>> lower;
  for (int n = 0; n < static_cast<int>(grid.cells.size()); ++n) {
    for (int link = 0; link < kLinks; ++link) {
      const int m = grid.cells[n].later[link];
      if (m < 0) continue;
      for (int i = 0; i < 4; ++i) {
        for (int j = link == 0 ? i : 0; j < 4; ++j) {
          lower.emplace_back(4 * m + j, 4 * n + i, grid.cells[n].a[link](i, j));
        }
      }
    }
  }
  const int unknowns = 4 * static_cast<int>(grid.cells.size());
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(lower.begin(), lower.end());
  coarsest_.compute(matrix);
  Require(coarsest_.info() == Eigen::Success, "the coarsest matting system is regular");
}

void CellGrids::SolveCoarsest() {
  CellGrid& grid = grids_.back();
  Eigen::VectorXd b(4 * static_cast<Eigen::Index>(grid.cells.size()));
  for (std::size_t n = 0; n < grid.cells.size(); ++n) {
    b.segment<4>(4 * static_cast<Eigen::Index>(n)) = grid.cells[n].b.cast<double>();
  }
  b = coarsest_.solve(b).eval();
  for (std::size_t n = 0; n < grid.cells.size(); ++n) {
    grid.cells[n].x = b.segment<4>(4 * static_cast<Eigen::Index>(n)).cast<float>();
  }
}

void CellGrids::Solve(std::size_t level, const Progress& progress) {
  if (level + 1 == grids_.size()) return SolveCoarsest();
  CellGrid& grid = grids_[level];
  ForCells(
      grid,
      false,
      [](Cell& cell) {
        cell.x.setZero();
        cell.r = cell.b;
      },
      progress);
  double before = 0, step = 0;
  for (int n = 0; n < kSteps; ++n) {
    Cycle(level, progress);
    const double rz = Dot(grid, &Cell::r, &Cell::z);
    if (rz <= 0) return;
    // Conjugate to the direction before, though the cycle is not quite linear
    const auto turn =
        static_cast<float>(n == 0 ? 0 : -step * Dot(grid, &Cell::z, &Cell::ap) / before);
    ForCells(
        grid, false, [&](Cell& cell) { cell.p = cell.z + turn * cell.p; }, progress);
    ForCells(
        grid,
        false,
        [&](Cell& cell) {
          cell.ap = cell.a[0] * cell.p + FromNeighbours(grid, cell, &Cell::p);
        },
        progress);
    step = Dot(grid, &Cell::r, &Cell::p) / Dot(grid, &Cell::p, &Cell::ap);
    before = rz;
    ForCells(
        grid,
        false,
        [&](Cell& cell) {
          cell.x += static_cast<float>(step) * cell.p;
          cell.r -= static_cast<float>(step) * cell.ap;
        },
        progress);
  }
}

// z near A^-1 r.
void CellGrids::Cycle(std::size_t level, const Progress& progress) {
  CellGrid& grid = grids_[level];
  CellGrid& coarse = grids_[level + 1];
  ForCells(
      grid, false, [](Cell& cell) { cell.z.setZero(); }, progress);
  Relax(grid, false, progress);
  ForCells(
      coarse, false, [](Cell& cell) { cell.b.setZero(); }, progress);
  ForCells(
      grid,
      false,
      [&](Cell& cell) {
        const Vec4 left =
            cell.r - cell.a[0] * cell.z - FromNeighbours(grid, cell, &Cell::z);
        coarse.cells[cell.parent].b.noalias() += cell.from_parent.transpose() * left;
      },
      progress);
  Solve(level + 1, progress);
  ForCells(
      grid,
      false,
      [&](Cell& cell) {
        cell.z.noalias() += cell.from_parent * coarse.cells[cell.parent].x;
      },
      progress);
  Relax(grid, true, progress);
}

}  // namespace relight
