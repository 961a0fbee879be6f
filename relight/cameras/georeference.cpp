// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/georeference.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <Eigen/Dense>
#include <GeographicLib/LocalCartesian.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

namespace relight {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr double kTukey = 4.685;  // 95 % of least squares' efficiency for normal errors.
constexpr double kUserAngle_rad = 0.5 * kRadPerDeg;  // What a user states is that good.
constexpr double kUserShadow_rad = 1.5 * kRadPerDeg;
constexpr double kUserLength = 0.01;    // Of the length.
constexpr double kUsualPitch_deg = 20;  // Cameras look about level when nothing is known.
constexpr double kVerticalGps = 2;      // GPS heights are that much worse.
constexpr double kPriorPhotos = 4;      // The stated sigmas count as that many residuals.

double WrapPi(double angle_rad) { return RadFromDeg(WrapDeg180(DegFromRad(angle_rad))); }

// Of Tukey's biweight, for a residual in units of sigma: like r^2 / 2 near 0.
double Rho(double r) {
  const double u = std::min(1.0, r * r / (kTukey * kTukey));
  return kTukey * kTukey / 6 * (1 - std::pow(1 - u, 3));
}
double Weight(double r) {
  const double u = r * r / (kTukey * kTukey);
  return u < 1 ? (1 - u) * (1 - u) : 0;
}

struct Similarity {
  double log_scale = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator()(const Eigen::Vector3d& point) const {
    return std::exp(log_scale) * (rotation * point) + translation;
  }
  // A small turn and a growth about `center` in the world, and a shift.
  Similarity Moved(const Vector7d& step, const Eigen::Vector3d& center) const {
    const Eigen::Vector3d turn = step.head<3>();
    const double angle = turn.norm();
    const Eigen::Matrix3d by =
        angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                  : Eigen::Matrix3d::Identity();
    Similarity moved;
    moved.rotation = by * rotation;
    moved.log_scale = log_scale + step[3];
    moved.translation =
        center + std::exp(step[3]) * (by * (translation - center)) + step.tail<3>();
    return moved;
  }
};

// The sigmas that are scaled to the residuals.
enum Kind { kGps, kGpsHeight, kCompass, kOther };

struct Residual {
  Kind kind = kOther;
  int view = -1;  // Index of the camera; -1 for none.
  int size = 1;
  Eigen::Vector2d value = {0, 0};  // In units of sigma.
  bool is_weak = false;            // A habit, no measurement: never called an outlier.

  double Norm() const {
    return size == 2 ? value.norm() / std::numbers::sqrt2 : std::abs(value[0]);
  }
};

class Problem {
 public:
  Problem(const CalibratedScene& scene,
          std::span<const CameraClues> clues,
          const GivenFrame& given,
          const GeoreferenceOptions& options)
      : given_(given) {
    sigma_ = {options.gps_error_m,
              kVerticalGps * options.gps_error_m,
              RadFromDeg(options.compass_error_deg)};
    level_rad_ = RadFromDeg(options.level_error_deg);
    for (const NamedCamera& named : scene.cameras) {
      views_.push_back(named.view);
      cameras_.push_back(&named.camera);
      position_.push_back(named.camera.PositionInWorld());
      axes_.push_back(named.camera.camera_from_world.linear().transpose());
    }
    gps_.resize(views_.size());
    compass_.resize(views_.size());
    for (const CameraClues& clue : clues) {
      const int view = Find(clue.view);
      if (view < 0) continue;
      if (clue.place) {
        if (!origin_) origin_ = clue.place;
        gps_[view] = FromPlace(*clue.place);
      }
      compass_[view] = clue.heading_rad;
    }
    const auto required = [&](const std::string& view) {
      if (Find(view) >= 0) return;
      throw InputError("no camera of the view \"" + view +
                       "\" in the model; give one of those that it has");
    };
    if (given_.heading) required(given_.heading->view);
    if (given_.shadow) required(given_.shadow->view);
    if (given_.distance) {
      required(given_.distance->a);
      required(given_.distance->b);
    }
    // A heading that the user states is better than any compass
    if (given_.heading || given_.shadow) compass_.assign(views_.size(), std::nullopt);
  }

