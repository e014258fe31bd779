#include "core/isolability/fault_records.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/filter/innovation_filter.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Samples at 100 Hz (SpanOf) before the fault, in which the effect of the unknown initial state on
// the filter dies out: three of the slowest time constants of a healthy rig and of its friction.
constexpr std::size_t kHistorySamples = 150;

// The channels that the options ask for and that the bench measures.
std::uint8_t MaskOf(const IsolabilityOptions& options) {
  const Bench& bench = *options.bench;
  const bool all = options.channels == Channels::kAll;
  return static_cast<std::uint8_t>((bench.um.exists ? 1U : 0U) |
                                   (all && bench.ia.exists ? 2U : 0U) |
                                   (all && bench.estimates_use_n() ? 4U : 0U));
}

// Where a healthy rig turning forward settles under constant input, by running it there: on the
// published bench the spectral radius is below 0.9, so a thousand steps leave 1e-46; a heavier
// motor takes more.
Eigen::Vector4d RestState(const PredictionModel& model, double uc_v, double period_s) {
  constexpr std::size_t kSettlingSteps = 1000;
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  constexpr std::size_t kStepsMax = 1'000'000;
  constexpr double kSettledShare = 1e-9;
  const std::size_t steps = SpanOf(kSettlingSteps, period_s);
  const double u = model.Limited(uc_v);
  bool moves = true;
  for (std::size_t k = 0; k < steps || (moves && k < kStepsMax); ++k) {
    const Eigen::Vector4d next = Step(model, x, u, u);
    moves = (next - x).norm() > kSettledShare * next.norm();
    x = next;
  }
  return x;
}

}  // namespace

FaultRecords::FaultRecords(const IsolabilityOptions& options, History past)
    : options_(options), mask_(MaskOf(options)) {
  const int samples = static_cast<int>(options.uc_v.size());
  const int wanted = static_cast<int>(SpanOf(kHistorySamples, options.period_s));
  const int before = samples - options.window_samples;
  const int history = past == History::kAll ? before : std::min(wanted, before);
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
    observation.mask = mask_;
    observation.restart = k == 0;
    const double u = now.Limited(observation.u);
    if (k == 0) {
      x = RestState(now, observation.u, options_.period_s);
    } else {
      const Eigen::Vector4d next = Step(now, x, now.Limited(observation.u_prev), u);
      x = next;
    }
    const Eigen::Vector3d y = now.c * x + now.d * u;
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
