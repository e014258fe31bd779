#include "core/paper/window_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace faultlab::core {
namespace {

std::vector<Spread> Spreads(std::span<const VariantEstimate> estimates, std::size_t parameters) {
  std::vector<Spread> spreads(parameters);
  for (std::size_t j = 0; j < parameters; ++j) {
    Spread& spread = spreads[j];
    double variance = 0.0;
    int count = 0;  // without those before the first estimate, behind a lost reading
    for (const VariantEstimate& estimate : estimates) {
      if (!std::isfinite(estimate.theta[j])) continue;
      spread.mean += estimate.theta[j];
      ++count;
    }
    spread.mean = count > 0 ? spread.mean / count : kAbsent;
    int reported = 0;
    for (const VariantEstimate& estimate : estimates) {
      const double deviation = estimate.theta[j] - spread.mean;
      if (std::isfinite(deviation)) spread.standard_deviation += deviation * deviation / count;
      if (std::isfinite(estimate.sigma[j])) {
        variance += estimate.sigma[j] * estimate.sigma[j];
        ++reported;
      }
    }
    spread.standard_deviation = std::sqrt(spread.standard_deviation);
    spread.reported_sigma = reported > 0 ? std::sqrt(variance / reported) : kAbsent;
  }
  return spreads;
}

std::span<const Sample> Between(std::span<const Sample> samples, std::size_t from, std::size_t to) {
  return samples.first(to).subspan(std::min(from, to));
}

std::vector<double> MeansOf(const std::vector<Spread>& spreads) {
  std::vector<double> means;
  for (const Spread& spread : spreads) means.push_back(spread.mean);
  return means;
}

/// Samples up to the last estimate that lies outside the range of the settled ones.
int SettlingSamples(std::span<const VariantEstimate> after_change,
                    std::size_t transient,
                    std::size_t parameters) {
  int settling = 0;
  for (std::size_t j = 0; j < parameters; ++j) {
    const auto less = [j](const auto& a, const auto& b) { return a.theta[j] < b.theta[j]; };
    const auto settled = after_change.subspan(transient);
    const auto [low, high] = std::minmax_element(settled.begin(), settled.end(), less);
    for (std::size_t k = 0; k < transient; ++k) {
      const double value = after_change[k].theta[j];
      if (!(value >= low->theta[j] && value <= high->theta[j])) {
        settling = std::max(settling, static_cast<int>(k) + 1);
      }
    }
  }
  return settling;
}

double UnexcitedShare(std::span<const VariantEstimate> estimates) {
  const auto unexcited = std::count_if(estimates.begin(), estimates.end(), [](const auto& one) {
    return one.status != EstimateStatus::kExcited;
  });
  return estimates.empty() ? 0.0
                           : static_cast<double>(unexcited) / static_cast<double>(estimates.size());
}

}  // namespace

int TransientSamples(const VariantSpec& spec) {
  return spec.window_samples + spec.order * std::max(1, spec.integral_samples) - 1;
}

bool DifferInOrderAlone(const VariantSpec& a, const VariantSpec& b) {
  return a.method == b.method && a.window_samples == b.window_samples &&
         a.integral_samples == b.integral_samples;
}

std::vector<VariantSpec> PaperVariants() {
  std::vector<VariantSpec> variants;
  for (const int window : {50, 100, 200}) {
    VariantSpec spec;
    spec.window_samples = window;
    variants.push_back(spec);
  }
  for (const auto& [window, integral] :
       {std::pair(20, 5), std::pair(100, 20), std::pair(500, 20)}) {
    VariantSpec spec;
    spec.method = EstimatorMethod::kSia;
    spec.window_samples = window;
    spec.integral_samples = integral;
    variants.push_back(spec);
  }
  return variants;
}

Result<std::vector<WindowStudyRow>> StudyWindows(std::span<const Sample> samples,
                                                 std::size_t start,
                                                 std::size_t change,
                                                 std::span<const VariantSpec> variants,
                                                 Curves curves) {
  if (change > samples.size() || start >= change) {
    return Error{
        ErrorCode::kInvalid, "The change must lie inside the record, after its start.", "change"};
  }
  std::vector<WindowStudyRow> rows;
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const auto refused = [i](Error error) {
      error.field = std::to_string(i) + "/" + error.field;
      return error;
    };
    const auto made = MakeVariant(variants[i]);
    if (!made) return refused(made.error());
    WindowStudyRow row;
    row.spec = variants[i];
    row.name = Name(variants[i]);
    row.parameters = ParameterNames(variants[i]);
    row.transient_samples = TransientSamples(variants[i]);
    std::size_t judged_from = 0;
    for (const VariantSpec& each : variants) {
      if (!DifferInOrderAlone(each, variants[i])) continue;
      judged_from = std::max(judged_from, static_cast<std::size_t>(TransientSamples(each)));
    }
    const auto transient = static_cast<std::size_t>(row.transient_samples);
    if (start + transient >= change ||
        (change < samples.size() && change + transient >= samples.size())) {
      return refused({ErrorCode::kInvalid,
                      row.name + " needs more samples on each side of the change.",
                      "window_samples"});
    }
    row.estimates.reserve(samples.size());
    row.estimates.resize(start);  // status invalid: before the start of the study
    for (const Sample& sample : samples.subspan(start)) {
      row.estimates.push_back(made.value()->Push(sample));
    }
    const std::span<const VariantEstimate> all(row.estimates);
    const auto before = all.subspan(start + transient, change - start - transient);
    row.before = Spreads(before, row.parameters.size());
    row.left_before =
        JudgeOrder(row.spec, MeansOf(row.before), Between(samples, start + judged_from, change));
    row.unexcited_share = UnexcitedShare(before);
    if (change < samples.size()) {
      const auto after = all.subspan(change + transient);
      row.after = Spreads(after, row.parameters.size());
      row.left_after = JudgeOrder(
          row.spec, MeansOf(row.after), Between(samples, change + judged_from, samples.size()));
      row.settling_samples = SettlingSamples(all.subspan(change), transient, row.parameters.size());
      row.unexcited_share = 0.5 * (row.unexcited_share + UnexcitedShare(after));
    }
    if (curves == Curves::kDropped) row.estimates = {};
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace faultlab::core
