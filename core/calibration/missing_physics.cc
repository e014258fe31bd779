#include "core/calibration/missing_physics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {

constexpr double kDifference = 1e-4;
// More tell nothing new of physics that is there all the time.
constexpr std::size_t kSamplesMax = 30'000;

/// What a term adds to the equations of the motor.
struct Addition {
  double drop_v = 0.0;     ///< lost between the output and the motor
  double torque_nm = 0.0;  ///< brakes, if it has the sign of the speed
  bool in_output = false;  ///< the drop is before the terminal at which um is read
};

/// One state of the motor, and the largest of the stretch.
struct Motion {
  double i = 0.0;
  double w = 0.0;
  double i_max = 0.0;
  double w_max = 0.0;
};

// Typical sizes: of small motors with carbon brushes, their data sheets and publications.
constexpr int kTerms = 6;
// The noise and the rest of the fit have adapted themselves to a term that is there: about half of
// it shows (real_motor_study).
constexpr double kHidden = 4.0;
Addition TermOf(int term, const RigParameters& rig, const Motion& m) {
  const PlantParameters& p = rig.plant;
  const double i_share = m.i / m.i_max;
  const double w_share = m.w / m.w_max;
  const double mc_nm = std::max(rig.mc_nm, 0.1 * p.kt_nm_per_a * m.i_max);
  const double way = std::clamp(20.0 * w_share, -1.0, 1.0);
  switch (term) {
    case 0:  // the drop of the brushes
      return {.drop_v = 0.06 * (p.ra_ohm * m.i_max + p.ke_v_per_rad_s * m.w_max) *
                        std::tanh(20.0 * i_share)};
    case 1:  // their resistance, which falls with the current
      return {.drop_v = 0.3 * p.ra_ohm * m.i / (1.0 + std::abs(i_share) / 0.3)};
    case 2:  // and rises with the speed
      return {.drop_v = 0.2 * p.ra_ohm * m.i * std::abs(w_share)};
    case 3:  // an output that gives way
      return {.drop_v = 0.2 * p.ra_ohm * m.i_max *
                        std::copysign(std::max(0.0, std::abs(i_share) - 0.5), m.i),
              .in_output = true};
    case 4:  // air
      return {.torque_nm = 0.3 * mc_nm * w_share * std::abs(w_share)};
    default:  // friction that falls with the speed
      return {.torque_nm = 0.5 * mc_nm * way * std::exp(-10.0 * std::abs(w_share))};
  }
}

/// The motion of the model under the inputs of the stretch.
std::vector<Eigen::Vector4d> MotionOf(const PredictionModel& model,
                                      std::span<const Observation> stretch) {
  std::vector<Eigen::Vector4d> states;
  states.reserve(stretch.size());
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  FrictionStep friction;
  for (const Observation& o : stretch) {
    const double u = model.Limited(o.u);
    x = o.restart || states.empty()
            ? TurningState(model, o.u)
            : Eigen::Vector4d(Step(model, x, model.Limited(o.u_prev), u, friction));
    states.push_back(x);
  }
  return states;
}

/// The stretch as it would be read with the term.
std::vector<Observation> WithTerm(int term,
                                  const RigParameters& rig,
                                  const PredictionModel& model,
                                  const std::vector<Eigen::Vector4d>& states,
                                  std::span<const Observation> stretch) {
  Motion m;
  for (const Eigen::Vector4d& x : states) {
    m.i_max = std::max(m.i_max, std::abs(x(1)));
    m.w_max = std::max(m.w_max, std::abs(x(2)));
  }
  std::vector<Observation> moved(stretch.begin(), stretch.end());
  if (!(m.i_max > 0.0 && m.w_max > 0.0)) return moved;
  const double k = rig.gain();
  Eigen::Vector4d off = Eigen::Vector4d::Zero();
  Addition before;
  for (std::size_t at = 0; at < states.size(); ++at) {
    m.i = states[at](1);
    m.w = states[at](2);
    const Addition now = TermOf(term, rig, m);
    if (stretch[at].restart || at == 0) before = now;
    // The mean over the period; a voltage acts as that much less of the input.
    const double drop_v = 0.5 * (before.drop_v + now.drop_v);
    const double torque_nm = 0.5 * (before.torque_nm + now.torque_nm);
    off(0) = 0.0;
    off = model.phi * off - (model.g_prev + model.g) * (drop_v / k) + model.g_torque * torque_nm;
    off(0) = 0.0;
    moved[at].y[0] += model.c(0, 1) * off(1) - (now.in_output ? now.drop_v : 0.0);
    moved[at].y[1] += off(1);
    moved[at].y[2] += off(2);
    before = now;
  }
  return moved;
}