  std::size_t size() const { return views_.size(); }
  const std::vector<std::string>& views() const { return views_; }
  const std::vector<std::optional<Eigen::Vector3d>>& gps() const { return gps_; }
  const std::vector<std::optional<double>>& compass() const { return compass_; }
  const std::vector<Eigen::Vector3d>& positions() const { return position_; }
  const std::vector<Eigen::Matrix3d>& axes() const { return axes_; }
  const std::optional<Place>& origin() const { return origin_; }
  const std::array<double, 3>& sigma() const { return sigma_; }
  const GivenFrame& given() const { return given_; }

  // Camera's azimuth in the world; of the picture's upper edge when it looks steeply.
  double HeadingOf(const Eigen::Matrix3d& rotation, int view) const {
    constexpr double kSteep = 0.866;  // 60 degrees
    const Eigen::Vector3d forward = rotation * axes_[view].col(2);
    if (std::abs(forward.z()) < kSteep) return AzimuthOf(forward);
    const Eigen::Vector3d upper_edge = -(rotation * axes_[view].col(1));
    return AzimuthOf(forward.z() < 0 ? upper_edge : Eigen::Vector3d(-upper_edge));
  }

  std::vector<Residual> Residuals(const Similarity& s) const {
    std::vector<Residual> all;
    const auto add = [&](Kind kind, int view, double value, bool is_weak = false) {
      all.push_back({kind, view, 1, {value, 0}, is_weak});
    };
    const bool up_given = given_.up.has_value();
    for (int i = 0; i < static_cast<int>(size()); ++i) {
      if (gps_[i]) {
        const Eigen::Vector3d off = s(position_[i]) - *gps_[i];
        all.push_back({kGps, i, 2, off.head<2>() / sigma_[kGps], false});
        add(kGpsHeight, i, off.z() / sigma_[kGpsHeight]);
      }
      if (compass_[i]) {
        add(kCompass,
            i,
            WrapPi(*compass_[i] - HeadingOf(s.rotation, i)) / sigma_[kCompass]);
      }
      if (up_given) continue;
      const Eigen::Vector3d x = s.rotation * axes_[i].col(0);
      const Eigen::Vector3d forward = s.rotation * axes_[i].col(2);
      add(kOther, i, std::asin(std::clamp(x.z(), -1.0, 1.0)) / level_rad_, true);
      add(kOther, i, ElevationOf(forward) / RadFromDeg(kUsualPitch_deg), true);
      // Upright, not on its head
      const double upside = -(s.rotation * axes_[i].col(1)).z();
      add(kOther, i, upside < -0.1 ? 3.0 : 0.0, true);
    }
    if (given_.up) {
      const Eigen::Vector3d up = s.rotation * given_.up->normalized();
      add(kOther, -1, std::atan2(up.x(), up.z()) / kUserAngle_rad);
      add(kOther, -1, std::atan2(up.y(), up.z()) / kUserAngle_rad);
    }
    if (given_.heading) {
      add(kOther,
          -1,
          WrapPi(given_.heading->heading_rad -
                 HeadingOf(s.rotation, Find(given_.heading->view))) /
              kUserAngle_rad);
    }
    if (given_.shadow) {
      if (const auto azimuth = ShadowAzimuth(s.rotation)) {
        add(kOther,
            -1,
            WrapPi(*azimuth - given_.shadow->sun_azimuth_rad - std::numbers::pi) /
                kUserShadow_rad);
      } else {
        add(kOther, -1, 2 * kTukey);
      }
    }
    if (given_.distance) {
      const double length = (s(position_[Find(given_.distance->a)]) -
                             s(position_[Find(given_.distance->b)]))
                                .norm();
      add(kOther,
          -1,
          std::log(std::max(length, 1e-300) / given_.distance->length_m) / kUserLength);
    }
    return all;
  }

