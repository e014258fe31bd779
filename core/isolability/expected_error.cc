#include "core/isolability/expected_error.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "core/filter/innovation_filter.h"
#include "core/filter/prediction_model.h"
#include "core/isolability/fault_records.h"
#include "core/isolability/isolability.h"
#include "core/numerics/linear_systems.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

/// Step of a derivative; the coordinates are logarithms or have unit scales of order one.
constexpr double kStep = 1e-3;

/// A property of the rig that is not known exactly.
struct Uncertain {
  double sigma = 0.0;
  std::function<void(RigParameters& rig, double offset)> move;
};

Uncertain PartOf(int part, double sigma) {
  return {sigma, [part](RigParameters& rig, double offset) {
            rig.plant.amplifier[static_cast<std::size_t>(part)] *= std::exp(offset);
          }};
}

Uncertain CoordinateOf(int coordinate, double sigma, double period_s) {
  return {sigma, [coordinate, period_s](RigParameters& rig, double offset) {
            ParameterOffsets q{};
            q[static_cast<std::size_t>(coordinate)] = offset;
            rig = WithOffsets(rig, q, period_s);
          }};
}

struct Unknowns {
  std::vector<Uncertain> learned;    ///< by a diagnosis
  std::vector<Uncertain> unlearned;  ///< one of several parts is off, and it is unknown which
};

Unknowns UnknownsOf(const IsolabilityOptions& options, const ParameterOffsets& tolerance) {
  Unknowns unknowns;
  const PlantParameters& plant = options.rig.plant;
  const double gain_sigma = tolerance[static_cast<std::size_t>(Coordinate::kGain)];
  for (int i = 0; i < plant.structure->parameter_count() - kMotorParameters; ++i) {
    if (gain_sigma > 0.0 && plant.structure->slope(plant.amplifier, i).gain != 0.0) {
      unknowns.unlearned.push_back(PartOf(i, gain_sigma));
    }
  }
  // A part that alone is the gain is learned with it.
  const bool one_part = unknowns.unlearned.size() == 1;
  if (one_part) unknowns.learned.swap(unknowns.unlearned);
  for (int i = 0; i < kCoordinateMax; ++i) {
    const double sigma = tolerance[static_cast<std::size_t>(i)];
    const bool none = i == static_cast<int>(Coordinate::kSeries) && plant.series_ohm == 0.0;
    const bool known = i == static_cast<int>(Coordinate::kGain) && one_part;
    if (sigma > 0.0 && !none && !known) {
      unknowns.learned.push_back(CoordinateOf(i, sigma, options.period_s));
    }
  }
  return unknowns;
}

/// The record of one fault, and the errors of the filter on it when the rig is slightly different.
class FaultErrors {
 public:
  FaultErrors(const IsolabilityOptions& options, const FaultRecords& records, FaultSize fault)
      : options_(options),
        fault_(fault),
        onset_(records.onset()),
        record_(records.MeanRecord(records.ModelWith(fault.component, fault.value))) {}

  /// d(whitened errors)/d(log of the fault's value).
  Eigen::VectorXd ByValue() const {
    return Slope([](RigParameters&, double) {}, 1.0);
  }
  Eigen::VectorXd By(const Uncertain& uncertain) const { return Slope(uncertain.move, 0.0); }

 private:
  template <typename Move>
  Eigen::VectorXd Slope(const Move& move, double by_value) const {
    return (Errors(move, kStep, by_value) - Errors(move, -kStep, by_value)) / (2.0 * kStep);
  }

  template <typename Move>
  Eigen::VectorXd Errors(const Move& move, double step, double by_value) const {
    RigParameters rig = options_.rig;
    move(rig, step);
    const PredictionModel healthy = ModelOf(rig);
    rig.plant.Set(fault_.component, fault_.value * std::exp(by_value * step));
    const PredictionModel faulty = ModelOf(rig);
    const std::array<ModelSegment, 2> path = {ModelSegment{0, &healthy},
                                              ModelSegment{onset_, &faulty}};
    InnovationTrace trace;
    RunInnovations(path, record_, &trace);
    return Eigen::Map<const Eigen::VectorXd>(trace.whitened.data(),
                                             static_cast<Eigen::Index>(trace.whitened.size()));
  }

