// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/correction.h"

#include "relight/base/data_folder.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

namespace relight {
namespace {

constexpr int kVersion = 1;
constexpr float kBound = 0.7f;
constexpr double kFade_rad = 10 * std::numbers::pi / 180;
constexpr int kMostMembers = 64, kMostLayers = 8, kMostUnits = 1024;

// Words of the file, each checked as it is read.
class WeightsReader {
 public:
  explicit WeightsReader(const std::filesystem::path& file) : file_(file), in_(file) {
    if (!in_) Fail("cannot be read");
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(file_.string() + ": " + what +
                     "; install relight again, make the weights with "
                     "relight/ratio/training, or give --no-correction");
  }
  std::string Word() {
    std::string word;
    if (!(in_ >> word)) Fail("ends too early");
    return word;
  }
  void Expect(const std::string& word) {
    const std::string found = Word();
    if (found != word) Fail("has \"" + found + "\" where \"" + word + "\" should be");
  }
  int Count(const char* what, int most) {
    int count = 0;
    if (!(in_ >> count) || count < 1 || count > most) {
      Fail(std::string("has no count of ") + what + " from 1 to " + std::to_string(most));
    }
    return count;
  }
  float Number() {
    float number = 0;
    if (!(in_ >> number) || !std::isfinite(number)) Fail("has a number that is none");
    return number;
  }
  void End() {
    std::string more;
    if (in_ >> more) Fail("goes on after its end, with \"" + more + "\"");
  }

 private:
  std::filesystem::path file_;
  std::ifstream in_;
};

float Answer(const std::vector<CorrectionModel::Layer>& member, Eigen::VectorXf values) {
  for (std::size_t i = 0; i < member.size(); ++i) {
    values = (member[i].weights * values + member[i].bias).eval();
    if (i + 1 < member.size()) values = values.array().tanh();
  }
  return values[0];
}

const cv::Mat1f& PlaneOf(const CorrectionFeatures& features, const std::string& name) {
  const std::vector<std::string>& names = CorrectionFeatureNames();
  const auto found = std::find(names.begin(), names.end(), name);
  Require(found != names.end(), "a feature has this name");
  return features.planes[static_cast<std::size_t>(found - names.begin())];
}

// n_0 of (R3): over the patches that hold some tree.
float MeanByBrightness(const CorrectionFeatures& features, const cv::Mat1f& answers) {
  constexpr float kSomeTree = 0.1f;
  const cv::Mat1f& photo = PlaneOf(features, "photo_fine");
  const cv::Mat1f& ratio = PlaneOf(features, "ratio_fine");
  double sum = 0, weight = 0;
  for (int row = 0; row < answers.rows; ++row) {
    for (int column = 0; column < answers.cols; ++column) {
      const float cover = features.cover(row, column);
      if (cover <= kSomeTree) continue;
      const double w = cover * std::exp(photo(row, column) + ratio(row, column));
      sum += w * answers(row, column);
      weight += w;
    }
  }
  return static_cast<float>(weight > 0 ? sum / weight : 0);
}

// l of (R5).
float LevelOf(const CorrectionModel& model, const CorrectionFeatures& features) {
  const auto number = [&](const char* name) { return PlaneOf(features, name)(0, 0); };
  const auto of_hour = [&](float up, float along) {
    const float level = std::sqrt(std::max(0.0f, 1 - up * up));
    return Eigen::Vector3f(level * along, up, level * along * along);
  };
  return model.level.dot(
      of_hour(number("elevation_target"), number("view_to_sun_target")) -
      of_hour(number("elevation_input"), number("view_to_sun_input")));
}

}  // namespace

CorrectionModel ReadCorrectionModel() {
  return ReadCorrectionModel(DataPath("correction/weights.txt"));
}

CorrectionModel ReadCorrectionModel(const std::filesystem::path& file) {
  WeightsReader in(file);
  in.Expect("relight-correction");
  if (const std::string version = in.Word(); version != std::to_string(kVersion)) {
    in.Fail("is of version " + version + ", this program reads " +
            std::to_string(kVersion));
  }
  const std::vector<std::string>& names = CorrectionFeatureNames();
  in.Expect("features");
  in.Expect(std::to_string(names.size()));
  const auto count = static_cast<Eigen::Index>(names.size());
  CorrectionModel model;
  for (Eigen::VectorXf* column : {&model.low, &model.high, &model.mean, &model.deviation})
    column->resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    in.Expect(names[static_cast<std::size_t>(i)]);
    model.low[i] = in.Number();
    model.high[i] = in.Number();
    model.mean[i] = in.Number();
    model.deviation[i] = in.Number();
    if (!(model.low[i] <= model.high[i]) || !(model.deviation[i] > 0)) {
      in.Fail("has no range of " + names[static_cast<std::size_t>(i)]);
    }
  }
  in.Expect("level");
  for (Eigen::Index i = 0; i < model.level.size(); ++i) model.level[i] = in.Number();
  in.Expect("members");
  model.members.resize(static_cast<std::size_t>(in.Count("members", kMostMembers)));
  for (std::vector<CorrectionModel::Layer>& member : model.members) {
    in.Expect("layers");
    member.resize(static_cast<std::size_t>(in.Count("layers", kMostLayers)));
    Eigen::Index inputs = count;
    for (std::size_t i = 0; i < member.size(); ++i) {
      in.Expect("units");
      const Eigen::Index outputs = in.Count("units", kMostUnits);
      if (i + 1 == member.size() && outputs != 1) in.Fail("has more than one answer");
      member[i].weights.resize(outputs, inputs);
      member[i].bias.resize(outputs);
      for (Eigen::Index o = 0; o < outputs; ++o) {
        for (Eigen::Index k = 0; k < inputs; ++k) member[i].weights(o, k) = in.Number();
        member[i].bias[o] = in.Number();
      }
      inputs = outputs;
    }
  }
  in.Expect("trees");  // That it was learned from, by name
  const int trees = in.Count("trees", 100000);
  for (int i = 0; i < trees; ++i) in.Word();
  in.End();
  return model;
}