  double Cost(const Similarity& s) const {
    double cost = 0;
    for (const Residual& r : Residuals(s)) cost += r.size * Rho(r.Norm());
    return cost;
  }

  // Gauss-Newton with Tukey's weights; the normal matrix at the end is in `normal`.
  Similarity Refined(Similarity s, Matrix7d* normal) const {
    const Eigen::Vector3d center = CenterOf(s);
    double damping = 1e-6, cost = Cost(s);
    for (int round = 0; round < 60; ++round) {
      const auto [a, b] = Normal(s, center);
      Matrix7d damped = a;
      damped.diagonal() += damping * a.diagonal();
      const Vector7d step = -damped.ldlt().solve(b);
      const Similarity moved = s.Moved(step, center);
      const double moved_cost = Cost(moved);
      if (!(moved_cost < cost)) {
        damping *= 10;
        if (damping > 1e6) break;
        continue;
      }
      const bool done = cost - moved_cost < 1e-10 * (1 + cost);
      s = moved;
      cost = moved_cost;
      damping = std::max(damping / 10, 1e-9);
      if (done) break;
    }
    if (normal != nullptr) *normal = Normal(s, center).first;
    return s;
  }

  // Sigmas of GPS and compass that the residuals speak for.
  void ScaleSigmas(const Similarity& s) {
    std::array<double, 3> sum{}, count{};
    for (const Residual& r : Residuals(s)) {
      if (r.kind == kOther) continue;
      const double weight = Weight(r.Norm());
      sum[r.kind] += weight * r.value.squaredNorm();
      count[r.kind] += weight * r.size;
    }
    for (int kind = 0; kind < 3; ++kind) {
      constexpr double kFitted = 3;  // Numbers of the fit that such residuals pay for.
      if (count[kind] <= kFitted) continue;
      const double share =
          (kPriorPhotos + sum[kind]) / (kPriorPhotos + count[kind] - kFitted);
      sigma_[kind] *= std::sqrt(share);
    }
  }

  int Find(const std::string& view) const {
    const auto found = std::find(views_.begin(), views_.end(), view);
    return found == views_.end() ? -1 : static_cast<int>(found - views_.begin());
  }

  // From the shadow's foot to its tip, on level ground; nothing when a ray misses it.
  std::optional<double> ShadowAzimuth(const Eigen::Matrix3d& rotation) const {
    const Camera& camera = *cameras_[Find(given_.shadow->view)];
    const auto on_ground =
        [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
      const Eigen::Vector3d ray = rotation * camera.RayInWorld(pixel);
      if (ray.z() > -1e-3) return std::nullopt;
      return Eigen::Vector2d(ray.head<2>() / -ray.z());
    };
    const auto foot = on_ground(given_.shadow->foot_px),
               tip = on_ground(given_.shadow->tip_px);
    if (!foot || !tip) return std::nullopt;
    const Eigen::Vector2d along = *tip - *foot;
    return std::atan2(along.x(), along.y());
  }

  // How far that turns when each of its pixels is a pixel off, to both sides.
  double ShadowClickError_rad(const Eigen::Matrix3d& rotation) const {
    const auto azimuth = ShadowAzimuth(rotation);
    double squares = 0;
    for (int number = 0; number < 4; ++number) {
      Problem moved = *this;
      KnownShadow& shadow = *moved.given_.shadow;
      (number < 2 ? shadow.foot_px : shadow.tip_px)[number % 2] += 1;
      const auto then = moved.ShadowAzimuth(rotation);
      const double by = azimuth && then ? WrapPi(*then - *azimuth) : std::numbers::pi;
      squares += by * by;
    }
    return std::min(std::sqrt(squares), std::numbers::pi);
  }

  Eigen::Vector3d CenterOf(const Similarity& s) const {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& position : position_) center += s(position);
    return center / static_cast<double>(size());
  }

