// SPDX-License-Identifier: Apache-2.0

// benchmark_matting [SECTION …]: how right, how fast and how large the matting is, on
// photographs with true alphas and on rendered trees (shared data/matting, data/maple,
// data/birch; $RELIGHT_SHARED says where). Sections, all but the last by default:
//
//   photographs  each of the 13: the closed form beside a sparse direct solver, beside
//                conjugate gradients with Eigen's incomplete Cholesky, and beside
//                PyMatting's figures; the colour prior
//   growth       two photographs enlarged to 1, 4 and 24 megapixels, with noise
//   of 1.5/255
//                and without: time, memory, the longest wait for a cancel
//   trees        mattes and foreground colours of the rendered trees
//   large        24 and 45 megapixels, 10 and 40 % unknown (needs some 6 GB)
//
// Seconds are of the processor, so that other work on the machine counts less.

#include "matting/automatic_trimap.h"
#include "matting/closed_form_matting.h"
#include "matting/color_multigrid.h"
#include "matting/foreground_colors.h"
#include "matting/laplacian_solver.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/photo/color.h"
#include "relight/photo/image_file.h"
#include "relight/photo/read_photo.h"

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace relight {
namespace {
namespace fs = std::filesystem;

constexpr double kEnough = 1.0 / 255;

fs::path Shared(const fs::path& below) {
  const char* given = std::getenv("RELIGHT_SHARED");
  return (given ? fs::path(given) : fs::path(RELIGHT_SOURCE_DIR) / ".." / "shared") /
         below;
}

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Memory of this process [MB]: now, and at most since PeakFromHere.
double Memory(const std::string& what) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == what + ":" && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}
double PeakFromHere() {
  std::ofstream("/proc/self/clear_refs") << "5";
  return Memory("VmRSS");
}

struct Case {
  std::string name;
  cv::Mat3f image;  // Display values.
  cv::Mat1b trimap;
  double megapixels() const { return static_cast<double>(image.total()) / 1e6; }
  double unknown() const {
    return static_cast<double>(cv::countNonZero(trimap == kTrimapUnknown)) /
           static_cast<double>(image.total());
  }
};

Case ReadCase(const std::string& name) {
  const fs::path folder = Shared("data/matting");
  return {name,
          DisplayFromLinear(ReadPhoto(folder / "input" / (name + ".png")).pixels),
          TrimapFromGray(ReadMatte(folder / "trimap" / (name + ".png")))};
}

// The photograph enlarged, which makes the system nearly singular; noise undoes that.
Case Enlarged(const Case& original, double megapixels, bool noise) {
  const double factor = std::sqrt(megapixels / original.megapixels());
  Case large{original.name, {}, {}};
  cv::Mat image, trimap;
  cv::resize(original.image, image, {}, factor, factor, cv::INTER_CUBIC);
  cv::resize(original.trimap, trimap, image.size(), 0, 0, cv::INTER_NEAREST);
  large.image = image;
  large.trimap = trimap;
  if (noise) {
    cv::RNG random(1);
    cv::Mat grain(1, image.cols, CV_32FC3);
    for (int y = 0; y < image.rows; ++y) {
      random.fill(grain, cv::RNG::NORMAL, 0, 1.5 / 255);
      large.image.row(y) += grain;
    }
  }
  return large;
}

// What PyMatting's README table has of an image: MSE.
std::map<std::string, double> TheirErrors() {
  std::map<std::string, double> errors;
  std::ifstream readme(Shared("data/matting/README.md"));
  for (std::string line; std::getline(readme, line);) {
    std::vector<std::string> cells;
    std::string cell;
    for (const char c : line) {
      if (c == '|') cells.push_back(std::exchange(cell, {}));
      if (c != '|' && c != ' ') cell += c;
    }
    if (cells.size() == 9 && cells[1].rfind("GT", 0) == 0) {
      errors[cells[1]] = std::stod(cells[4]);
    }
  }
  return errors;
}

// --- The same system in double precision, for other solvers ------------------------

struct DoubleSystem {
  Eigen::SparseMatrix<double> a;
  Eigen::VectorXd b;
  std::vector<std::int32_t> slot_of;  // In our system, of each unknown.
};

// (M2) of a window, straight from its definition.
Eigen::Matrix<double, 9, 9> WindowLaplacian(const cv::Mat3f& image, int x, int y) {
  Eigen::Matrix<double, 9, 3> c;
  for (int n = 0; n < 9; ++n) {
    const cv::Vec3f& color = image(y + n / 3 - 1, x + n % 3 - 1);
    c.row(n) << color[0], color[1], color[2];
  }
  const Eigen::RowVector3d mean = c.colwise().mean();
  c.rowwise() -= mean;
  const double epsilon = MattingOptions().epsilon;
  const Eigen::Matrix3d covariance =
      c.transpose() * c / 9 + epsilon / 9 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 9, 9> l = -(c * covariance.inverse() * c.transpose()).eval();
  l.array() -= 1;
  l /= 9;
  l.diagonal().array() += 1;
  return l;
}

DoubleSystem InDouble(const Case& of, const MattingSystem& system) {
  DoubleSystem wide;
  cv::Mat1i number(of.image.size(), -1);
  for (const PixelRun& run : system.pixels->runs) {
    for (int i = 0; i < run.length; ++i) {
      number(run.y, run.x + i) = static_cast<int>(wide.slot_of.size());
      wide.slot_of.push_back(run.below[0] + i);
    }
  }
  const auto count = static_cast<Eigen::Index>(wide.slot_of.size());
  std::vector<std::array<double, 25>> row(wide.slot_of.size());
  for (auto& entries : row) entries.fill(0);
  for (int y = 1; y + 1 < of.image.rows; ++y) {
    for (int x = 1; x + 1 < of.image.cols; ++x) {
      std::array<int, 9> at{};
      for (int n = 0; n < 9; ++n) at[n] = number(y + n / 3 - 1, x + n % 3 - 1);
      if (*std::max_element(at.begin(), at.end()) < 0) continue;
      const auto l = WindowLaplacian(of.image, x, y);
      for (int i = 0; i < 9; ++i) {
        for (int j = 0; j < 9; ++j) {
          if (at[i] < 0 || at[j] < 0) continue;
          row[at[i]][(j / 3 - i / 3 + 2) * 5 + j % 3 - i % 3 + 2] += l(i, j);
        }
      }
    }
  }
  wide.a.resize(count, count);
  wide.a.reserve(Eigen::VectorXi::Constant(count, 25));
  wide.b = Eigen::VectorXd::Zero(count);
  const double lambda = MattingOptions().lambda;
  for (int y = 0; y < number.rows; ++y) {
    for (int x = 0; x < number.cols; ++x) {
      const int i = number(y, x);
      if (i < 0) continue;
      if (of.trimap(y, x) != kTrimapUnknown) {
        row[i][12] += lambda;
        wide.b[i] = of.trimap(y, x) == kTrimapForeground ? lambda : 0.0;
      }
      for (int k = 0; k < 25; ++k) {
        const cv::Point other(x + k % 5 - 2, y + k / 5 - 2);
        if (!cv::Rect({0, 0}, number.size()).contains(other)) continue;
        if (number(other) >= 0) wide.a.insert(number(other), i) = row[i][k];
      }
    }
  }
  wide.a.makeCompressed();
  return wide;
}

// The solution at relative residual 1e-10, in double precision, on the matrix above; our
// multigrid only preconditions.
Eigen::VectorXd Exact(const Case& of,
                      const MattingSystem& system,
                      const DoubleSystem& wide) {
  ColorMultigrid multigrid(system.matrix, of.image);
  std::vector<float> r_slots(system.right_side.size()), z_slots(r_slots.size());
  const auto precondition = [&](const Eigen::VectorXd& r) {
    const double scale = r.norm();
    for (std::size_t i = 0; i < wide.slot_of.size(); ++i) {
      r_slots[wide.slot_of[i]] =
          static_cast<float>(r[static_cast<Eigen::Index>(i)] / scale);
    }
    multigrid.Apply(r_slots, z_slots);
    Eigen::VectorXd z(r.size());
    for (std::size_t i = 0; i < wide.slot_of.size(); ++i) {
      z[static_cast<Eigen::Index>(i)] = scale * z_slots[wide.slot_of[i]];
    }
    return z;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(wide.b.size()), r = wide.b, p, ap;
  double before = 0, step = 0;
  while (r.norm() > 1e-10 * wide.b.norm()) {
    const Eigen::VectorXd z = precondition(r);
    const double rz = r.dot(z);
    p = before == 0 ? z : Eigen::VectorXd(z - step * z.dot(ap) / before * p);
    before = rz;
    ap = wide.a * p;
    step = r.dot(p) / p.dot(ap);
    x += step * p;
    r -= step * ap;
  }
  return x;
}

struct Timed {
  double seconds = 0;
  int iterations = 0;
  bool reached = false;  // kEnough; false: given up.
};

// Conjugate gradients with Eigen's incomplete Cholesky, until kEnough of `exact` or
// `most_s`. What comparing costs is not counted.
Timed WithEigen(const DoubleSystem& wide, const Eigen::VectorXd& exact, double most_s) {
  Timed timed;
  double begin = CpuSeconds();
  const Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::AMDOrdering<int>> ichol(
      wide.a);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(wide.b.size()), r = wide.b,
                  z = ichol.solve(r), p = z, ap(r.size());
  double rz = r.dot(z);
  while (timed.seconds < most_s) {
    ap.noalias() = wide.a * p;
    const double step = rz / p.dot(ap);
    x += step * p;
    r -= step * ap;
    z = ichol.solve(r);
    const double next = r.dot(z);
    p = z + next / rz * p;
    rz = next;
    ++timed.iterations;
    timed.seconds += CpuSeconds() - begin;
    timed.reached = (x - exact).cwiseAbs().maxCoeff() <= kEnough;
    if (timed.reached) return timed;
    begin = CpuSeconds();
  }
  return timed;
}

double Distance(std::span<const float> x,
                const DoubleSystem& wide,
                const Eigen::VectorXd& exact) {
  double most = 0;
  for (std::size_t i = 0; i < wide.slot_of.size(); ++i) {
    most = std::max(most,
                    std::abs(x[wide.slot_of[i]] - exact[static_cast<Eigen::Index>(i)]));
  }
  return most;
}

Timed WithOurs(const Case& of,
               const MattingSystem& system,
               const DoubleSystem& wide,
               const Eigen::VectorXd& exact) {
  Timed timed;
  std::vector<float> x(system.right_side.size());
  double comparing = 0;
  SolveOptions options{.relative_residual = 1e-12};
  options.enough = [&](std::span<const float> now) {
    const double begin = CpuSeconds();
    timed.reached = Distance(now, wide, exact) <= kEnough;
    comparing += CpuSeconds() - begin;
    return timed.reached;
  };
  const double begin = CpuSeconds();
  timed.iterations =
      SolveLaplacian(system.matrix, of.image, system.right_side, x, options).iterations;
  timed.seconds = CpuSeconds() - begin - comparing;
  return timed;
}

// --- Sections ------------------------------------------------------------------------

double MeanSquaredError(const cv::Mat1f& alpha,
                        const cv::Mat1f& truth,
                        const cv::Mat1b& trimap) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      if (trimap(y, x) != kTrimapUnknown) continue;
      sum += std::pow(alpha(y, x) - truth(y, x), 2);
      ++count;
    }
  }
  return sum / std::max(count, 1);
}

