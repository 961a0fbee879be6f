// SPDX-License-Identifier: Apache-2.0
// write_seeds FOLDER: FOLDER/seeds/TARGET, small files as the programs write them, where
// the fuzzers start; and FOLDER/large/TARGET, files of just below 1 MB that ask for as
// much memory as such files can.

#include "tests/fuzz/fuzz_files.h"
#include "tests/support/camera_texts.h"

#include <filesystem>
#include <iostream>

namespace {

using namespace relight;
namespace fs = std::filesystem;

constexpr std::size_t kLarge = 999'000;

void Put(const fs::path& folder, const std::string& name, const std::string& text) {
  fs::create_directories(folder);
  std::ofstream(folder / name, std::ios::binary) << text;
}

std::string Joined(const std::vector<std::string>& files) {
  std::string joined;
  for (const std::string& file : files) {
    if (!joined.empty()) joined += fuzz::kNextFile;
    joined += file;
  }
  return joined;
}

// `text` again and again, up to a large file's size.
std::string Repeated(const std::string& text) {
  std::string repeated;
  while (repeated.size() + text.size() < kLarge) repeated += text;
  return repeated;
}

std::string BinaryPoints() {
  tests::ColmapBytes bytes;
  bytes.Add<std::uint64_t>(1).Add<std::uint64_t>(7);
  bytes.Add(1.0).Add(2.0).Add(3.0).Add('a').Add('b').Add('c').Add(0.5);
  bytes.Add<std::uint64_t>(1).Add<std::uint32_t>(1).Add<std::uint32_t>(0);
  return bytes.Bytes();
}

void WriteSeeds(const fs::path& folder) {
  std::vector<tests::MadeCamera> cameras = tests::MadeCameras(2);
  const Place place{47, 8, 400};
  const std::string points = "1 2 3 4 10 20 30 0.5 1 0 2 0\n";
  for (const bool full : {false, true}) {
    const std::string name = full ? "full" : "plain";
    if (full) {
      for (tests::MadeCamera& c : cameras) {
        c.cx = 5;
        c.cy = -4;
        c.k3 = 0.01;
        c.k4 = -0.02;
        c.p1 = 0.001;
        c.p2 = 0.002;
      }
    }
    Put(folder / "colmap_text",
        name,
        Joined({tests::ColmapCamerasText(cameras),
                tests::ColmapImagesText(cameras),
                points}));
    Put(folder / "colmap_binary",
        name,
        Joined({tests::ColmapCamerasBinary(cameras),
                tests::ColmapImagesBinary(cameras),
                BinaryPoints()}));
    Put(folder / "bundler",
        name,
        Joined({tests::BundlerList(cameras), tests::BundlerText(cameras)}));
    Put(folder / "transforms", name, tests::TransformsText(cameras));
    Put(folder / "metashape",
        name,
        tests::MetashapeText(cameras, full ? &place : nullptr, full ? "<b2>0</b2>" : ""));
    Put(folder / "realitycapture_csv", name, tests::RealityCaptureTable(cameras));
    Put(folder / "realitycapture_xmp", name, tests::RealityCaptureXmp(cameras[0], full));
  }
  Put(folder / "transforms",
      "blender",
      R"({"camera_angle_x": 0.69, "frames": [{"file_path": "./train/view_10",
      "transform_matrix": [[1, 0, 0, 0.5], [0, 0, -1, -4], [0, 1, 0, 1]]}]})");
  for (tests::MadeCamera& c : cameras) c.fisheye = true;
  Put(folder / "transforms", "fisheye", tests::TransformsText(cameras));
  Put(folder / "metashape", "fisheye", tests::MetashapeText(cameras, nullptr));
}

void WriteLarge(const fs::path& folder) {
  const std::vector<tests::MadeCamera> cameras = tests::MadeCameras(2);
  const std::string lists = Repeated("[");
  Put(folder / "transforms", "lists", lists);
  Put(folder / "transforms", "closed", Repeated("[],").insert(0, "[") + "0]");
  Put(folder / "transforms",
      "frames",
      Repeated("{},").insert(0, "{\"frames\":[") + "0]}");
  for (const char* target : {"metashape", "realitycapture_xmp"}) {
    Put(folder / target, "elements", Repeated("<a>"));
    Put(folder / target, "empty", "<document>" + Repeated("<a/>") + "</document>");
    Put(folder / target, "attributes", "<a" + Repeated(" b=''") + "/>");
  }
  Put(folder / "metashape",
      "cameras",
      "<document><chunk><cameras>" + Repeated("<group><camera/>"));
  Put(folder / "metashape",
      "groups",
      "<document><chunk><cameras>" + Repeated("<group/>") +
          "</cameras></chunk></document>");
  Put(folder / "realitycapture_csv", "commas", "#name,x,y,alt" + Repeated(","));
  Put(folder / "realitycapture_csv", "lines", Repeated("a\n"));
  Put(folder / "bundler",
      "names",
      Joined({Repeated("a\n"), "# Bundle file v0.3\n2 1\n"}));
  Put(folder / "bundler",
      "numbers",
      Joined({"a\n", "# Bundle file v0.3\n1 1\n" + Repeated("1 ")}));
  Put(folder / "colmap_text",
      "points",
      Joined({tests::ColmapCamerasText(cameras),
              tests::ColmapImagesText(cameras),
              Repeated("1 0 0 0 0 0 0 0\n")}));
  Put(folder / "colmap_text",
      "parameters",
      Joined({"1 PINHOLE 640 480 " + Repeated("1 "), "1 1 0 0 0 0 0 0 1 a\n\n", ""}));
  Put(folder / "colmap_binary", "counts", Repeated("\xff"));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_seeds FOLDER\n";
    return 2;
  }
  WriteSeeds(fs::path(argv[1]) / "seeds");
  WriteLarge(fs::path(argv[1]) / "large");
}