 private:
  Eigen::Vector3d FromPlace(const Place& place) const {
    const GeographicLib::LocalCartesian frame(
        origin_->latitude_deg, origin_->longitude_deg, origin_->altitude_m);
    Eigen::Vector3d enu;
    frame.Forward(place.latitude_deg,
                  place.longitude_deg,
                  place.altitude_m,
                  enu.x(),
                  enu.y(),
                  enu.z());
    return enu;
  }

  // Normal matrix and gradient of (C7), by differences: there are few residuals.
  std::pair<Matrix7d, Vector7d> Normal(const Similarity& s,
                                       const Eigen::Vector3d& center) const {
    const std::vector<Residual> here = Residuals(s);
    std::array<std::vector<Residual>, 7> there;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 7; ++k) {
      there[k] = Residuals(s.Moved(kStep * Vector7d::Unit(k), center));
    }
    // What nothing is known of stays where it is
    Matrix7d a = Matrix7d::Zero();
    a.diagonal() << 1e-3, 1e-3, 1e-3, 1e-3, 1e-12, 1e-12, 1e-12;
    Vector7d b = Vector7d::Zero();
    for (std::size_t i = 0; i < here.size(); ++i) {
      const double weight = Weight(here[i].Norm());
      if (weight == 0) continue;
      for (int d = 0; d < here[i].size; ++d) {
        Vector7d slope;
        for (int k = 0; k < 7; ++k) {
          slope[k] = (there[k][i].value[d] - here[i].value[d]) / kStep;
        }
        a += weight * slope * slope.transpose();
        b += weight * slope * here[i].value[d];
      }
    }
    return {a, b};
  }

  GivenFrame given_;
  std::vector<std::string> views_;
  std::vector<const Camera*> cameras_;
  std::vector<Eigen::Vector3d> position_;
  std::vector<Eigen::Matrix3d> axes_;  // Camera's x, y, z in the scene, as columns.
  std::vector<std::optional<Eigen::Vector3d>> gps_;
  std::vector<std::optional<double>> compass_;
  std::optional<Place> origin_;
  std::array<double, 3> sigma_{};  // Of GPS, its height, compass.
  double level_rad_ = 0;
};

// --- Starts -------------------------------------------------------------------------

Eigen::Matrix3d UpToZ(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ())
      .toRotationMatrix();
}

std::vector<Eigen::Vector3d> UpStarts(const Problem& problem) {
  if (problem.given().up) return {problem.given().up->normalized()};
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  Eigen::Vector3d upper_edges = Eigen::Vector3d::Zero();
  for (const Eigen::Matrix3d& axes : problem.axes()) {
    spread += axes.col(0) * axes.col(0).transpose();
    upper_edges -= axes.col(1);
  }
  std::vector<Eigen::Vector3d> starts = {Eigen::Vector3d::UnitZ()};
  // Level: at a right angle to all x axes, one way or the other
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Eigen::Vector3d level = solver.eigenvectors().col(0);
  starts.push_back(level);
  starts.emplace_back(-level);
  if (upper_edges.norm() > 1e-6) starts.push_back(upper_edges.normalized());

  // The plane of the places
  std::vector<int> placed;
  for (int i = 0; i < static_cast<int>(problem.size()); ++i) {
    if (problem.gps()[i]) placed.push_back(i);
  }
  if (placed.size() >= 3) {
    Eigen::Matrix3Xd from(3, placed.size()), to(3, placed.size());
    for (std::size_t i = 0; i < placed.size(); ++i) {
      from.col(i) = problem.positions()[placed[i]];
      to.col(i) = *problem.gps()[placed[i]];
    }
    const Eigen::Matrix4d fit = Eigen::umeyama(from, to, true);
    const double scale = fit.block<3, 1>(0, 0).norm();
    if (std::isfinite(scale) && scale > 0) {
      starts.push_back((fit.block<1, 3>(2, 0) / scale).transpose().normalized());
    }
    // Cameras of one height, whatever their GPS heights
    const Eigen::Vector3d mean = from.rowwise().mean();
    const Eigen::Matrix3Xd centered = from.colwise() - mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> plane(centered *
                                                               centered.transpose());
    starts.emplace_back(plane.eigenvectors().col(0));
    starts.emplace_back(-plane.eigenvectors().col(0));
  }
  return starts;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// s and R, with t so that the median camera is where its place is.
Similarity Placed(const Problem& problem,
                  double log_scale,
                  const Eigen::Matrix3d& rotation) {
  Similarity s{log_scale, rotation, Eigen::Vector3d::Zero()};
  std::array<std::vector<double>, 3> off;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    if (!problem.gps()[i]) continue;
    const Eigen::Vector3d d = *problem.gps()[i] - s(problem.positions()[i]);
    for (int axis = 0; axis < 3; ++axis) off[axis].push_back(d[axis]);
  }
  if (off[0].empty()) return s;
  for (int axis = 0; axis < 3; ++axis) s.translation[axis] = MedianOf(off[axis]);
  return s;
}