Correction PredictCorrection(const CorrectionModel& model,
                             const CorrectionFeatures& features,
                             double sun_angle_rad) {
  Correction correction;
  correction.grid = features.grid;
  if (features.planes.empty()) return correction;
  Require(static_cast<std::size_t>(model.mean.size()) == features.planes.size(),
          "the weights belong to these features");
  const cv::Size size(features.grid.columns, features.grid.rows);
  correction.log_factor = cv::Mat1f::zeros(size);
  correction.trust = cv::Mat1f::zeros(size);
  correction.spread = cv::Mat1f::zeros(size);
  cv::Mat1f answers = cv::Mat1f::zeros(size);
  ParallelRanges(size.height, 2, [&](int begin, int end) {
    Eigen::VectorXf values(model.mean.size());
    for (int row = begin; row < end; ++row) {
      for (int column = 0; column < size.width; ++column) {
        float beyond = 0;
        for (Eigen::Index i = 0; i < values.size(); ++i) {
          const float value = features.planes[static_cast<std::size_t>(i)](row, column);
          const float known = std::clamp(value, model.low[i], model.high[i]);
          const float width = std::max(1e-6f, model.high[i] - model.low[i]);
          beyond += (value - known) * (value - known) / (width * width);
          values[i] = (known - model.mean[i]) / model.deviation[i];
        }
        float sum = 0, squares = 0;
        for (const auto& member : model.members) {
          const float answer = Answer(member, values);
          sum += answer;
          squares += answer * answer;
        }
        const auto members = static_cast<float>(model.members.size());
        const float mean = sum / members;
        answers(row, column) = mean;
        correction.trust(row, column) = std::exp(-4 * beyond);
        correction.spread(row, column) =
            std::sqrt(std::max(0.0f, squares / members - mean * mean));
      }
    }
  });

  const double covered = cv::sum(features.cover)[0];
  if (covered > 0) correction.mean_trust = correction.trust.dot(features.cover) / covered;

  const float middle = MeanByBrightness(features, answers);
  const float level = LevelOf(model, features);
  const float fade = HourFade(sun_angle_rad);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const float c =
          kBound * std::tanh((answers(row, column) - middle) / kBound) * fade + level;
      correction.log_factor(row, column) =
          correction.trust(row, column) * std::clamp(c, -kBound, kBound);
    }
  }
  return correction;
}

float HourFade(double sun_angle_rad) {
  const double turn = sun_angle_rad / kFade_rad;
  return static_cast<float>(-std::expm1(-turn * turn));
}

cv::Mat1f PatchRows(const PatchGrid& grid,
                    const cv::Mat1f& image,
                    int width,
                    int row_begin,
                    int row_end) {
  cv::Mat1f result(row_end - row_begin, width);
  for (int row = row_begin; row < row_end; ++row) {
    const double y =
        std::clamp((row + 0.5 - grid.top_px) / grid.patch_px - 0.5, 0.0, grid.rows - 1.0);
    const int top = std::min(static_cast<int>(y), std::max(0, grid.rows - 2));
    const int below = std::min(top + 1, grid.rows - 1);
    const auto down = static_cast<float>(y - top);
    for (int column = 0; column < width; ++column) {
      const double x = std::clamp(
          (column + 0.5 - grid.left_px) / grid.patch_px - 0.5, 0.0, grid.columns - 1.0);
      const int left = std::min(static_cast<int>(x), std::max(0, grid.columns - 2));
      const int right = std::min(left + 1, grid.columns - 1);
      const auto across = static_cast<float>(x - left);
      const float above_value =
          image(top, left) + across * (image(top, right) - image(top, left));
      const float below_value =
          image(below, left) + across * (image(below, right) - image(below, left));
      result(row - row_begin, column) = above_value + down * (below_value - above_value);
    }
  }
  return result;
}

}  // namespace relight
