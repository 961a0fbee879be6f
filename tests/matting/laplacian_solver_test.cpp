// SPDX-License-Identifier: Apache-2.0
#include "matting/laplacian_solver.h"

#include "matting/color_multigrid.h"
#include "matting/matting_laplacian.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

namespace relight {
namespace {

// A picture with structure at every scale, and a little noise.
cv::Mat3f TexturedImage(cv::Size size) {
  std::mt19937 random(17);
  std::normal_distribution<float> noise(0.0f, 1.5f / 255);
  cv::Mat3f image(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double a = std::sin(0.031 * x + 0.7 * std::sin(0.017 * y));
      const double b = std::sin(0.23 * x - 0.19 * y), c = std::sin(1.1 * y + 0.4 * x);
      const cv::Vec3d color(
          0.4 + 0.2 * a + 0.05 * c, 0.5 + 0.1 * b + 0.08 * c, 0.45 + 0.15 * a * b);
      for (int n = 0; n < 3; ++n) {
        image(y, x)[n] = static_cast<float>(color[n]) + noise(random);
      }
    }
  }
  return image;
}

// All of an image but some holes.
cv::Mat1b Holed(cv::Size size) {
  cv::Mat1b inside(size, std::uint8_t{1});
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (x * x % 37 + y * y % 29 < 6 || x < size.width / 9) inside(y, x) = 0;
    }
  }
  return inside;
}

// L of the textured image plus a weight on the first columns and the last ones, as in
// matting with a band that is unknown.
struct Problem {
  cv::Mat3f image;
  PixelRuns pixels;
  StencilMatrix a;
  std::vector<float> b;

  Problem(cv::Size size, const cv::Mat1b& inside)
      : image(TexturedImage(size)), pixels(inside), a(pixels) {
    AddMattingLaplacian(image, 1e-7, a);
    b.assign(static_cast<std::size_t>(pixels.slots), 0.0f);
    for (const PixelRun& run : pixels.runs) {
      for (int i = 0; i < run.length; ++i) {
        const double place = (run.x + i + 0.5) / size.width;
        if (place > 0.2 && place < 0.8) continue;
        a.entry[0][run.below[0] + i] += 100;
        b[run.below[0] + i] = place > 0.5 ? 100.0f : 0.0f;
      }
    }
  }

  Eigen::MatrixXd Dense() const {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(pixels.slots, pixels.slots);
    for (const PixelRun& run : pixels.runs) {
      for (int i = 0; i < run.length; ++i) {
        const int slot = run.below[0] + i;
        for (int k = 0; k < kStencil; ++k) {
          const auto [dx, dy] = kStencilOffset[k];
          const int other = run.below[dy] + i + dx;
          if (a.entry[k][slot] == 0) continue;
          dense(slot, other) = dense(other, slot) = a.entry[k][slot];
        }
      }
    }
    return dense;
  }
};

TEST(MattingLaplacian, HoldsWhatIsAffineInColour) {
  const cv::Size size(40, 30);
  const Problem problem(size, cv::Mat1b(size, std::uint8_t{1}));
  StencilMatrix l(problem.pixels);
  AddMattingLaplacian(problem.image, 1e-7, l);
  const auto energy_of = [&](const auto& alpha_of) {
    std::vector<double> alpha(static_cast<std::size_t>(problem.pixels.slots));
    std::vector<double> product(alpha.size());
    for (const PixelRun& run : problem.pixels.runs) {
      for (int i = 0; i < run.length; ++i) {
        alpha[run.below[0] + i] = alpha_of(run.x + i, run.y);
      }
    }
    Multiply<double>(l, alpha, product);
    double energy = 0;
    for (std::size_t i = 0; i < alpha.size(); ++i) energy += alpha[i] * product[i];
    return energy / static_cast<double>(problem.pixels.pixels);
  };
  // A constant costs what the rounding of 25 entries near 1 to float leaves
  EXPECT_NEAR(energy_of([](int, int) { return 1.0; }), 0.0, 1e-6);
  const auto affine = [&](int x, int y) {
    const cv::Vec3f& color = problem.image(y, x);
    return 0.1 + 0.9 * color[0] - 0.4 * color[1] + 0.3 * color[2];
  };
  EXPECT_NEAR(energy_of(affine), 0.0, 1e-6);
  // What is not: position, though it varies less
  EXPECT_GT(energy_of([](int x, int y) { return 0.01 * ((x + y) % 2); }), 1e-6);
}