// Clockwise about z, so that azimuths grow by the angle.
Eigen::Matrix3d TurnedBy(double azimuth_rad, const Eigen::Matrix3d& rotation) {
  return Eigen::AngleAxisd(-azimuth_rad, Eigen::Vector3d::UnitZ()) * rotation;
}

std::vector<Similarity> Starts(const Problem& problem) {
  std::vector<Similarity> starts;
  for (const Eigen::Vector3d& up : UpStarts(problem)) {
    const Eigen::Matrix3d upright = UpToZ(up);

    // Pairs of places: both scale and north
    std::vector<double> log_scales;
    const auto count = static_cast<int>(problem.size());
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) {
        if (!problem.gps()[i] || !problem.gps()[j]) continue;
        const Eigen::Vector2d model =
            (upright * (problem.positions()[j] - problem.positions()[i])).head<2>();
        const Eigen::Vector2d world = (*problem.gps()[j] - *problem.gps()[i]).head<2>();
        if (model.norm() < 1e-9 || world.norm() < 1e-3) continue;
        const double log_scale = std::log(world.norm() / model.norm());
        log_scales.push_back(log_scale);
        const double turn =
            std::atan2(world.x(), world.y()) - std::atan2(model.x(), model.y());
        starts.push_back(Placed(problem, log_scale, TurnedBy(turn, upright)));
      }
    }

    // One compass, or what the user says of north
    double log_scale = log_scales.empty() ? 0.0 : MedianOf(log_scales);
    if (const auto& known = problem.given().distance) {
      const double length = (problem.positions()[problem.Find(known->a)] -
                             problem.positions()[problem.Find(known->b)])
                                .norm();
      if (length > 0) log_scale = std::log(known->length_m / length);
    }
    const auto turned = [&](double by) {
      starts.push_back(Placed(problem, log_scale, TurnedBy(by, upright)));
    };
    for (int i = 0; i < count; ++i) {
      if (problem.compass()[i])
        turned(*problem.compass()[i] - problem.HeadingOf(upright, i));
    }
    if (const auto& known = problem.given().heading) {
      turned(known->heading_rad - problem.HeadingOf(upright, problem.Find(known->view)));
    }
    if (problem.given().shadow) {
      if (const auto azimuth = problem.ShadowAzimuth(upright)) {
        turned(problem.given().shadow->sun_azimuth_rad + std::numbers::pi - *azimuth);
      }
    }
    turned(0);
  }
  return starts;
}

struct Fit {
  Similarity similarity;
  double cost = std::numeric_limits<double>::infinity();
};

Fit BestFit(const Problem& problem) {
  std::vector<Fit> fits;
  for (const Similarity& start : Starts(problem)) {
    fits.push_back({start, problem.Cost(start)});
  }
  std::stable_sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) {
    return a.cost < b.cost;
  });
  constexpr std::size_t kRefined = 12;
  Fit best;
  for (std::size_t i = 0; i < std::min(kRefined, fits.size()); ++i) {
    Fit fit{problem.Refined(fits[i].similarity, nullptr), 0};
    fit.cost = problem.Cost(fit.similarity);
    if (fit.cost < best.cost) best = fit;
  }
  return best;
}

