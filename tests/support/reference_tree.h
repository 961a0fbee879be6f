// SPDX-License-Identifier: Apache-2.0
#pragma once

// A rendered tree with known truth, and the paper's method on it by a program written
// apart from ours: reference/cabral2011 and data/TREE of the shared files.

#include "relight/base/instant.h"
#include "relight/cameras/colmap_model.h"
#include "relight/photo/image_file.h"
#include "relight/volume/extinction_grid.h"
#include "relight/volume/footprint_opacity.h"
#include "tests/support/shared_data.h"
#include "tests/support/synthetic_canopy.h"

#include <zlib.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace relight::tests {

inline nlohmann::json ReadJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": not there");
  return nlohmann::json::parse(in);
}

inline Eigen::Vector3d Vector3(const nlohmann::json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

// volume.json and volume.f32.gz of `folder`.
inline ExtinctionGrid ReadReferenceVolume(const std::filesystem::path& folder) {
  const nlohmann::json json = ReadJson(folder / "volume.json");
  ExtinctionGrid grid{NoBricks(Vector3(json.at("cells")).cast<int>(),
                               Vector3(json.at("origin_m")),
                               json.at("cell_m").get<double>()),
                      {}};
  std::vector<float> values(grid.Count());
  const std::filesystem::path file = folder / "volume.f32.gz";
  gzFile in = gzopen(file.c_str(), "rb");
  const auto bytes = static_cast<unsigned>(grid.Count() * sizeof(float));
  const int read = in != nullptr ? gzread(in, values.data(), bytes) : -1;
  if (in != nullptr) gzclose(in);
  if (read != static_cast<int>(bytes)) {
    throw std::runtime_error(file.string() + ": not the floats of volume.json");
  }
  std::size_t at = 0;
  Fill(grid, [&](int, int, int) { return values[at++]; });
  return grid;
}

struct ReferenceTree {
  ExtinctionGrid grid;
  std::vector<NamedCamera> cameras;
  Place place;
  std::string input_time;  // Local, with offset: 2011-07-22T13:00:00-04:00
  Eigen::AlignedBox3d true_box;

  const Camera& CameraOf(const std::string& view) const {
    for (const NamedCamera& named : cameras) {
      if (named.view == view) return named.camera;
    }
    throw std::runtime_error("no camera " + view);
  }
  // The instant of a local time of the input's day.
  Instant At(int hour, int minute, int second = 0) const {
    int year = 0, month = 0, day = 0, offset_hours = 0, offset_minutes = 0;
    if (std::sscanf(input_time.c_str(),
                    "%d-%d-%dT%*d:%*d:%*d%d:%d",
                    &year,
                    &month,
                    &day,
                    &offset_hours,
                    &offset_minutes) != 5 ||
        offset_minutes != 0) {
      throw std::runtime_error("no time with an offset of whole hours: " + input_time);
    }
    using namespace std::chrono;
    return sys_days{std::chrono::year{year} / month / day} + hours{hour - offset_hours} +
           minutes{minute} + seconds{second};
  }
};

inline ReferenceTree ReadReferenceTree(const std::string& tree) {
  const std::filesystem::path data = SharedPath("data/" + tree);
  const nlohmann::json truth = ReadJson(data / "capture_truth.json");
  ReferenceTree result;
  result.grid = ReadReferenceVolume(SharedPath("reference/cabral2011/" + tree));
  result.cameras = ReadColmap(data / "sparse").cameras;
  result.place = {truth.at("place").at("latitude").get<double>(),
                  truth.at("place").at("longitude").get<double>(),
                  truth.at("place").at("altitude_m").get<double>()};
  result.input_time = truth.at("input_time").get<std::string>();
  result.true_box = Eigen::AlignedBox3d(Vector3(truth.at("bbox_min_m")),
                                        Vector3(truth.at("bbox_max_m")));
  return result;
}

inline cv::Mat1f ReadTrueMatte(const std::string& tree, const std::string& view) {
  return ReadMatte(SharedPath("data/" + tree + "/alpha/" + view + ".png"));
}

}  // namespace relight::tests