TEST(LaplacianSolver, SolvesAsADenseSolverDoes) {
  const cv::Size size(41, 33);
  const Problem problem(size, Holed(size));
  std::vector<float> x(problem.b.size());
  const SolveSummary summary =
      SolveLaplacian(problem.a, problem.image, problem.b, x, {.relative_residual = 1e-9});
  Eigen::MatrixXd dense = problem.Dense();
  Eigen::VectorXd right(problem.pixels.slots);
  for (int i = 0; i < right.size(); ++i) {
    if (dense(i, i) == 0) dense(i, i) = 1;
    right[i] = problem.b[static_cast<std::size_t>(i)];
  }
  const Eigen::VectorXd exact = dense.ldlt().solve(right);
  // Numbers of 24 bits times a condition of some thousands
  for (int i = 0; i < right.size(); ++i) {
    EXPECT_NEAR(x[static_cast<std::size_t>(i)], exact[i], 2e-4);
  }
  EXPECT_LE(summary.relative_residual, 1e-9);
}

TEST(LaplacianSolver, NeedsTensOfIterationsAtEverySize) {
  for (const int edge : {60, 240, 960}) {
    const cv::Size size(edge, edge);
    const Problem problem(size, Holed(size));
    std::vector<float> x(problem.b.size());
    const SolveSummary summary = SolveLaplacian(problem.a, problem.image, problem.b, x);
    std::printf("%d x %d: %d iterations\n", edge, edge, summary.iterations);
    EXPECT_LE(summary.relative_residual, 1e-8);
    EXPECT_LE(summary.iterations, 50);
  }
}

TEST(LaplacianSolver, IsTheSameForAnyNumberOfThreads) {
  const cv::Size size(300, 200);
  const Problem problem(size, Holed(size));
  std::vector<float> one(problem.b.size()), two(problem.b.size());
  SetThreadCount(1);
  SolveLaplacian(problem.a, problem.image, problem.b, one);
  SetThreadCount(2);
  SolveLaplacian(problem.a, problem.image, problem.b, two);
  SetThreadCount(0);
  EXPECT_EQ(one, two);
}

// P of a cell is orthonormal, and holds its four functions: T^T G T = 1, phi = P R.
TEST(ColorMultigrid, BasisHoldsWhatItIsMadeFrom) {
  Eigen::Matrix<double, 16, 4> phi = Eigen::Matrix<double, 16, 4>::Random();
  phi.col(0).setOnes();
  phi.col(3) = 2 * phi.col(1) - 0.3 * phi.col(2) + 0.1 * phi.col(0);  // Depends on them
  const OrthonormalBasis basis(phi.transpose() * phi);
  const Eigen::Matrix<double, 16, 4> p = phi * basis.t;
  EXPECT_LT((p * basis.r - phi).norm(), 1e-6);
  const Eigen::Matrix4d gram = p.transpose() * p;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(gram(i, j), i == j && i < 3 ? 1.0 : 0.0, 1e-9);
    }
  }
}

TEST(ColorMultigrid, IsPositiveAndNearTheInverse) {
  const cv::Size size(120, 90);
  const Problem problem(size, Holed(size));
  ColorMultigrid multigrid(problem.a, problem.image);
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<float> x(problem.b.size()), r(x.size()), z(x.size());
  for (const PixelRun& run : problem.pixels.runs) {
    for (int i = 0; i < run.length; ++i) x[run.below[0] + i] = normal(random);
  }
  Multiply<float>(problem.a, x, r);
  multigrid.Apply(r, z);
  // In the norm of A: |x - M A x| < |x|
  std::vector<float> rest(x.size()), product(x.size());
  double before = 0, after = 0, positive = 0;
  for (std::size_t i = 0; i < x.size(); ++i) rest[i] = x[i] - z[i];
  Multiply<float>(problem.a, rest, product);
  for (std::size_t i = 0; i < x.size(); ++i) {
    before += static_cast<double>(x[i]) * r[i];
    after += static_cast<double>(rest[i]) * product[i];
    positive += static_cast<double>(z[i]) * r[i];
  }
  EXPECT_GT(positive, 0.0);
  EXPECT_LT(after, 0.25 * before);
}

TEST(LaplacianSolver, StopsWhenAsked) {
  const cv::Size size(200, 200);
  const Problem problem(size, Holed(size));
  std::vector<float> x(problem.b.size());
  int reports = 0;
  EXPECT_THROW(SolveLaplacian(problem.a,
                              problem.image,
                              problem.b,
                              x,
                              {},
                              [&](double) { return ++reports < 40; }),
               Cancelled);
  EXPECT_EQ(reports, 40);
}

}  // namespace
}  // namespace relight