std::string Listed(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  }
  return text;
}

std::string Count(int count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

Georeference FindGeoreference(const CalibratedScene& scene,
                              std::span<const CameraClues> clues,
                              const GivenFrame& given,
                              const GeoreferenceOptions& options) {
  CheckFields(options);
  Problem problem(scene, clues, given, options);
  Fit best = BestFit(problem);

  // A frame that fits the clues as well as the best does is ENU metres already
  const Similarity own = Placed(problem, 0, Eigen::Matrix3d::Identity());
  constexpr double kChiSquared = 18.5;  // Of 7 degrees of freedom, at 99 %
  const auto known = [](const auto& clues) {
    return std::count_if(
        clues.begin(), clues.end(), [](const auto& clue) { return clue.has_value(); });
  };
  const bool is_judged = known(problem.gps()) + known(problem.compass()) >= 3;
  const bool keeps = is_judged && 2 * (problem.Cost(own) - best.cost) < kChiSquared;

  for (int round = 0; round < 3; ++round) {
    problem.ScaleSigmas(best.similarity);
    best.similarity = problem.Refined(best.similarity, nullptr);
  }
  Matrix7d normal;
  best.similarity = problem.Refined(best.similarity, &normal);
  const Similarity& s = keeps ? own : best.similarity;

  Georeference result;
  result.scale = std::exp(s.log_scale);
  result.rotation = s.rotation;
  result.translation = s.translation;
  result.origin = problem.origin();
  result.kept_frame = keeps;
  const Matrix7d covariance = normal.inverse();
  result.up_error_rad = std::sqrt((covariance(0, 0) + covariance(1, 1)) / 2);
  result.north_error_rad = std::sqrt(covariance(2, 2));
  result.scale_error = std::sqrt(covariance(3, 3));

  // What told it, and what it does not believe
  int places = 0, compasses = 0;
  std::vector<std::string> wrong_places, wrong_compasses;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    ViewResidual view;
    view.view = problem.views()[i];
    if (const auto& gps = problem.gps()[i]) {
      view.gps_m = (s(problem.positions()[i]) - *gps).head<2>().norm();
      view.gps_is_outlier =
          *view.gps_m / std::numbers::sqrt2 > kTukey * problem.sigma()[kGps];
      places += !view.gps_is_outlier;
    }
    if (const auto& compass = problem.compass()[i]) {
      view.compass_rad =
          WrapPi(*compass - problem.HeadingOf(s.rotation, static_cast<int>(i)));
      view.compass_is_outlier =
          std::abs(*view.compass_rad) > kTukey * problem.sigma()[kCompass];
      compasses += !view.compass_is_outlier;
    }
    std::ostringstream off;
    off.precision(3);
    if (view.gps_is_outlier) {
      off << view.view << " (" << *view.gps_m << " m)";
      wrong_places.push_back(off.str());
      off.str("");
    }
    if (view.compass_is_outlier) {
      off << view.view << " (" << DegFromRad(*view.compass_rad) << " deg)";
      wrong_compasses.push_back(off.str());
    }
    result.residuals.push_back(view);
  }
  if (!wrong_places.empty()) {
    result.notes.push_back("GPS places that are far from their cameras are left out: " +
                           Listed(wrong_places));
  }
  if (!wrong_compasses.empty()) {
    result.notes.push_back("compasses that disagree with their cameras are left out: " +
                           Listed(wrong_compasses));
  }
  const bool baseline = places >= 2;
  std::vector<std::string> north, scale;
  if (baseline) {
    north.push_back("GPS of " + Count(places, "photo", "photos"));
    scale.push_back(north.back());
  }
  if (compasses > 0) north.push_back(Count(compasses, "compass", "compasses"));
  if (given.heading) north.emplace_back("--heading");
  if (given.shadow) north.emplace_back("the shadow and the time");
  if (given.distance) scale.emplace_back("--scale-from");
  if (keeps) {
    north.emplace_back("the model's own frame, with which they agree");
    scale = north;
  }
  result.north_from = Listed(north);
  result.scale_from = Listed(scale);
  result.up_from = keeps         ? "the model's own frame"
                   : given.up    ? "--up"
                   : places >= 3 ? "cameras held level and GPS heights"
                                 : "cameras held level";

  if (given.shadow) {
    if (!problem.ShadowAzimuth(s.rotation)) {
      throw InputError(given.shadow->view +
                       ": foot or tip of --north-from-shadow is above the horizon, where "
                       "no ground is; give two pixels of a shadow on level ground, or "
                       "mend --up");
    }
    if (!baseline) {
      result.north_error_rad =
          std::hypot(result.north_error_rad, problem.ShadowClickError_rad(s.rotation));
    }
  }

  // What nothing tells
  constexpr double kUnknownNorth_rad = 25 * kRadPerDeg, kUnknownScale = 0.35;
  std::string missing;
  const bool has_places =
      std::any_of(problem.gps().begin(), problem.gps().end(), [](const auto& place) {
        return place.has_value();
      });
  const bool north_unknown = north.empty() || result.north_error_rad > kUnknownNorth_rad;
  const bool scale_unknown = scale.empty() || result.scale_error > kUnknownScale;
  if (!keeps && north_unknown) {
    missing += "\n  which way is north: ";
    if (given.shadow) {
      std::ostringstream within;
      within.precision(2);
      within << DegFromRad(result.north_error_rad);
      missing += "a pixel at foot or tip of the shadow turns it by " + within.str() +
                 " deg; give a longer shadow, or --heading VIEW=DEG";
    } else {
      missing += has_places
                     ? "no compass in the photos, and their places lie too close together"
                     : "no photo has a compass or a place";
      missing += "; give --heading VIEW=DEG, or --north-from-shadow VIEW x1,y1 x2,y2";
    }
  }
  if (!keeps && scale_unknown) {
    missing += "\n  how large it is: ";
    missing += has_places ? "the photos' places lie too close together for their error"
                          : "no photo has a place";
    missing +=
        "; give --scale-from VIEW VIEW LENGTH_m, the distance of two of the cameras";
  }
  if (!missing.empty()) {
    throw InputError("the cameras cannot be put on the Earth yet" + missing +
                     "\nor --keep-frame, when their world is east, north, up in metres");
  }
  return result;
}

