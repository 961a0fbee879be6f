// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/run_colmap.h"

#include "relight/base/child_process.h"
#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/cameras/colmap_model.h"
#include "relight/cameras/view_name.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <iomanip>
#include <set>
#include <sstream>
#include <system_error>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostExhaustive = 40;
constexpr int kOverlap = 10;
constexpr const char* kHelps =
    "photos one step apart (6 to 10 degrees around the tree), sharp, with ground and "
    "surroundings in the frame, all within some minutes";

std::size_t CountOf(const ColmapJob& job) {
  std::size_t count = 0;
  for (const ColmapGroup& group : job.groups) count += group.files.size();
  return count;
}

std::size_t PairsOf(std::size_t photos, bool exhaustive) {
  // Overlaps grow by powers of two, too: some ten more
  return exhaustive ? photos * (photos - 1) / 2 : photos * 2 * kOverlap;
}

// One step of COLMAP. `done` finds in a line how far it is, in [0, 1]; -1: not said.
void Step(const fs::path& program,
          const std::vector<std::string>& words,
          const std::function<double(const std::string&)>& done,
          const Progress& progress) {
  ChildProcess process(program, words, ChildProcess::Output::kLines);
  std::deque<std::string> last;
  double reached = 0;
  while (const auto line = process.NextLine(std::chrono::milliseconds(100))) {
    if (!line->empty()) {
      reached = std::max(reached, done(*line));
      last.push_back(*line);
      if (last.size() > 12) last.pop_front();
    }
    progress.Report(std::min(reached, 1.0));
  }
  if (process.Finish(nullptr)) return;
  std::string said;
  for (const std::string& line : last) said += "\n  " + line;
  throw InputError("COLMAP stopped at its step " + words.front() +
                   "; what helps: " + kHelps + ". It said last:" + said);
}

// "Processed file [3/18]".
double Fraction(const std::string& line, const char* before) {
  const std::size_t at = line.find(before);
  int n = 0, of = 0;
  if (at == std::string::npos ||
      std::sscanf(line.c_str() + at + std::string(before).size(), "%d/%d", &n, &of) !=
          2 ||
      of <= 0) {
    return -1;
  }
  return static_cast<double>(n) / of;
}

// "Matching block [2/4, 1/4] in 3 s".
double BlockFraction(const std::string& line) {
  int n = 0, of = 0, m = 0, of_too = 0;
  const std::size_t at = line.find("Matching block [");
  if (at == std::string::npos ||
      std::sscanf(
          line.c_str() + at, "Matching block [%d/%d, %d/%d]", &n, &of, &m, &of_too) !=
          4 ||
      of <= 0 || of_too <= 0) {
    return -1;
  }
  return ((n - 1) + static_cast<double>(m) / of_too) / of;
}

// "Registering image #5 (12)", later "Registering image #5 (num_reg_frames=12)": the
// twelfth.
double Registered(const std::string& line, std::size_t photos) {
  int image = 0, count = 0;
  const std::size_t at = line.find("Registering image #");
  if (at == std::string::npos) return -1;
  const char* found = line.c_str() + at;
  if (std::sscanf(found, "Registering image #%d (%d)", &image, &count) != 2 &&
      std::sscanf(found, "Registering image #%d (num_reg_frames=%d)", &image, &count) !=
          2) {
    return -1;
  }
  return static_cast<double>(count) / static_cast<double>(photos);
}

// The options of one step as this version calls them: newer ones moved some to other
// groups, which their help tells.
class StepOptions {
 public:
  StepOptions(const fs::path& program, const char* step) {
    ChildProcess process(program, {step, "--help"}, ChildProcess::Output::kLines);
    while (const auto line = process.NextLine(std::chrono::milliseconds(1000))) {
      help_ += *line + "\n";
    }
    process.Finish(nullptr);
  }
  // "--Group.name" of the later group if the help knows it, else of the older.
  std::string Named(const char* name, const char* older, const char* later) const {
    const std::string moved = std::string("--") + later + "." + name;
    if (help_.find(moved + " ") != std::string::npos) return moved;
    return std::string("--") + older + "." + name;
  }

 private:
  std::string help_;
};

std::string Number(double value) {
  std::ostringstream text;
  text << std::setprecision(10) << value;
  return text.str();
}

