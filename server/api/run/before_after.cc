#include "server/api/run/before_after.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/coefficients.h"
#include "server/plots/figures.h"

namespace faultlab::server {
namespace {

constexpr std::array<core::EstimatorId, 2> kEstimatorsShown = {core::EstimatorId::kSwa100,
                                                               core::EstimatorId::kSia100x20};
constexpr std::array<std::string_view, 3> kNames = {"b0", "b1", "a1"};

const core::EstimatorShape& ShapeOf(core::EstimatorId id) {
  return core::kEstimatorShapes[static_cast<std::size_t>(id)];
}

bool IsSwa(const core::EstimatorShape& shape) {
  return shape.integral_samples == 0;
}

/// The mean of each parameter over the samples of a stretch.
class Means {
 public:
  Means(const Stretch& stretch, double period_s)
      : from_(IndexAt(stretch.from_s, period_s)), to_(IndexAt(stretch.to_s, period_s)) {}

  void Add(std::int64_t index, const core::Estimate<3>& made) {
    const core::Estimate<3> estimate = core::Shown(made);
    const bool told = estimate.status == core::EstimateStatus::kExcited ||
                      estimate.status == core::EstimateStatus::kWeak;
    if (index < from_ || index >= to_ || !told) return;
    for (std::size_t p = 0; p < kNames.size(); ++p) {
      if (!std::isfinite(estimate.theta[p])) continue;
      sums_[p] += estimate.theta[p];
      ++counts_[p];
    }
  }

  std::optional<double> Of(std::size_t parameter) const {
    const int count = counts_[parameter];
    return count > 0 ? std::optional(sums_[parameter] / count) : std::nullopt;
  }

 private:
  static std::int64_t IndexAt(double t_s, double period_s) {
    constexpr double kSlack = 1e-9;
    return static_cast<std::int64_t>(std::ceil(t_s / period_s - kSlack));
  }

