#include "core/isolability/fault_records.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

// Samples before the fault in which the filter forgets that it did not know the state; three of
// the slowest time constants of a healthy rig and of its friction.
constexpr int kHistorySamples = 150;

// Where a healthy rig turning forward settles under constant input, by running it there: the
// spectral radius is below 0.9, so a thousand steps leave 1e-46.
Eigen::Vector4d RestState(const PredictionModel& model, double uc_v) {
  constexpr int kSettlingSteps = 1000;
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  for (int k = 0; k < kSettlingSteps; ++k) {
    const Eigen::Vector4d next = Step(model, x, uc_v, uc_v);
    x = next;
  }
  return x;
}

}  // namespace

FaultRecords::FaultRecords(const IsolabilityOptions& options) : options_(options) {
  const int samples = static_cast<int>(options.uc_v.size());
  const int history = std::min(kHistorySamples, samples - options.window_samples);
  onset_ = static_cast<std::size_t>(history);
  uc_v_ = std::span(options.uc_v).last(static_cast<std::size_t>(history + options.window_samples));
  healthy_ = ModelOf(options.rig);
  healthy_record_ = MeanRecord(healthy_);
}

PredictionModel FaultRecords::ModelWith(Component component, double value) const {
  RigParameters rig = options_.rig;
  rig.plant.Set(component, value);
  return ModelOf(rig);
}

std::vector<Observation> FaultRecords::MeanRecord(const PredictionModel& model) const {
  std::vector<Observation> record(uc_v_.size());
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  for (std::size_t k = 0; k < record.size(); ++k) {
    const PredictionModel& now = k < onset_ ? healthy_ : model;
    Observation& observation = record[k];
    observation.u = uc_v_[k];
    observation.u_prev = k > 0 ? uc_v_[k - 1] : uc_v_[k];
    observation.mask = options_.channels == Channels::kUmOnly ? 1 : (1U << kOutputCount) - 1;
    observation.restart = k == 0;
    if (k == 0) {
      x = RestState(now, observation.u);
    } else {
      const Eigen::Vector4d next = Step(now, x, observation.u_prev, observation.u);
      x = next;
    }
    const Eigen::Vector3d y = now.c * x + now.d * observation.u;
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      observation.y[c] = y(static_cast<Eigen::Index>(c));
    }
  }
  return record;
}

double FaultRecords::Distance(const std::vector<Observation>& record,
                              const PredictionModel& model) const {
  double sum = 0.0;
  for (double z : WhitenedWindow(record, model)) {
    sum += z * z;
  }
  return 0.5 * sum;
}

std::vector<double> FaultRecords::WhitenedWindow(const std::vector<Observation>& record,
                                                 const PredictionModel& model) const {
  const std::array<ModelSegment, 2> segments = {ModelSegment{0, &healthy_},
                                                ModelSegment{onset_, &model}};
  InnovationTrace trace;
  RunInnovations(segments, record, &trace);
  trace.whitened.erase(trace.whitened.begin(),
                       trace.whitened.begin() + static_cast<std::ptrdiff_t>(onset_ * kOutputCount));
  return std::move(trace.whitened);
}

PredictionModel FaultRecords::ModelOf(const RigParameters& rig) const {
  return MakePredictionModel(rig, options_.noise, options_.period_s);
}

}  // namespace faultlab::core