CalibratedScene InWorld(const CalibratedScene& scene, const Georeference& georeference) {
  CalibratedScene result = scene;
  for (auto& [view, camera] : result.cameras) {
    const Eigen::Vector3d position = georeference.ToWorld(camera.PositionInWorld());
    const Eigen::Matrix3d rotation =
        camera.camera_from_world.linear() * georeference.rotation.transpose();
    camera.camera_from_world.linear() = rotation;
    camera.camera_from_world.translation() = -(rotation * position);
  }
  for (ScenePoint& point : result.points) {
    point.position = georeference.ToWorld(point.position);
  }
  result.enu_origin = georeference.origin;
  return result;
}

CalibratedScene MovedTo(const CalibratedScene& scene, const Eigen::Vector3d& point) {
  CalibratedScene result = scene;
  for (auto& [view, camera] : result.cameras) {
    camera.camera_from_world.translation() += camera.camera_from_world.linear() * point;
  }
  for (ScenePoint& p : result.points) p.position -= point;
  if (scene.enu_origin) {
    const GeographicLib::LocalCartesian frame(scene.enu_origin->latitude_deg,
                                              scene.enu_origin->longitude_deg,
                                              scene.enu_origin->altitude_m);
    Place& place = *result.enu_origin;
    frame.Reverse(point.x(),
                  point.y(),
                  point.z(),
                  place.latitude_deg,
                  place.longitude_deg,
                  place.altitude_m);
  }
  return result;
}

}  // namespace relight
