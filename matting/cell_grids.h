// SPDX-License-Identifier: Apache-2.0
#pragma once

// The coarse grids of color_multigrid.h: systems whose unknowns are cells of four numbers
// (what is affine in colour over the pixels of a cell), each coupled to its eight
// neighbours. Each grid halves the one before; the coarsest is solved directly.

#include "relight/base/progress.h"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <opencv2/core.hpp>

#include <array>
#include <vector>

namespace relight {

// T and R of a Gram matrix G = R^T R of four functions: T^T G T = 1 where they are
// independent, a column of zeros for one that depends on those before it.
struct OrthonormalBasis {
  explicit OrthonormalBasis(const Eigen::Matrix4d& gram);
  Eigen::Matrix4d t = Eigen::Matrix4d::Zero(), r = Eigen::Matrix4d::Zero();
};

// The cells that follow a cell: itself, and half of its eight neighbours.
inline constexpr int kLinks = 5;
inline constexpr std::array<std::array<int, 2>, kLinks> kLinkOffset = {
    {{0, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

struct Cell {
  using Vec4 = Eigen::Vector4f;
  using Block = Eigen::Matrix4f;
  int column = 0, row = 0;
  int parent = -1;                                         // In the next coarser grid.
  std::array<int, kLinks> later = {-1, -1, -1, -1, -1};    // later[0]: itself.
  std::array<int, kLinks> earlier = {-1, -1, -1, -1, -1};  // Against the link.
  std::array<Block, kLinks> a = {};                        // A towards later[link].
  Block inverse = Block::Identity();                       // Of a[0].
  Block from_parent = Block::Zero();         // P: to its numbers from its parent's.
  Vec4 b = Vec4::Zero(), x = Vec4::Zero();   // A x = b
  Vec4 r = Vec4::Zero(), z = Vec4::Zero();   // r = b - A x; z near A^-1 r
  Vec4 p = Vec4::Zero(), ap = Vec4::Zero();  // The direction of search, and A p
};

// What is affine in colour over a cell: phi = (1, color - mean) of its pixels, in its own
// orthonormal numbers. Needed while grids are made.
struct CellColors {
  double pixels = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix4d r = Eigen::Matrix4d::Zero();  // Column n: phi_n.
};

struct CellGrid {
  // The cells where `inside` is not 0, linked, A zero.
  explicit CellGrid(const cv::Mat1b& inside, const Progress& progress = {});

  cv::Size size;
  std::vector<Cell> cells;        // In reading order.
  std::vector<int> first_of_row;  // Rows + 1.

  // Adds to A the couplings `block` of cell n with cell m, and what symmetry asks:
  // block^T of m with n. For m = n the block holds both halves already.
  void Couple(int n, int m, const Cell::Block& block);
};

class CellGrids {
 public:
  // `finest`: A set. Takes it over and makes the coarser ones. Throws Cancelled.
  CellGrids(CellGrid finest,
            const std::vector<CellColors>& colors,
            const Progress& progress = {});

  CellGrid& finest() { return grids_.front(); }

  // x near A^-1 b on the finest grid: some steps of conjugate gradients, each with one
  // cycle over the coarser grids, which take as many steps each. Throws Cancelled.
  void Solve(const Progress& progress = {}) { Solve(0, progress); }

 private:
  std::vector<CellColors> AddCoarser(const std::vector<CellColors>& fine_colors,
                                     const Progress& progress);
  void FactoriseCoarsest();
  void SolveCoarsest();
  void Solve(std::size_t level, const Progress& progress);
  void Cycle(std::size_t level, const Progress& progress);

  std::vector<CellGrid> grids_;  // From fine to coarse.
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> coarsest_;
};

}  // namespace relight