void Photographs() {
  const auto theirs = TheirErrors();
  if (theirs.empty()) throw InputError(Shared("data/matting").string() + ": not there");
  fmt::print(
      "\nPhotographs with true alphas; closed form on display values\n\n"
      "| image | MP | unknown | largest difference to a direct solver, 1/255 | MSE |"
      " to PyMatting's | iterations to 1/255 | CPU s | Eigen's | CPU s | ratio |"
      " default's MSE |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  double ours_sum = 0, theirs_sum = 0, default_sum = 0, ratio_sum = 0, worst = 0,
         worst_error = 0;
  for (const auto& [name, their_error] : theirs) {
    const Case photo = ReadCase(name);
    const cv::Mat1f truth = ReadMatte(Shared("data/matting/gt/" + name + ".png"));
    const MattingSystem system = MakeMattingSystem(photo.image, photo.trimap);
    const DoubleSystem wide = InDouble(photo, system);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> direct(wide.a);
    const Eigen::VectorXd exact = direct.solve(wide.b);
    const cv::Mat1f alpha =
        EstimateMatte(photo.image, photo.trimap, {.prior_weight = 0}).alpha;
    std::vector<float> x(system.right_side.size());
    SolveLaplacian(system.matrix, photo.image, system.right_side, x);
    const double difference = Distance(x, wide, exact);
    const double error = MeanSquaredError(alpha, truth, photo.trimap);
    const Timed ours = WithOurs(photo, system, wide, exact);
    const Timed eigen = WithEigen(wide, exact, 1e9);
    const double prior_error = MeanSquaredError(
        EstimateMatte(LinearFromDisplay(photo.image), photo.trimap).alpha,
        truth,
        photo.trimap);
    fmt::print(
        "| {} | {:.2f} | {:.0f} % | {:.2f} | {:.5f} | {:.3f} | {} | {:.2f} | {} |"
        " {:.2f} | {:.1f} | {:.5f} |\n",
        name,
        photo.megapixels(),
        100 * photo.unknown(),
        255 * difference,
        error,
        error / their_error,
        ours.iterations,
        ours.seconds,
        eigen.iterations,
        eigen.seconds,
        eigen.seconds / ours.seconds,
        prior_error);
    std::cout.flush();
    ours_sum += error / 13;
    theirs_sum += their_error / 13;
    default_sum += prior_error / 13;
    ratio_sum += eigen.seconds / ours.seconds / 13;
    worst = std::max(worst, difference);
    worst_error = std::max(worst_error, error / their_error);
  }
  fmt::print(
      "\nmean MSE {:.5f} (PyMatting {:.5f}), default {:.5f}, {:.0f} % below; "
      "{:.2f}/255 at most from the direct solver; {:.3f} of PyMatting's MSE at "
      "most; Eigen's takes {:.1f} times our time on average\n",
      ours_sum,
      theirs_sum,
      default_sum,
      100 * (1 - default_sum / theirs_sum),
      255 * worst,
      worst_error,
      ratio_sum);
}

// Time, memory and the longest wait for a cancel, of a whole matte.
void PrintWhole(const Case& photo, bool noise) {
  for (const bool prior : {false, true}) {
    const double start_mb = PeakFromHere();
    const double begin = CpuSeconds();
    using Clock = std::chrono::steady_clock;
    auto last = Clock::now();
    double longest_s = 0;
    MattingOptions options;
    if (!prior) options.prior_weight = 0;
    const MatteSummary summary =
        EstimateMatte(photo.image, photo.trimap, options, [&](double) {
          const auto now = Clock::now();
          longest_s =
              std::max(longest_s, std::chrono::duration<double>(now - last).count());
          last = now;
          return true;
        }).summary;
    const double seconds = CpuSeconds() - begin;
    const double peak = Memory("VmHWM") - start_mb;
    fmt::print("| {} | {:.1f} | {:.0f} % | {} | {} | {} | {:.2f} | {:.0f} | {:.0f} |\n",
               photo.name,
               photo.megapixels(),
               100 * photo.unknown(),
               noise ? "yes" : "no",
               prior ? "default" : "closed form",
               summary.iterations,
               seconds / photo.megapixels(),
               peak / photo.megapixels(),
               1000 * longest_s);
    std::cout.flush();
  }
}

void PrintWholeHead() {
  fmt::print(
      "\n| image | MP | unknown | noise | method | iterations | CPU s/MP | MB/MP |"
      " longest wait for a cancel, ms |\n|---|---|---|---|---|---|---|---|---|\n");
}

void Growth() {
  PrintWholeHead();
  for (const char* name : {"GT01", "GT04"}) {
    const Case original = ReadCase(name);
    for (const double megapixels : {1.0, 4.0, 24.0}) {
      for (const bool noise : {true, false}) {
        PrintWhole(Enlarged(original, megapixels, noise), noise);
      }
    }
  }
  fmt::print(
      "\n4 MP, 40 % unknown, to the first iterate within 1/255, against conjugate "
      "gradients with Eigen's incomplete Cholesky (given up at 30 times our "
      "time)\n\n");
  for (const bool noise : {true, false}) {
    const Case photo = Enlarged(ReadCase("GT04"), 4, noise);
    const MattingSystem system = MakeMattingSystem(photo.image, photo.trimap);
    const DoubleSystem wide = InDouble(photo, system);
    const Eigen::VectorXd exact = Exact(photo, system, wide);
    const Timed ours = WithOurs(photo, system, wide, exact);
    const Timed eigen = WithEigen(wide, exact, 30 * ours.seconds);
    fmt::print(
        "noise {}: ours {:.1f} s ({} iterations), Eigen's {:.1f} s ({}{}): ratio "
        "{}{:.1f}\n",
        noise ? "yes" : "no",
        ours.seconds,
        ours.iterations,
        eigen.seconds,
        eigen.iterations,
        eigen.reached ? "" : ", not there yet",
        eigen.reached ? "" : "above ",
        eigen.seconds / ours.seconds);
    std::cout.flush();
  }
}

void Large() {
  PrintWholeHead();
  for (const char* name : {"GT01", "GT04"}) {
    for (const double megapixels : {24.0, 45.0}) {
      PrintWhole(Enlarged(ReadCase(name), megapixels, true), true);
    }
  }
}

cv::Rect BoundingBox(const cv::Mat1f& alpha) {
  return cv::boundingRect(cv::Mat1b(alpha > 0.02f));
}

double MeanAbsoluteError(const cv::Mat1f& alpha, const cv::Mat1f& truth) {
  const cv::Rect box = BoundingBox(truth);
  return cv::norm(alpha(box), truth(box), cv::NORM_L1) / static_cast<double>(box.area());
}

void Trees() {
  fmt::print(
      "\nRendered trees, mean absolute error over the bounding box of the true "
      "alpha above 0.02, mean of the photos (worst photo)\n\n"
      "| tree | input | trimap | automatic |\n|---|---|---|---|\n");
  for (const std::string tree : {"maple", "birch"}) {
    for (const std::string input : {"photos", "photos_camera", "linear"}) {
      const fs::path folder = Shared("data/" + tree);
      if (!fs::exists(folder / input)) continue;
      std::vector<double> given, automatic;
      for (const auto& entry : std::set<fs::directory_entry>(
               fs::directory_iterator(folder / input), fs::directory_iterator())) {
        const std::string name = entry.path().stem().string();
        const cv::Mat1f truth = ReadMatte(folder / "alpha" / (name + ".png"));
        ReadPhotoOptions reading;
        if (input == "photos_camera") reading.tone = Tone::kCamera;
        const cv::Mat3f linear = ReadPhoto(entry.path(), reading).pixels;
        const cv::Mat1b trimap =
            TrimapFromGray(ReadMatte(folder / "trimap" / (name + ".png")));
        given.push_back(MeanAbsoluteError(EstimateMatte(linear, trimap).alpha, truth));
        // As where relight finds the sky itself (relight/capture/photo_matte.cpp)
        const MattingOptions of_found{.prior_weight = 0.3, .brightest = 4};
        const cv::Mat1b found = EstimateTrimap(DisplayFromLinear(linear)).trimap;
        automatic.push_back(
            MeanAbsoluteError(EstimateMatte(linear, found, of_found).alpha, truth));
      }
      const auto text = [](const std::vector<double>& errors) {
        double sum = 0;
        for (const double error : errors) sum += error;
        return fmt::format("{:.4f} ({:.4f})",
                           sum / static_cast<double>(errors.size()),
                           *std::max_element(errors.begin(), errors.end()));
      };
      fmt::print("| {} | {} | {} | {} |\n", tree, input, text(given), text(automatic));
      std::cout.flush();
    }
  }

  fmt::print(
      "\nForeground colours under the true matte, error weighted by alpha, as a "
      "ratio to that of the photo in their place\n\n"
      "| tree | view | ratio | CPU s/MP | MB/MP |\n|---|---|---|---|---|\n");
  for (const std::string tree : {"maple", "birch"}) {
    const fs::path folder = Shared("data/" + tree);
    for (const auto& entry : std::set<fs::directory_entry>(
             fs::directory_iterator(folder / "foreground"), fs::directory_iterator())) {
      const std::string name = entry.path().stem().string();
      const cv::Mat1f alpha = ReadMatte(folder / "alpha" / (name + ".png"));
      const Photo truth = ReadPhoto(entry.path());
      const cv::Mat3f linear = ReadPhoto(folder / "linear" / (name + ".exr")).pixels;
      const double start_mb = PeakFromHere();
      const double begin = CpuSeconds();
      const cv::Mat3f ours = EstimateForeground(linear, alpha).foreground;
      const double seconds = CpuSeconds() - begin;
      const double peak = Memory("VmHWM") - start_mb;
      double our_error = 0, photo_error = 0;
      for (int y = 0; y < alpha.rows; ++y) {
        for (int x = 0; x < alpha.cols; ++x) {
          if (truth.alpha(y, x) <= 0.02f) continue;  // It has no colour of its own
          our_error += alpha(y, x) * cv::norm(ours(y, x) - truth.pixels(y, x));
          photo_error += alpha(y, x) * cv::norm(linear(y, x) - truth.pixels(y, x));
        }
      }
      const double megapixels = static_cast<double>(alpha.total()) / 1e6;
      fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.0f} |\n",
                 tree,
                 name,
                 our_error / photo_error,
                 seconds / megapixels,
                 peak / megapixels);
    }
  }
  fmt::print(
      "\nWhat mattes and colours do to relit pictures: tests/accuracy/run --input "
      "clean,automatic,own,raw\n");
}

int Run(const std::vector<std::string>& sections) {
  const std::map<std::string, void (*)()> known = {{"photographs", Photographs},
                                                   {"growth", Growth},
                                                   {"trees", Trees},
                                                   {"large", Large}};
  for (const std::string& section : sections) {
    if (!known.count(section)) {
      fmt::print(stderr,
                 "benchmark_matting: unknown section {}; there are photographs, growth, "
                 "trees, large\n",
                 section);
      return 2;
    }
  }
  for (const std::string& section : sections) known.at(section)();
  return 0;
}

}  // namespace
}  // namespace relight

int main(int count, char** words) {
  std::vector<std::string> sections(words + 1, words + count);
  if (sections.empty()) sections = {"photographs", "growth", "trees"};
  try {
    return relight::Run(sections);
  } catch (const std::exception& error) {
    fmt::print(stderr, "benchmark_matting: {}\n", error.what());
    return 1;
  }
}
