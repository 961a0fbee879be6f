// SPDX-License-Identifier: Apache-2.0
#pragma once

// The same cameras in the words of each program: text as its documentation has it, made
// here from formulas of its own and not by what the library writes. Also the seeds of
// tests/fuzz.

#include "relight/base/instant.h"
#include "relight/cameras/calibrated_scene.h"
#include "tests/support/made_cameras.h"

#include <Eigen/Dense>

#include <cmath>
#include <cstring>
#include <iomanip>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace relight::tests {

// A camera in the world ENU, looking along the third row of `rotation` (x right, y down).
struct MadeCamera {
  std::string view;
  int w = 0, h = 0;
  double f = 0;  // Pixels along x; along y it is aspect times that.
  double aspect = 1;
  double cx = 0, cy = 0;  // Pixels from the middle of the picture.
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0, p1 = 0, p2 = 0;  // Polynomial; OpenCV's order.
  bool fisheye = false;
  Eigen::Matrix3d rotation;  // World to camera.
  Eigen::Vector3d position;
};

// Where a point is seen: every formula written out once more.
inline Eigen::Vector2d PixelOf(const MadeCamera& c, const Eigen::Vector3d& point) {
  const Eigen::Vector3d at = c.rotation * (point - c.position);
  const double x = at[0] / at[2], y = at[1] / at[2], r2 = x * x + y * y;
  double u = 0, v = 0;
  if (c.fisheye) {
    const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
    const double along = t + c.k1 * t * t2 + c.k2 * t * std::pow(t, 4) +
                         c.k3 * std::pow(t, 7) + c.k4 * std::pow(t, 9);
    u = along * x / r;
    v = along * y / r;
  } else {
    const double q = 1 + c.k1 * r2 + c.k2 * std::pow(r2, 2) + c.k3 * std::pow(r2, 3) +
                     c.k4 * std::pow(r2, 4);
    u = x * q + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x);
    v = y * q + 2 * c.p2 * x * y + c.p1 * (r2 + 2 * y * y);
  }
  return {c.w / 2.0 + c.cx + c.f * u, c.h / 2.0 + c.cy + c.f * c.aspect * v};
}

// Around a tree at the origin: upright and wide photos, small and large.
inline std::vector<MadeCamera> MadeCameras(int count) {
  const int sizes[][2] = {{640, 480}, {480, 640}, {4000, 3000}, {3000, 4000}};
  std::vector<MadeCamera> cameras;
  for (int i = 0; i < count; ++i) {
    MadeCamera made;
    made.view = "view_" + std::to_string(10 + i);
    made.w = sizes[i % 4][0];
    made.h = sizes[i % 4][1];
    made.f = (0.8 + 0.05 * i) * std::max(made.w, made.h);
    const double turn = 0.3 + 2 * std::numbers::pi * i / count;
    const Eigen::Vector3d eye(14 * std::sin(turn), 14 * std::cos(turn), 1.6 + 0.4 * i);
    const Camera camera = LookingAt(eye, {0.2, -0.1, 4}, made.w, made.h, made.f);
    // Held a little askew
    made.rotation =
        Eigen::AngleAxisd(0.05 * (i - 1), Eigen::Vector3d::UnitZ()).toRotationMatrix() *
        camera.camera_from_world.linear();
    made.position = eye;
    made.k1 = -0.11 + 0.01 * i;
    made.k2 = 0.04;
    cameras.push_back(made);
  }
  return cameras;
}

inline PhotoSizes SizesOf(const std::vector<MadeCamera>& cameras) {
  PhotoSizes sizes;
  for (const MadeCamera& c : cameras) sizes[c.view] = {c.w, c.h};
  return sizes;
}

inline std::ostringstream ExactText() {
  std::ostringstream text;
  text << std::setprecision(17);
  return text;
}

// Numbers of a matrix, rows first, with blanks between.
inline std::string RowsFirst(const Eigen::MatrixXd& m) {
  std::ostringstream text = ExactText();
  for (int row = 0; row < m.rows(); ++row) {
    for (int column = 0; column < m.cols(); ++column) {
      text << (row + column > 0 ? " " : "") << m(row, column);
    }
  }
  return text.str();
}

// Camera to world, 4 x 4, x right, y down, z forward.
inline Eigen::Matrix4d WorldFromCamera(const MadeCamera& c) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = c.rotation.transpose();
  m.topRightCorner<3, 1>() = c.position;
  return m;
}

// --- COLMAP ----------------------------------------------------------------------------