  PredictionModel ModelOf(const RigParameters& rig) const {
    return MakePredictionModel(rig, options_.noise, options_.period_s);
  }

  const IsolabilityOptions& options_;
  FaultSize fault_;
  std::size_t onset_;
  std::vector<Observation> record_;
};

Eigen::MatrixXd Columns(const FaultErrors& errors, const std::vector<Uncertain>& by) {
  Eigen::MatrixXd columns;
  for (std::size_t i = 0; i < by.size(); ++i) {
    const Eigen::VectorXd column = errors.By(by[i]);
    if (i == 0) columns.resize(column.size(), static_cast<Eigen::Index>(by.size()));
    columns.col(static_cast<Eigen::Index>(i)) = column;
  }
  return columns;
}

Eigen::VectorXd SigmasOf(const std::vector<Uncertain>& all) {
  Eigen::VectorXd sigmas(static_cast<Eigen::Index>(all.size()));
  for (Eigen::Index i = 0; i < sigmas.size(); ++i) {
    sigmas(i) = all[static_cast<std::size_t>(i)].sigma;
  }
  return sigmas;
}

/// The derivatives of one fault's record, and the errors that follow from its first rows.
class FaultInformation {
 public:
  FaultInformation(const FaultErrors& errors, const Unknowns& unknowns)
      : unlearned_(Columns(errors, unknowns.unlearned)),
        prior_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns.learned.size()) + 1)),
        offsets_(SigmasOf(unknowns.unlearned)) {
    const Eigen::VectorXd by_value = errors.ByValue();
    learned_.resize(by_value.size(), prior_.size());
    learned_.col(0) = by_value;
    if (unknowns.learned.empty()) return;
    learned_.rightCols(prior_.size() - 1) = Columns(errors, unknowns.learned);
    prior_.tail(prior_.size() - 1) = SigmasOf(unknowns.learned).cwiseAbs2().cwiseInverse();
  }

  double Sigma(Eigen::Index rows) const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const auto seen = learned_.topRows(rows);
    Eigen::MatrixXd information = seen.transpose() * seen;
    information.diagonal() += prior_;
    if (!(information(0, 0) > 0.0)) return kNone;
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(information.rows(), 0);
    const Eigen::VectorXd row = SolveSymmetric(information, unit);
    double variance = row(0);
    if (offsets_.size() > 0) {
      const Eigen::VectorXd gains = unlearned_.topRows(rows).transpose() * (seen * row);
      variance += gains.cwiseProduct(offsets_).squaredNorm();
    }
    return variance > 0.0 && std::isfinite(variance) ? std::sqrt(variance) : kNone;
  }

 private:
  Eigen::MatrixXd learned_;    ///< the first column by log(value)
  Eigen::MatrixXd unlearned_;  ///< empty when there are none
  Eigen::VectorXd prior_;      ///< information; none of the value
  Eigen::VectorXd offsets_;    ///< of the unlearned
};

}  // namespace

std::vector<ExpectedError> ExpectedErrors(const IsolabilityOptions& options,
                                          const ParameterOffsets& tolerance,
                                          std::span<const int> windows) {
  for (const int window : windows) LAB_CHECK(window > 0 && window <= options.window_samples);
  const FaultRecords records(options, FaultRecords::History::kAll);
  const Unknowns unknowns = UnknownsOf(options, tolerance);
  std::vector<ExpectedError> out;
  for (const FaultSize& fault :
       options.faults.empty() ? FaultsOf(*options.bench) : options.faults) {
    const FaultInformation information(FaultErrors(options, records, fault), unknowns);
    ExpectedError& expected = out.emplace_back();
    expected.fault = fault;
    for (const int window : windows) {
      const std::size_t samples = records.onset() + static_cast<std::size_t>(window);
      expected.relative_sigma.push_back(
          information.Sigma(static_cast<Eigen::Index>(samples * kOutputCount)));
    }
  }
  return out;
}

}  // namespace faultlab::core