void Extract(const fs::path& program,
             const ColmapJob& job,
             const ColmapOptions& options,
             const Progress& progress) {
  const StepOptions known(program, "feature_extractor");
  const auto named = [&](const char* name) {
    return known.Named(name, "SiftExtraction", "FeatureExtraction");
  };
  const auto all = static_cast<double>(CountOf(job));
  double before = 0;
  for (std::size_t g = 0; g < job.groups.size(); ++g) {
    const ColmapGroup& group = job.groups[g];
    const fs::path list = job.work / ("photos_" + std::to_string(g) + ".txt");
    std::string names;
    for (const std::string& file : group.files) names += file + "\n";
    WriteTextWhole(list, names);
    std::vector<std::string> words = {"feature_extractor",
                                      "--database_path",
                                      (job.work / "database.db").string(),
                                      "--image_path",
                                      job.photos.string(),
                                      "--image_list_path",
                                      list.string(),
                                      "--ImageReader.camera_model",
                                      "SIMPLE_RADIAL",
                                      "--ImageReader.single_camera",
                                      "1",
                                      named("use_gpu"),
                                      "0",
                                      named("max_image_size"),
                                      std::to_string(options.longest_px),
                                      "--SiftExtraction.max_num_features",
                                      std::to_string(options.features)};
    if (group.focal_px) {
      words.emplace_back("--ImageReader.camera_params");
      words.push_back(Number(*group.focal_px) + "," + Number(group.size.width_px / 2.0) +
                      "," + Number(group.size.height_px / 2.0) + ",0");
    }
    if (job.masks) {
      words.emplace_back("--ImageReader.mask_path");
      words.push_back(job.masks->string());
    }
    const double after = before + static_cast<double>(group.files.size()) / all;
    Step(
        program,
        words,
        [](const std::string& line) { return Fraction(line, "Processed file ["); },
        progress.Part(before, after));
    before = after;
  }
}

void Match(const fs::path& program,
           const ColmapJob& job,
           bool exhaustive,
           const Progress& progress) {
  const char* step = exhaustive ? "exhaustive_matcher" : "sequential_matcher";
  const StepOptions known(program, step);
  std::vector<std::string> words = {
      step,
      "--database_path",
      (job.work / "database.db").string(),
      known.Named("use_gpu", "SiftMatching", "FeatureMatching"),
      "0"};
  if (exhaustive) {
    // Small blocks, for progress is said by block
    words.insert(words.end(), {"--ExhaustiveMatching.block_size", "6"});
  } else {
    words.insert(words.end(), {"--SequentialMatching.overlap", std::to_string(kOverlap)});
  }
  Step(
      program,
      words,
      [&](const std::string& line) {
        return exhaustive ? BlockFraction(line) : Fraction(line, "Matching image [");
      },
      progress);
}

// The models that the mapper made, the largest first.
std::vector<CalibratedScene> Map(const fs::path& program,
                                 const ColmapJob& job,
                                 bool fixed_focal,
                                 const Progress& progress) {
  const fs::path models = job.work / (fixed_focal ? "fixed" : "free");
  fs::create_directories(models);
  std::vector<std::string> words = {"mapper",
                                    "--database_path",
                                    (job.work / "database.db").string(),
                                    "--image_path",
                                    job.photos.string(),
                                    "--output_path",
                                    models.string()};
  if (fixed_focal) {
    words.insert(words.end(), {"--Mapper.ba_refine_focal_length", "0"});
  }
  const std::size_t photos = CountOf(job);
  Step(
      program,
      words,
      [&](const std::string& line) { return Registered(line, photos); },
      progress);
  std::vector<CalibratedScene> scenes;
  for (int n = 0; fs::is_directory(models / std::to_string(n)); ++n) {
    scenes.push_back(ReadColmap(models / std::to_string(n)));
  }
  std::stable_sort(scenes.begin(), scenes.end(), [](const auto& a, const auto& b) {
    return a.cameras.size() > b.cameras.size();
  });
  return scenes;
}

