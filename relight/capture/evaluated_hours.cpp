// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/evaluated_hours.h"

#include "relight/base/error.h"
#include "relight/composite/frame_preview.h"
#include "relight/photo/image_file.h"
#include "relight/ratio/luminance_error.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <regex>

namespace relight {
namespace {

struct TimeInName {
  std::string date;  // May be empty.
  int minute = 0;    // Since midnight.
};

std::optional<TimeInName> TimeIn(const std::string& stem) {
  static const std::regex pattern(
      "(?:^|.*[^0-9A-Za-z])(?:(\\d{4}-\\d{2}-\\d{2})[_T ])?"
      "(\\d{2})[:h-]?(\\d{2})");
  static const std::regex ends_in_date("(?:^|.*[^0-9])\\d{4}-\\d{2}-\\d{2}");
  std::smatch match;
  if (std::regex_match(stem, ends_in_date)) return std::nullopt;
  if (!std::regex_match(stem, match, pattern)) return std::nullopt;
  const int hour = std::stoi(match[2]), minute = std::stoi(match[3]);
  if (hour > 23 || minute > 59) return std::nullopt;
  TimeInName time{.date = match[1], .minute = 60 * hour + minute};
  if (time.date.empty()) {  // The greedy start may have taken it
    static const std::regex date("(\\d{4}-\\d{2}-\\d{2})[_T ][^_T ]*$");
    if (std::regex_search(stem, match, date)) time.date = match[1];
  }
  return time;
}

bool IsPicture(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  constexpr std::array kKnown = {
      ".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".heic", ".dng", ".nef", ".cr2"};
  return std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

std::vector<std::filesystem::path> PicturesOf(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.is_regular_file() && IsPicture(entry.path())) files.push_back(entry.path());
  }
  if (error) throw InputError(folder.string() + ": " + error.message());
  if (files.empty()) {
    throw InputError(folder.string() +
                     " holds no picture; give a folder of .exr, .png, "
                     ".tif or .jpg files, one an hour");
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string ClockText(int minute) {
  char text[16];
  std::snprintf(text, sizeof text, "%02d:%02d", minute / 60 % 24, minute % 60);
  return text;
}

HourPair PairOf(const std::filesystem::path& result, const std::filesystem::path& truth) {
  HourPair pair{.name = result.stem().string(), .result = result, .truth = truth};
  std::optional<TimeInName> time = TimeIn(pair.name);
  if (!time) time = TimeIn(truth.stem().string());
  if (time) {
    pair.hour = time->minute / 60.0;
    pair.name = (time->date.empty() ? "" : time->date + " ") + ClockText(time->minute);
  }
  return pair;
}

bool SameTime(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto at_a = TimeIn(a.stem().string()), at_b = TimeIn(b.stem().string());
  return at_a && at_b && at_a->minute == at_b->minute &&
         (at_a->date.empty() || at_b->date.empty() || at_a->date == at_b->date);
}

// The mean of one figure; none when an hour lacks it.
template <class Get>
std::optional<double> MeanOf(const std::vector<RelightingFigures>& rows, const Get& get) {
  double sum = 0.0;
  for (const RelightingFigures& row : rows) {
    const std::optional<double> value = get(row);
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / double(rows.size());
}

RelightingFigures MeanFigures(const std::vector<RelightingFigures>& rows) {
  const auto mean = [&](double RelightingFigures::*field) {
    return *MeanOf(rows, [&](const RelightingFigures& f) {
      return std::optional<double>(f.*field);
    });
  };
  RelightingFigures out{.psnr_low = mean(&RelightingFigures::psnr_low),
                        .corr_low = mean(&RelightingFigures::corr_low),
                        .contrast = mean(&RelightingFigures::contrast),
                        .corr_high = mean(&RelightingFigures::corr_high),
                        .level = mean(&RelightingFigures::level),
                        .colour = mean(&RelightingFigures::colour),
                        .ring = MeanOf(rows, [](const auto& f) { return f.ring; }),
                        .psnr = mean(&RelightingFigures::psnr),
                        .ssim = mean(&RelightingFigures::ssim)};
  for (std::size_t c = 0; c < 3; ++c) {
    out.gain[c] =
        *MeanOf(rows, [&](const auto& f) { return std::optional<double>(f.gain[c]); });
  }
  return out;
}

// Under an exposure, with what is not the tree left transparent where alpha says so.
cv::Mat3b SmallPicture(const ScoredPicture& picture,
                       double gain,
                       const cv::Mat1f& alpha) {
  Photo photo;
  photo.pixels = picture.color * gain;
  photo.alpha = picture.alpha.empty() ? alpha : picture.alpha;
  return PreviewOf(photo, 640);
}

}  // namespace

HourPairs MatchHours(const std::filesystem::path& results,
                     const std::filesystem::path& truths) {
  const std::vector<std::filesystem::path> ours = PicturesOf(results);
  const std::vector<std::filesystem::path> theirs = PicturesOf(truths);
  HourPairs matched;
  std::map<std::filesystem::path, std::filesystem::path> taken;  // Truth to result.
  for (const auto& result : ours) {
    std::vector<std::filesystem::path> named, timed;
    for (const auto& truth : theirs) {
      if (truth.stem() == result.stem()) named.push_back(truth);
      if (SameTime(result, truth)) timed.push_back(truth);
    }
    const auto& fits = named.empty() ? timed : named;
    if (fits.empty()) {
      matched.notes.push_back(result.filename().string() + " has no true picture in " +
                              truths.string());
      continue;
    }
    if (fits.size() > 1) {
      throw InputError(result.string() + " fits " + fits[0].filename().string() +
                       " and " + fits[1].filename().string() + " of " + truths.string() +
                       "; keep one view and one format in each folder, or name the files "
                       "alike");
    }
    if (const auto [other, is_new] = taken.emplace(fits[0], result); !is_new) {
      throw InputError(fits[0].string() + " fits " + other->second.filename().string() +
                       " and " + result.filename().string() + " of " + results.string() +
                       "; keep one view and one day in each folder, or name the files "
                       "alike");
    }
    matched.pairs.push_back(PairOf(result, fits[0]));
  }
  if (matched.pairs.empty()) {
    throw InputError("no picture of " + results.string() + " (" +
                     ours[0].filename().string() + ", …) belongs to one of " +
                     truths.string() + " (" + theirs[0].filename().string() +
                     ", …); name both alike, or end their names in the time, _1730");
  }
  for (const auto& truth : theirs) {
    if (!taken.contains(truth)) {
      matched.notes.push_back(truth.filename().string() + " has no result in " +
                              results.string());
    }
  }
  std::stable_sort(matched.pairs.begin(),
                   matched.pairs.end(),
                   [](const auto& a, const auto& b) { return a.name < b.name; });
  return matched;
}

RelightingPictures ReadRelightingPictures(const std::filesystem::path& result,
                                          const std::filesystem::path& truth,
                                          const EvaluateOptions& options) {
  const auto read = [](const std::filesystem::path& file, const ReadPhotoOptions& how) {
    const Photo photo = ReadPhoto(file, how);
    return ScoredPicture{photo.pixels, photo.alpha};
  };
  RelightingPictures pictures{.result = read(result, {}),
                              .truth = read(truth, options.photo)};
  if (options.input) pictures.source = read(*options.input, options.photo);
  if (options.alpha) pictures.matte = ReadMatte(*options.alpha);
  return pictures;
}

EvaluatedHour EvaluateHour(const HourPair& pair, const EvaluateOptions& options) {
  const RelightingPictures pictures =
      ReadRelightingPictures(pair.result, pair.truth, options);
  EvaluatedHour hour{.pair = pair, .score = {}, .result = {}, .truth = {}, .error = {}};
  try {
    hour.score = ScoreRelighting(pictures, options.score);
  } catch (const InputError& error) {
    throw InputError(pair.result.string() + " against " + pair.truth.string() + ": " +
                     error.what());
  }
  const double gain = 0.8 / hour.score.peak;
  const cv::Mat1f& alpha = pictures.matte.empty() ? pictures.truth.alpha : pictures.matte;
  hour.result = SmallPicture(pictures.result, gain / options.score.scale, alpha);
  hour.truth = SmallPicture(pictures.truth, gain, alpha);
  const cv::Mat3b error = LuminanceErrorPicture(
      LuminanceError(pictures, hour.score, options.score), ScoredInside(pictures));
  hour.error = Smaller(error, {640, 640});
  return hour;
}

RelightingScore MeanScore(const std::vector<EvaluatedHour>& hours) {
  Require(!hours.empty(), "an hour to take the mean of");
  std::map<std::string, std::vector<RelightingFigures>> rows;
  RelightingScore mean{.result = {}};
  for (const EvaluatedHour& hour : hours) {
    for (const auto& [name, figures] : RowsOf(hour.score)) rows[name].push_back(figures);
    mean.pixels += hour.score.pixels;
    mean.peak += hour.score.peak / double(hours.size());
  }
  mean.result = MeanFigures(rows.at("result"));
  const auto row = [&](const char* name) -> std::optional<RelightingFigures> {
    const auto found = rows.find(name);
    if (found == rows.end() || found->second.size() != hours.size()) return std::nullopt;
    return MeanFigures(found->second);
  };
  mean.nothing = row("nothing");
  mean.histogram = row("histogram");
  mean.reinhard = row("reinhard");
  mean.monge_kantorovich = row("monge_kantorovich");
  return mean;
}

std::vector<std::string> FigureNames() {
  return {"psnr_low",
          "corr_low",
          "contrast",
          "corr_high",
          "level",
          "colour",
          "ring",
          "psnr",
          "ssim"};
}

std::optional<double> FigureOf(const RelightingFigures& f, const std::string& name) {
  if (name == "psnr_low") return f.psnr_low;
  if (name == "corr_low") return f.corr_low;
  if (name == "contrast") return f.contrast;
  if (name == "corr_high") return f.corr_high;
  if (name == "level") return f.level;
  if (name == "colour") return f.colour;
  if (name == "ring") return f.ring;
  if (name == "psnr") return f.psnr;
  Require(name == "ssim", "a figure of FigureNames()");
  return f.ssim;
}

std::vector<std::pair<std::string, RelightingFigures>> RowsOf(
    const RelightingScore& score) {
  std::vector<std::pair<std::string, RelightingFigures>> rows = {
      {"result", score.result}};
  if (score.nothing) rows.emplace_back("nothing", *score.nothing);
  if (score.histogram) rows.emplace_back("histogram", *score.histogram);
  if (score.reinhard) rows.emplace_back("reinhard", *score.reinhard);
  if (score.monge_kantorovich)
    rows.emplace_back("monge_kantorovich", *score.monge_kantorovich);
  return rows;
}

}  // namespace relight