inline std::string ColmapCamerasText(const std::vector<MadeCamera>& cameras) {
  std::ostringstream text = ExactText();
  int id = 0;
  for (const MadeCamera& c : cameras) {
    text << ++id << " FULL_OPENCV " << c.w << ' ' << c.h << ' ' << c.f << ' '
         << c.f * c.aspect << ' ' << c.w / 2.0 + c.cx << ' ' << c.h / 2.0 + c.cy << ' '
         << c.k1 << ' ' << c.k2 << ' ' << c.p1 << ' ' << c.p2 << ' ' << c.k3
         << " 0 0 0\n";
  }
  return text.str();
}

inline std::string ColmapImagesText(const std::vector<MadeCamera>& cameras) {
  std::ostringstream text = ExactText();
  int id = 0;
  for (const MadeCamera& c : cameras) {
    const Eigen::Quaterniond q(c.rotation);
    const Eigen::Vector3d t = -c.rotation * c.position;
    ++id;
    text << id << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
         << RowsFirst(t.transpose()) << ' ' << id << ' ' << c.view << ".jpg\n1 2 -1\n";
  }
  return text.str();
}

class ColmapBytes {
 public:
  template <class Value>
  ColmapBytes& Add(Value value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    bytes_.append(bytes, sizeof value);
    return *this;
  }
  ColmapBytes& AddName(const std::string& name) {
    bytes_ += name;
    bytes_ += '\0';
    return *this;
  }
  const std::string& Bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

inline std::string ColmapCamerasBinary(const std::vector<MadeCamera>& cameras) {
  ColmapBytes bytes;
  bytes.Add<std::uint64_t>(cameras.size());
  std::uint32_t id = 0;
  for (const MadeCamera& c : cameras) {
    bytes.Add<std::uint32_t>(++id).Add<std::int32_t>(6);  // FULL_OPENCV
    bytes.Add<std::uint64_t>(c.w).Add<std::uint64_t>(c.h);
    for (const double number : {c.f,
                                c.f * c.aspect,
                                c.w / 2.0 + c.cx,
                                c.h / 2.0 + c.cy,
                                c.k1,
                                c.k2,
                                c.p1,
                                c.p2,
                                c.k3,
                                0.0,
                                0.0,
                                0.0}) {
      bytes.Add(number);
    }
  }
  return bytes.Bytes();
}

inline std::string ColmapImagesBinary(const std::vector<MadeCamera>& cameras) {
  ColmapBytes bytes;
  bytes.Add<std::uint64_t>(cameras.size());
  std::uint32_t id = 0;
  for (const MadeCamera& c : cameras) {
    const Eigen::Quaterniond q(c.rotation);
    const Eigen::Vector3d t = -c.rotation * c.position;
    bytes.Add<std::uint32_t>(++id);
    for (const double number : {q.w(), q.x(), q.y(), q.z(), t[0], t[1], t[2]}) {
      bytes.Add(number);
    }
    bytes.Add<std::uint32_t>(id).AddName(c.view + ".jpg").Add<std::uint64_t>(0);
  }
  return bytes.Bytes();
}

// --- Bundler ---------------------------------------------------------------------------

inline std::string BundlerText(const std::vector<MadeCamera>& cameras) {
  std::ostringstream text = ExactText();
  text << "# Bundle file v0.3\n" << cameras.size() << " 1\n";
  const Eigen::Matrix3d up_and_back = Eigen::Vector3d(1, -1, -1).asDiagonal();
  for (const MadeCamera& c : cameras) {
    const Eigen::Matrix3d r = up_and_back * c.rotation;
    const Eigen::Vector3d t = -(r * c.position);
    text << c.f << ' ' << c.k1 << ' ' << c.k2 << '\n';
    for (int row = 0; row < 3; ++row) text << RowsFirst(r.row(row)) << '\n';
    text << RowsFirst(t.transpose()) << '\n';
  }
  text << "1 2 3\n10 20 30\n2 0 5 12.5 -3 1 7 0.5 4\n";
  return text.str();
}

inline std::string BundlerList(const std::vector<MadeCamera>& cameras) {
  std::string text;
  for (const MadeCamera& c : cameras) text += "photos/" + c.view + ".jpg 0 532.5\n";
  return text;
}

// --- transforms.json -------------------------------------------------------------------

inline std::string TransformsText(const std::vector<MadeCamera>& cameras) {
  std::ostringstream text = ExactText();
  text << "{\"camera_model\": \"" << (cameras[0].fisheye ? "OPENCV_FISHEYE" : "OPENCV")
       << "\", \"frames\": [";
  const char* between = "\n";
  for (const MadeCamera& c : cameras) {
    Eigen::Matrix4d m = WorldFromCamera(c);
    m.col(1) *= -1;
    m.col(2) *= -1;
    text << between << "{\"file_path\": \"images/" << c.view << ".jpg\", \"w\": " << c.w
         << ", \"h\": " << c.h << ", \"fl_x\": " << c.f
         << ", \"fl_y\": " << c.f * c.aspect << ", \"cx\": " << c.w / 2.0 + c.cx
         << ", \"cy\": " << c.h / 2.0 + c.cy << ", \"k1\": " << c.k1
         << ", \"k2\": " << c.k2 << ", \"k3\": " << c.k3 << ", \"k4\": " << c.k4
         << ", \"p1\": " << c.p1 << ", \"p2\": " << c.p2 << ",\n \"transform_matrix\": [";
    for (int row = 0; row < 4; ++row) {
      text << (row > 0 ? ", [" : "[") << m(row, 0) << ", " << m(row, 1) << ", "
           << m(row, 2) << ", " << m(row, 3) << ']';
    }
    text << "]}";
    between = ",\n";
  }
  text << "]}\n";
  return text.str();
}

// --- Metashape -------------------------------------------------------------------------

// WGS84: a point in ECEF, and the axes of ENU there as columns.
struct Ecef {
  Eigen::Vector3d origin;
  Eigen::Matrix3d enu;
};
inline Ecef EcefAt(const Place& place) {
  const double a = 6378137.0, flat = 1 / 298.257223563, e2 = flat * (2 - flat);
  const double lat = place.latitude_deg * std::numbers::pi / 180;
  const double lon = place.longitude_deg * std::numbers::pi / 180;
  const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  Ecef ecef;
  ecef.origin = {(n + place.altitude_m) * std::cos(lat) * std::cos(lon),
                 (n + place.altitude_m) * std::cos(lat) * std::sin(lon),
                 (n * (1 - e2) + place.altitude_m) * std::sin(lat)};
  ecef.enu << -std::sin(lon), -std::sin(lat) * std::cos(lon),
      std::cos(lat) * std::cos(lon), std::cos(lon), -std::sin(lat) * std::sin(lon),
      std::cos(lat) * std::sin(lon), 0, std::cos(lat), std::sin(lat);
  return ecef;
}

// Local when `place` is null, else ECEF of ENU there.
inline std::string MetashapeText(const std::vector<MadeCamera>& cameras,
                                 const Place* place,
                                 const std::string& more_calibration = "") {
  std::ostringstream text = ExactText();
  text << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n"
       << "<chunk label=\"Chunk 1\" enabled=\"true\">\n<sensors next_id=\"9\">\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const MadeCamera& c = cameras[i];
    const char* type = c.fisheye ? "fisheye" : "frame";
    text << "<sensor id=\"" << i << "\" label=\"K-" << i << "\" type=\"" << type
         << "\">\n<resolution width=\"" << c.w << "\" height=\"" << c.h << "\"/>\n"
         << "<calibration type=\"" << type
         << "\" class=\"initial\"><f>1</f></calibration>"
         << "\n<calibration type=\"" << type << "\" class=\"adjusted\">\n"
         << "<resolution width=\"" << c.w << "\" height=\"" << c.h << "\"/>\n"
         << "<f>" << c.f * c.aspect << "</f><cx>" << c.cx << "</cx><cy>" << c.cy
         << "</cy><b1>" << c.f - c.f * c.aspect << "</b1>\n<k1>" << c.k1 << "</k1><k2>"
         << c.k2 << "</k2><k3>" << c.k3 << "</k3><k4>" << c.k4 << "</k4><p1>" << c.p2
         << "</p1><p2>" << c.p1 << "</p2>" << more_calibration
         << "\n</calibration>\n</sensor>\n";
  }
  // A chunk of another unit, turned and moved against the world
  const double scale = 2.5;
  const Ecef earth = place != nullptr
                         ? EcefAt(*place)
                         : Ecef{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  const Eigen::Matrix3d turn =
      earth.enu *
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift = earth.origin + Eigen::Vector3d(3, -2, 1);
  text << "</sensors>\n<components next_id=\"1\" active_id=\"0\">\n<component id=\"0\">"
       << "<transform>\n<rotation locked=\"true\">" << RowsFirst(turn)
       << "</rotation>\n<translation>" << RowsFirst(shift.transpose())
       << "</translation>\n<scale>" << scale << "</scale></transform></component>"
       << "\n</components>\n<cameras next_id=\"9\" next_group_id=\"1\">\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const MadeCamera& c = cameras[i];
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = turn.transpose() * earth.enu * c.rotation.transpose();
    m.topRightCorner<3, 1>() =
        turn.transpose() * (earth.origin + earth.enu * c.position - shift) / scale;
    text << (i == 0 ? "<group id=\"0\" label=\"g\" type=\"folder\">" : "")
         << "<camera id=\"" << i << "\" sensor_id=\"" << i
         << "\" component_id=\"0\" label=\"" << c.view << (i % 2 == 0 ? ".JPG" : "")
         << "\">\n<transform>" << RowsFirst(m) << "</transform></camera>"
         << (i == 0 ? "</group>\n" : "\n");
  }
  text << "<camera id=\"99\" sensor_id=\"0\" label=\"not "
          "aligned\"/>\n</cameras>\n<reference>"
       << (place != nullptr ? "GEOGCS[&quot;WGS 84&quot;,DATUM[&quot;WGS84&quot;]]"
                            : "LOCAL_CS[&quot;Local Coordinates (m)&quot;]")
       << "</reference>\n</chunk>\n</document>\n";
  return text.str();
}

