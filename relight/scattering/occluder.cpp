// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/occluder.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/volume/ray_traversal.h"
#include "relight/volume/vdb_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace relight {
namespace fs = std::filesystem;
namespace {

constexpr int kLeaf = 4, kMostTriangles = 20000000;
constexpr int kLatticeSteps = 16;
constexpr double kFar = std::numeric_limits<double>::infinity();

// Whether the ray meets the box before `length_m`.
bool Meets(const Eigen::AlignedBox3d& box,
           const Eigen::Vector3d& from,
           const Eigen::Vector3d& inverse,
           double length_m) {
  double enter = 0, leave = length_m;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(inverse[axis])) {
      if (from[axis] < box.min()[axis] || from[axis] > box.max()[axis]) return false;
      continue;
    }
    const double a = (box.min()[axis] - from[axis]) * inverse[axis];
    const double b = (box.max()[axis] - from[axis]) * inverse[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave * (1 + 1e-12);
}

// --- OBJ -----------------------------------------------------------------------------

class ObjReader {
 public:
  explicit ObjReader(const fs::path& file) : file_(file) {}

  Occluder Read() {
    const std::string text = ReadText(file_);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      ++line_;
      Line(std::string_view(text).substr(begin, end - begin));
      begin = end + 1;
    }
    if (faces_.empty()) {
      throw InputError(file_.string() +
                       ": holds no faces (lines that begin with f), so it hides nothing; "
                       "export the meshes too, or leave --occluder out");
    }
    return {vertices_, faces_};
  }

 private:
  [[noreturn]] void Refuse(const std::string& why) const {
    throw InputError(file_.string() + ":" + std::to_string(line_) + ": " + why +
                     "; export it again as Wavefront OBJ");
  }

  void Line(std::string_view line) {
    words_.clear();
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t from = line.find_first_not_of(" \t\r", at);
      if (from == std::string_view::npos || line[from] == '#') break;
      const std::size_t to = std::min(line.find_first_of(" \t\r", from), line.size());
      words_.push_back(line.substr(from, to - from));
      at = to;
    }
    if (words_.empty()) return;
    if (words_[0] == "v") {
      if (words_.size() < 4) Refuse("a vertex has three numbers");
      vertices_.emplace_back(Number(words_[1]), Number(words_[2]), Number(words_[3]));
    } else if (words_[0] == "f") {
      if (words_.size() < 4) Refuse("a face has three corners or more");
      const int first = Corner(words_[1]);
      for (std::size_t i = 2; i + 1 < words_.size(); ++i) {
        faces_.push_back({first, Corner(words_[i]), Corner(words_[i + 1])});
      }
      if (faces_.size() > kMostTriangles) {
        throw InputError(file_.string() +
                         ": has more than 20 million triangles; a shadow needs far "
                         "fewer, so export a simpler mesh");
      }
    }
  }

  double Number(std::string_view word) const {
    double value = 0;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] =
        std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      Refuse("\"" + std::string(word.substr(0, 40)) + "\" is no number");
    }
    if (!std::isfinite(value) || std::abs(value) > 1e9) {
      Refuse("\"" + std::string(word.substr(0, 40)) + "\" is no place on the Earth");
    }
    return value;
  }

  // "7", "7/1/3", "-1": from 1 on, or back from the last.
  int Corner(std::string_view word) const {
    const std::string_view number = word.substr(0, word.find('/'));
    long long at = 0;
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), at);
    if (error != std::errc() || end != number.data() + number.size()) {
      Refuse("\"" + std::string(word.substr(0, 40)) + "\" is no corner of a face");
    }
    const auto count = static_cast<long long>(vertices_.size());
    if (at < 0) at += count + 1;
    if (at < 1 || at > count) {
      Refuse("a face names vertex " + std::string(number.substr(0, 40)) + " of " +
             std::to_string(count) + " so far");
    }
    return static_cast<int>(at - 1);
  }

  fs::path file_;
  std::size_t line_ = 0;
  std::vector<std::string_view> words_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<int, 3>> faces_;
};

}  // namespace