// Focal length of the model over EXIF's, of the group where they are farthest apart.
double FocalRatio(const CalibratedScene& scene, const ColmapJob& job) {
  double worst = 1;
  for (const ColmapGroup& group : job.groups) {
    if (!group.focal_px) continue;
    const auto in_group = [&](const NamedCamera& named) {
      return std::any_of(
          group.files.begin(), group.files.end(), [&](const std::string& file) {
            return ViewNameOf(file) == named.view;
          });
    };
    const auto found = std::find_if(scene.cameras.begin(), scene.cameras.end(), in_group);
    if (found == scene.cameras.end()) continue;
    const double ratio = found->camera.focal_px.x() / *group.focal_px;
    if (std::abs(std::log(ratio)) > std::abs(std::log(worst))) worst = ratio;
  }
  return worst;
}

}  // namespace

std::optional<fs::path> FindColmap() { return FindProgram("colmap"); }

bool IsExhaustive(const ColmapOptions& options, std::size_t photos) {
  return options.matching == Matching::kExhaustive ||
         (options.matching == Matching::kAuto && photos <= kMostExhaustive);
}

double ColmapSeconds(const ColmapJob& job, const ColmapOptions& options) {
  constexpr double kSecondsPerMegapixel = 1.0, kSecondsPerPair = 0.35,
                   kSecondsPerPhoto = 2.0;
  double seconds = 0;
  for (const ColmapGroup& group : job.groups) {
    const double shrink =
        std::min(1.0,
                 static_cast<double>(options.longest_px) /
                     std::max({group.size.width_px, group.size.height_px, 1}));
    seconds += static_cast<double>(group.files.size()) * kSecondsPerMegapixel * 1e-6 *
               group.size.width_px * group.size.height_px * shrink * shrink;
  }
  const std::size_t photos = CountOf(job);
  const double by_features = std::pow(options.features / 4000.0, 1.5);
  return seconds +
         kSecondsPerPair * by_features *
             static_cast<double>(PairsOf(photos, IsExhaustive(options, photos))) +
         kSecondsPerPhoto * static_cast<double>(photos);
}

ColmapSummary RunColmap(const ColmapJob& job,
                        const ColmapOptions& options,
                        const Progress& progress) {
  CheckFields(options);
  const auto program = FindColmap();
  if (!program) {
    throw InputError(
        "COLMAP is not installed, which finds the cameras of photos; install it with: "
        "sudo apt install colmap, or import what another program made with --import");
  }
  std::error_code error;
  fs::remove_all(job.work, error);
  fs::create_directories(job.work, error);
  if (error) {
    throw InputError(job.work.string() + ": cannot be made: " + error.message() +
                     "; free some space");
  }
  const std::size_t photos = CountOf(job);
  ColmapSummary summary;
  summary.exhaustive = IsExhaustive(options, photos);
  Extract(*program, job, options, progress.Part(0, 0.25));
  Match(*program, job, summary.exhaustive, progress.Part(0.25, 0.7));
  std::vector<CalibratedScene> models =
      Map(*program, job, /*fixed_focal=*/false, progress.Part(0.7, 0.85));
  if (models.empty()) {
    throw InputError(
        job.photos.string() +
        ": COLMAP found no two photos that fit together; what helps: " + kHelps);
  }
  constexpr double kFarOff = 1.1;
  const double ratio = FocalRatio(models.front(), job);
  if (ratio > kFarOff || ratio < 1 / kFarOff) {
    std::vector<CalibratedScene> fixed =
        Map(*program, job, /*fixed_focal=*/true, progress.Part(0.85, 1));
    if (!fixed.empty() && fixed.front().cameras.size() >= models.front().cameras.size()) {
      models = std::move(fixed);
      std::ostringstream note;
      note << std::setprecision(3) << "a free focal length came out at " << ratio
           << " times EXIF's, as it does when what is seen is flat; EXIF's is taken";
      summary.notes.push_back(note.str());
    }
  }
  summary.models = static_cast<int>(models.size());
  summary.scene = std::move(models.front());
  std::set<std::string> found;
  for (const NamedCamera& named : summary.scene.cameras) found.insert(named.view);
  for (const ColmapGroup& group : job.groups) {
    for (const std::string& file : group.files) {
      const std::string view = ViewNameOf(file);
      if (!found.contains(view)) summary.missing.push_back(view);
    }
  }
  std::sort(summary.missing.begin(), summary.missing.end());
  progress.Report(1);
  return summary;
}

}  // namespace relight