  std::int64_t from_;
  std::int64_t to_;
  std::array<double, kNames.size()> sums_{};
  std::array<int, kNames.size()> counts_{};
};

struct Around {
  Means before;
  Means after;
};

/// b0d, b1d, a1d and b0, b1, a1 of the model of the bench with this value, sampled with the delay
/// that was found: as `GET /benches/{bench}/model` has it.
std::optional<std::array<core::ContinuousTheta, 2>> ModelOf(const Review& review,
                                                            core::Component component,
                                                            double value) {
  if (!std::isfinite(value) || value <= 0.0) return std::nullopt;
  const core::DiagnosisOptions& options = review.recording.options;
  const auto& calibration = review.diagnosis.calibration;
  const double delta_s =
      calibration ? calibration->delta_s : std::min(options.bench->delta_s, options.period_s);
  if (!(delta_s >= 0.0 && delta_s <= options.period_s)) return std::nullopt;
  core::PlantParameters plant = options.bench->nominal;
  plant.Set(component, value);
  const core::ContinuousCoefficients continuous = core::MakeContinuous(plant);
  const core::DiscreteCoefficients discrete =
      core::Discretise(continuous, options.period_s, delta_s);
  return std::array<core::ContinuousTheta, 2>{
      core::ContinuousTheta{discrete.b0d, discrete.b1d, discrete.a1d},
      core::ContinuousTheta{continuous.b0, continuous.b1, continuous.a1}};
}

const core::PublishedFault* PublishedOf(const core::Bench& bench,
                                        core::Component component,
                                        double value) {
  constexpr double kRelative = 1e-6;  // of numbers that went through JSON
  for (const core::PublishedFault& fault : bench.published.faults) {
    if (fault.component == core::Name(component) &&
        std::abs(fault.value - value) <= kRelative * value) {
      return &fault;
    }
  }
  return nullptr;
}

/// The newest change of a record whose rig reported none: as the diagnosis estimates it.
ReportChange Diagnosed(const Review& review, std::span<const double> times) {
  ReportChange change;
  if (times.empty()) return change;
  change.t_s = times.back();
  const core::Verdict& verdict = review.diagnosis.verdict;
  const bool sized = verdict.kind == core::VerdictKind::kFault && !verdict.candidates.empty() &&
                     verdict.candidates.front().bound == 0;
  if (!sized) return change;
  change.component = verdict.candidates.front().component;
  change.value = verdict.candidates.front().value;
  return change;
}

std::vector<ReportChange> NewestChanges(const Review& review,
                                        std::span<const double> times,
                                        std::size_t most) {
  const std::span<const RigChange> changes = review.story.changes;
  if (changes.empty()) return {Diagnosed(review, times)};
  std::vector<ReportChange> out;
  for (const RigChange& one : changes.last(std::min(most, changes.size()))) {
    out.push_back({.t_s = one.at_s,
                   .component = one.component,
                   .before = one.before,
                   .value = one.value,
                   .others = one.others,
                   .estimates = {}});
  }
  return out;
}

void FillEstimates(const Review& review, std::span<const Around> around, ReportChange& change) {
  const bool alone = change.component.exists() && change.others.empty();
  const auto model = alone ? ModelOf(review, change.component, change.value) : std::nullopt;
  const core::PublishedFault* published =
      alone ? PublishedOf(*review.recording.options.bench, change.component, change.value)
            : nullptr;
  for (std::size_t i = 0; i < kEstimatorsShown.size(); ++i) {
    const core::EstimatorShape& shape = ShapeOf(kEstimatorsShown[i]);
    const bool swa = IsSwa(shape);
    ReportEstimates one;
    one.title =
        (swa ? "SWA, " : "SIA, ") + WindowName(shape.window_samples, shape.integral_samples);
    for (std::size_t p = 0; p < kNames.size(); ++p) {
      ReportEstimates::Row row;
      row.name = std::string(kNames[p]) + (swa ? "d" : "");
      row.before = around[i].before.Of(p);
      row.after = around[i].after.Of(p);
      if (model) row.model = (*model)[swa ? 0 : 1][p];
      if (published != nullptr) row.published = (swa ? published->swa : published->sia)[p];
      one.rows.push_back(std::move(row));
    }
    change.estimates.push_back(std::move(one));
  }
}

}  // namespace

Stretches StretchesAround(std::optional<double> at_s,
                          std::span<const double> changes,
                          double end_s,
                          const core::EstimatorShape& shape,
                          double period_s) {
  constexpr double kBeforeS = 5.0;
  constexpr double kBeforeSamples = 100.0;
  constexpr double kStartS = 0.5;  // the rig itself settles
  double from_s = 0.0;
  double to_s = end_s;
  if (at_s) {
    for (const double each : changes) {
      if (each < *at_s) from_s = std::max(from_s, each);
      if (each > *at_s) to_s = std::min(to_s, each);
    }
  }
  const double settles_s = (shape.window_samples + shape.integral_samples - 1) * period_s;
  const double lead_s = from_s == 0.0 ? kStartS : period_s;
  Stretches out;
  out.before.to_s = at_s.value_or(to_s);
  out.before.from_s = std::max(from_s + settles_s + lead_s,
                               out.before.to_s - std::max(kBeforeS, kBeforeSamples * period_s));
  out.after.to_s = to_s;
  out.after.from_s = at_s ? *at_s + settles_s + period_s : to_s;
  return out;
}

std::vector<ReportChange> EstimatesAround(const Review& review, std::size_t most) {
  const core::DiagnosisOptions& options = review.recording.options;
  const std::vector<core::Sample>& samples = review.recording.samples;
  const std::vector<double> times = review.story.ChangeTimes();
  const double end_s =
      samples.empty() ? 0.0 : static_cast<double>(samples.back().index + 1) * options.period_s;
  std::vector<ReportChange> out = NewestChanges(review, times, most);
  std::vector<std::vector<Around>> around;
  for (const ReportChange& change : out) {
    std::vector<Around>& of_change = around.emplace_back();
    for (const core::EstimatorId id : kEstimatorsShown) {
      const Stretches stretches =
          StretchesAround(change.t_s, times, end_s, ShapeOf(id), options.period_s);
      of_change.push_back(
          {{stretches.before, options.period_s}, {stretches.after, options.period_s}});
    }
  }
  core::ReplayEstimates(samples, options, [&](const core::Frame& frame) {
    for (std::vector<Around>& of_change : around) {
      for (std::size_t i = 0; i < kEstimatorsShown.size(); ++i) {
        const auto& estimate = frame.estimates[static_cast<std::size_t>(kEstimatorsShown[i])];
        of_change[i].before.Add(frame.sample.index, estimate);
        of_change[i].after.Add(frame.sample.index, estimate);
      }
    }
  });
  for (std::size_t i = 0; i < out.size(); ++i) FillEstimates(review, around[i], out[i]);
  return out;
}

}  // namespace faultlab::server