Occluder::Occluder(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<std::array<int, 3>>& faces) {
  const auto at = [&](int corner) {
    Require(corner >= 0 && static_cast<std::size_t>(corner) < vertices.size(),
            "a face's corners are vertices");
    return vertices[static_cast<std::size_t>(corner)];
  };
  for (const auto& [a, b, c] : faces) {
    const Triangle triangle{at(a), at(b) - at(a), at(c) - at(a)};
    if (triangle.edge1.cross(triangle.edge2).squaredNorm() > 0) {
      triangles_.push_back(triangle);
    }
  }
  if (triangles_.empty()) return;
  nodes_.emplace_back();
  Build(0, 0, static_cast<int>(triangles_.size()));
}

Occluder::Occluder(ExtinctionGrid grid) : grid_(std::move(grid)) {}

// Halves of equal number along the longest side of the middles' box.
void Occluder::Build(int node, int begin, int end) {
  const auto middle_of = [](const Triangle& t) {
    return Eigen::Vector3d(t.corner + (t.edge1 + t.edge2) / 3);
  };
  Eigen::AlignedBox3d box, middles;
  for (int i = begin; i < end; ++i) {
    const Triangle& t = triangles_[static_cast<std::size_t>(i)];
    box.extend(t.corner);
    box.extend(Eigen::Vector3d(t.corner + t.edge1));
    box.extend(Eigen::Vector3d(t.corner + t.edge2));
    middles.extend(middle_of(t));
  }
  nodes_[static_cast<std::size_t>(node)].box = box;
  if (end - begin <= kLeaf) {
    nodes_[static_cast<std::size_t>(node)].first = begin;
    nodes_[static_cast<std::size_t>(node)].count = end - begin;
    return;
  }
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin,
                   triangles_.begin() + middle,
                   triangles_.begin() + end,
                   [&](const Triangle& a, const Triangle& b) {
                     return middle_of(a)[axis] < middle_of(b)[axis];
                   });
  const int children = static_cast<int>(nodes_.size());
  nodes_[static_cast<std::size_t>(node)].first = children;
  nodes_.resize(nodes_.size() + 2);
  Build(children, begin, middle);
  Build(children + 1, middle, end);
}

// Any triangle on the way.                                              [Moeller97]
bool Occluder::Hides(const Eigen::Vector3d& from,
                     const Eigen::Vector3d& direction,
                     double length_m) const {
  if (nodes_.empty()) return false;
  Eigen::Vector3d inverse;
  for (int axis = 0; axis < 3; ++axis) {
    inverse[axis] = std::abs(direction[axis]) < 1e-300 ? kFar : 1 / direction[axis];
  }
  constexpr double kEdge = 1e-9;  // Rays between two triangles of an edge meet one
  std::array<int, 64> waiting{};  // Halves: 25 deep with the most triangles
  std::size_t count = 1;
  while (count > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(waiting[--count])];
    if (!Meets(node.box, from, inverse, length_m)) continue;
    if (node.count == 0) {
      waiting[count++] = node.first;
      waiting[count++] = node.first + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[static_cast<std::size_t>(i)];
      const Eigen::Vector3d p = direction.cross(t.edge2);
      const double determinant = t.edge1.dot(p);
      if (determinant == 0) continue;  // Along its plane
      const Eigen::Vector3d to = from - t.corner;
      const double u = to.dot(p) / determinant;
      if (u < -kEdge || u > 1 + kEdge) continue;
      const Eigen::Vector3d q = to.cross(t.edge1);
      const double v = direction.dot(q) / determinant;
      if (v < -kEdge || u + v > 1 + kEdge) continue;
      const double distance_m = t.edge2.dot(q) / determinant;
      if (distance_m > 0 && distance_m < length_m) return true;
    }
  }
  return false;
}