// --- RealityCapture --------------------------------------------------------------------

// heading, pitch and roll in degrees: the camera's axes, y up and z back, in the world
// are Rz(-heading) Rx(pitch) Ry(roll), whose entries are solved for the angles here.
inline Eigen::Vector3d HeadingPitchRoll(const MadeCamera& c) {
  Eigen::Matrix3d m = c.rotation.transpose();
  m.col(1) *= -1;
  m.col(2) *= -1;
  const double deg = 180 / std::numbers::pi;
  return {deg * std::atan2(m(0, 1), m(1, 1)),
          deg * std::asin(m(2, 1)),
          deg * std::atan2(-m(2, 0), m(2, 2))};
}

inline std::string RealityCaptureTable(const std::vector<MadeCamera>& cameras) {
  std::ostringstream text = ExactText();
  text << "#cameras " << cameras.size()
       << "\n#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n";
  for (const MadeCamera& c : cameras) {
    const double longer = std::max(c.w, c.h);
    const Eigen::Vector3d angles = HeadingPitchRoll(c);
    text << c.view << ".jpg," << c.position[0] << ',' << c.position[1] << ','
         << c.position[2] << ',' << angles[0] << ',' << angles[1] << ',' << angles[2]
         << ',' << c.f * 36 / longer << ',' << c.cx / longer << ',' << c.cy / longer
         << ',' << c.k1 << ',' << c.k2 << ',' << c.k3 << ',' << c.k4 << ',' << c.p2 << ','
         << c.p1 << "\r\n";
  }
  return text.str();
}

