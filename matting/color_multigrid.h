// SPDX-License-Identifier: Apache-2.0
#pragma once

// A preconditioner for the matting Laplacian: a cycle over grids of cells that hold four
// numbers each.
//
//   [Notay08] docs/bibliography.md#notay08 the cycle
//
// What a matting Laplacian hardly resists is alpha that is affine in colour nearby,
// alpha = a . I + b with a and b that vary slowly: (M2) is made so. A coarse grid of the
// usual kind, which keeps the mean of a cell, cannot hold such an alpha, and gains
// little. So each cell of 4 x 4 pixels keeps what is affine in colour in it, orthonormal,
// and each coarser cell, of 2 x 2 cells, what is affine in colour over all of its pixels:
//
//   phi = (1, R - mean, G - mean, B - mean),   P = phi T,   P^T P = 1         (M6)
//
// Coarse systems are P^T A P. Relaxation is Gauss and Seidel's, forwards before and
// backwards after the correction from the coarse grid, which takes two steps of conjugate
// gradients with a cycle of its own, the K-cycle of [Notay08].
//
// Memory: about 60 bytes a pixel of the system.

#include "matting/cell_grids.h"
#include "matting/stencil_matrix.h"
#include "relight/base/progress.h"

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <memory>
#include <span>
#include <vector>

namespace relight {

class ColorMultigrid {
 public:
  // Keeps references to `a` and `image`. Throws Cancelled.
  ColorMultigrid(const StencilMatrix& a,
                 const cv::Mat3f& image,
                 const Progress& progress = {});

  // z near A^-1 r. Same bytes for any number of threads. Throws Cancelled.
  void Apply(std::span<const float> r, std::span<float> z, const Progress& progress = {});

 private:
  using Phi = Cell::Vec4;

  template <class Body>
  void ForPixels(const CellGrid& grid, int row, const Body& body) const;
  template <class Body>
  void ForCellRows(const CellGrid& grid,
                   const Body& body,
                   const Progress& progress) const;
  std::vector<CellColors> FindColors(const CellGrid& grid, const Progress& progress);
  void Project(CellGrid& grid, const Progress& progress) const;
  template <class Basis>
  void ProjectPixel(CellGrid& grid,
                    int cell,
                    cv::Point at,
                    std::int32_t slot,
                    const Basis& basis) const;

  const StencilMatrix& a_;
  const cv::Mat3f& image_;
  std::vector<Cell::Block> t_;  // T of (M6), of the finest cells.
  std::vector<Eigen::Vector3f> mean_;
  std::unique_ptr<CellGrids> grids_;
  std::vector<float> rest_;
};

}  // namespace relight