double Occluder::Transmittance(const Eigen::Vector3d& point,
                               const Eigen::Vector3d& direction) const {
  if (Hides(point, direction, kFar)) return 0.0;
  if (grid_.sigma_per_m.empty()) return 1.0;
  return std::exp(-OpticalDepth(grid_, {point, direction}));
}

double Occluder::TransmittanceBetween(const Eigen::Vector3d& a,
                                      const Eigen::Vector3d& b) const {
  const double length_m = (b - a).norm();
  if (!(length_m > 0)) return 1.0;
  const Eigen::Vector3d direction = (b - a) / length_m;
  if (Hides(a, direction, length_m)) return 0.0;
  if (grid_.sigma_per_m.empty()) return 1.0;
  double depth = 0;
  TraverseRay(
      grid_, {a, direction}, 0.0, [&](std::size_t voxel, double at_m, double part_m) {
        if (at_m >= length_m) return false;
        depth += std::min(part_m, length_m - at_m) * grid_.sigma_per_m[voxel];
        return true;
      });
  return std::exp(-depth);
}

Occluder ReadOccluder(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(
      extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
        return static_cast<char>(std::tolower(c));
      });
  if (extension == ".obj") return ObjReader(file).Read();
  if (extension == ".vdb") return Occluder(ImportVdb(file, {}));
  throw InputError(file.string() +
                   ": an occluder is a mesh as .obj or a volume as .vdb; convert it to "
                   "one of them");
}

std::function<void(const Eigen::Vector3d& direction, std::span<float> depth)>
OccluderDepth(const Occluder& occluder,
              const ExtinctionGrid& grid,
              const OccupiedVoxels& occupied) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3i& cell : occupied.cell) {
    box.extend(grid.Center(cell.x(), cell.y(), cell.z()));
  }
  const double step_m = std::max(grid.cell_m, box.sizes().maxCoeff() / kLatticeSteps);
  const Eigen::Vector3i points =
      (box.sizes() / step_m).array().ceil().cast<int>().matrix() +
      Eigen::Vector3i::Constant(1);
  return [&occluder, &grid, &occupied, box, step_m, points](
             const Eigen::Vector3d& direction, std::span<float> depth) {
    // T on the lattice
    std::vector<float> lattice(static_cast<std::size_t>(points.prod()));
    std::size_t at = 0;
    bool clear = true;
    for (int z = 0; z < points.z(); ++z) {
      for (int y = 0; y < points.y(); ++y) {
        for (int x = 0; x < points.x(); ++x, ++at) {
          const Eigen::Vector3d point = box.min() + step_m * Eigen::Vector3d(x, y, z);
          lattice[at] = static_cast<float>(occluder.Transmittance(point, direction));
          clear = clear && lattice[at] == 1.0f;
        }
      }
    }
    if (clear) return;

    // At each voxel
    const auto value = [&](int x, int y, int z) {
      x = std::min(x, points.x() - 1);
      y = std::min(y, points.y() - 1);
      z = std::min(z, points.z() - 1);
      return lattice[static_cast<std::size_t>(x + points.x() * (y + points.y() * z))];
    };
    for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
      const Eigen::Vector3i& cell = occupied.cell[v];
      const Eigen::Vector3d place =
          (grid.Center(cell.x(), cell.y(), cell.z()) - box.min()) / step_m;
      const Eigen::Vector3i low = place.array().floor().cast<int>().max(0).matrix();
      const Eigen::Vector3f u = (place - low.cast<double>()).cast<float>();
      float t = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        t += (i != 0 ? u.x() : 1 - u.x()) * (j != 0 ? u.y() : 1 - u.y()) *
             (k != 0 ? u.z() : 1 - u.z()) * value(low.x() + i, low.y() + j, low.z() + k);
      }
      depth[v] -= std::log(std::max(t, 1e-30f));
    }
  };
}

}  // namespace relight