inline std::string RealityCaptureXmp(const MadeCamera& c, bool as_attributes) {
  const double longer = std::max(c.w, c.h);
  std::ostringstream text = ExactText();
  const auto field = [&](const char* name, const std::string& value) {
    return as_attributes
               ? " xcr:" + std::string(name) + "=\"" + value + "\""
               : "<xcr:" + std::string(name) + ">" + value + "</xcr:" + name + ">\n";
  };
  std::ostringstream distortion = ExactText();
  distortion << c.k1 << ' ' << c.k2 << ' ' << c.k3 << ' ' << c.k4 << ' ' << c.p2 << ' '
             << c.p1;
  text << "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
       << "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
       << "<rdf:Description xcr:Version=\"3\" xcr:PosePrior=\"initial\" "
       << "xcr:Coordinates=\"absolute\" xcr:DistortionModel=\"brown4t2\" "
       << "xcr:FocalLength35mm=\"" << c.f * 36 / longer
       << "\" xcr:Skew=\"0\" xcr:AspectRatio=\"" << c.aspect
       << "\" xcr:PrincipalPointU=\"" << c.cx / longer << "\" xcr:PrincipalPointV=\""
       << c.cy / longer << "\" xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\""
       << (as_attributes ? "" : ">\n") << field("Rotation", RowsFirst(c.rotation))
       << field("Position", RowsFirst(c.position.transpose()))
       << field("DistortionCoeficients", distortion.str()) << (as_attributes ? ">\n" : "")
       << "</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n";
  return text.str();
}

}  // namespace relight::tests