/// The stretch as it would be read by a channel whose scale is off: of um, ia or n.
std::vector<Observation> WithScale(std::size_t channel,
                                   double factor,
                                   std::span<const Observation> stretch) {
  std::vector<Observation> scaled(stretch.begin(), stretch.end());
  for (Observation& o : scaled) o.y[channel] *= factor;
  return scaled;
}

Eigen::VectorXd Whitened(const PredictionModel& model, std::span<const Observation> stretch) {
  InnovationTrace trace;
  RunInnovations(model, stretch, &trace);
  return Eigen::Map<const Eigen::VectorXd>(trace.whitened.data(),
                                           static_cast<Eigen::Index>(trace.whitened.size()));
}

}  // namespace

Eigen::MatrixXd MissingPhysics(const HealthyStretch& stretch,
                               const RigParameters& base,
                               const MapFit& fit,
                               const NoiseLevel& noise) {
  const std::span<const Observation> samples =
      stretch.samples.first(std::min(stretch.samples.size(), kSamplesMax));
  // Where no voltage is read, all parameters may be scaled alike: of the noise, too, that must
  // change nothing.
  const RigParameters rig = RigAt(stretch, base, fit.point);
  const auto modelled = [&](const Eigen::VectorXd& point) {
    const RigParameters at = RigAt(stretch, base, point);
    NoiseLevel level = noise;
    if (stretch.bench->fits_follow_noise) level.friction_nm *= at.j_factor / rig.j_factor;
    return MakePredictionModel(at, level, stretch.period_s);
  };
  const PredictionModel model = modelled(fit.point);
  const Eigen::VectorXd z = Whitened(model, samples);
  const std::vector<Eigen::Vector4d> states = MotionOf(model, samples);
  const std::array<double, 3> scales = {
      stretch.bench->um.gain_sd, stretch.bench->ia.gain_sd, stretch.bench->n.gain_sd};
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(z.size(), kTerms + static_cast<int>(scales.size()));
  for (int term = 0; term < kTerms; ++term) {
    terms.col(term) = Whitened(model, WithTerm(term, rig, model, states, samples)) - z;
  }
  for (std::size_t c = 0; c < scales.size(); ++c) {
    if (scales[c] == 0.0) continue;
    terms.col(kTerms + static_cast<int>(c)) =
        Whitened(model, WithScale(c, 1.0 + scales[c], samples)) - z;
  }
  const Eigen::Index all = fit.point.size();
  Eigen::MatrixXd sensitivities(z.size(), all);
  for (Eigen::Index q = 0; q < all; ++q) {
    Eigen::VectorXd moved = fit.point;
    moved(q) += kDifference;
    sensitivities.col(q) = (Whitened(modelled(moved), samples) - z) / kDifference;
  }
  const Eigen::MatrixXd prior = InverseOfSymmetric(fit.covariance) - fit.information;
  const Eigen::MatrixXd right = sensitivities.transpose() * terms;
  const Eigen::MatrixXd shift =
      -SolveSymmetric(sensitivities.transpose() * sensitivities + prior, right);
  const Eigen::MatrixXd left = terms + sensitivities * shift;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(all, all);
  for (Eigen::Index term = 0; term < terms.cols(); ++term) {
    const double information = left.col(term).squaredNorm() + 1.0;
    const double size = left.col(term).dot(z) / information;
    covariance += std::min(1.0, kHidden * size * size + 1.0 / information) * shift.col(term) *
                  shift.col(term).transpose();
  }
  const auto n = all - static_cast<Eigen::Index>(stretch.zeros.size());
  return covariance.topLeftCorner(n, n);
}

}  // namespace faultlab::core
