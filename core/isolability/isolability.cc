#include "core/isolability/isolability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/filter/prediction_model.h"
#include "core/isolability/fault_records.h"
#include "core/numerics/golden_section.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

/// Step of log(value) for derivatives: the effects are smooth, their relative rounding error is
/// 1e-12.
constexpr double kDerivativeStep = 1e-3;
/// Range of values as a factor of nominal: beyond it values have the same effect, or no such
/// component exists.
constexpr double kFactorMax = 1e3;
/// The same for a component with a least visible value, as a factor of that value: below it all
/// values have the same effect.
constexpr double kInvisibleFactor = 1e-4;
constexpr int kScanPoints = 40;
constexpr int kGoldenSteps = 24;
constexpr int kBisectionSteps = 40;

struct LogRange {
  double low;
  double high;
};

LogRange SearchRange(Component component, double nominal) {
  const double least = component.info().least_visible;
  if (least > 0.0) return {std::log(least * kInvisibleFactor), std::log(least * kFactorMax)};
  return {std::log(nominal / kFactorMax), std::log(nominal * kFactorMax)};
}

double NormalTail(double z) {
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

/// z with P(N > z) = tail, by bisection (it is called only twice).
double NormalQuantile(double tail) {
  double low = -40.0;
  double high = 40.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (NormalTail(middle) > tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// argmin of f over [low, high]: a scan, then golden section around its best point.
template <typename Function>
std::pair<double, double> Minimise(double low, double high, Function f) {
  const double step = (high - low) / (kScanPoints - 1);
  int best = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kScanPoints; ++i) {
    const double cost = f(low + i * step);
    if (cost < best_cost) {
      best_cost = cost;
      best = i;
    }
  }
  double best_at = low + best * step;
  const GoldenSection section = SearchGoldenSection(
      std::max(low, best_at - step), std::min(high, best_at + step), kGoldenSteps, f);
  if (section.best_cost() < best_cost) return {section.best(), section.best_cost()};
  return {best_at, best_cost};
}

void FillFisher(const FaultRecords& records, const IsolabilityOptions& options, Isolability& out) {
  const auto count = static_cast<std::size_t>(options.bench->component_count());
  std::vector<std::vector<double>> effect(count);
  out.fisher.resize(options.bench->component_count(), options.bench->component_count());
  out.overlap = out.fisher;
  for (Component component : options.bench->components()) {
    const double nominal = options.rig.plant.Get(component);
    const auto high =
        records.WhitenedWindow(records.healthy_record(),
                               records.ModelWith(component, nominal * std::exp(kDerivativeStep)));
    const auto low =
        records.WhitenedWindow(records.healthy_record(),
                               records.ModelWith(component, nominal * std::exp(-kDerivativeStep)));
    std::vector<double>& column = effect[static_cast<std::size_t>(Index(component))];
    column.resize(high.size());
    for (std::size_t i = 0; i < column.size(); ++i) {
      column[i] = (low[i] - high[i]) / (2.0 * kDerivativeStep);
    }
  }
  for (int i = 0; i < options.bench->component_count(); ++i) {
    for (int j = 0; j < options.bench->component_count(); ++j) {
      const auto& a = effect[static_cast<std::size_t>(i)];
      const auto& b = effect[static_cast<std::size_t>(j)];
      double sum = 0.0;
      for (std::size_t k = 0; k < a.size(); ++k) {
        sum += a[k] * b[k];
      }
      out.fisher(i, j) = sum;
    }
  }
  for (int i = 0; i < options.bench->component_count(); ++i) {
    for (int j = 0; j < options.bench->component_count(); ++j) {
      const double norm = std::sqrt(out.fisher(i, i) * out.fisher(j, j));
      out.overlap(i, j) = norm > 0.0 ? out.fisher(i, j) / norm : 0.0;
    }
  }
}

/// The visible value nearest to nominal, between nominal and `limit` (logarithms): the first one
/// that a scan outward finds, refined.
std::optional<double> NearestVisible(const FaultRecords& records,
                                     Component component,
                                     double nominal,
                                     double limit,
                                     double kl_visible) {
  const auto visible = [&](double log_value) {
    const PredictionModel faulty = records.ModelWith(component, std::exp(log_value));
    return records.Distance(records.MeanRecord(faulty), records.healthy()) >= kl_visible;
  };
  const double start = std::log(nominal);
  // Quadratic spacing: fine near nominal, where the answer lies for a sensitive component.
  double inside = start;
  for (int i = 1; i <= kScanPoints; ++i) {
    const double share = static_cast<double>(i) / kScanPoints;
    double outside = start + (limit - start) * share * share;
    if (!visible(outside)) {
      inside = outside;
      continue;
    }
    for (int n = 0; n < kBisectionSteps; ++n) {
      const double middle = 0.5 * (inside + outside);
      (visible(middle) ? outside : inside) = middle;
    }
    return std::exp(outside);
  }
  return std::nullopt;
}

void FillSmallest(const FaultRecords& records,
                  const IsolabilityOptions& options,
                  Isolability& out) {
  out.smallest.resize(static_cast<std::size_t>(options.bench->component_count()));
  for (Component component : options.bench->components()) {
    SmallestVisible& smallest = out.smallest[static_cast<std::size_t>(Index(component))];
    smallest.component = component;
    smallest.nominal = options.rig.plant.Get(component);
    const double information = out.fisher(Index(component), Index(component));
    smallest.relative_sigma = 1.0 / std::sqrt(information);
    const LogRange range = SearchRange(component, smallest.nominal);
    smallest.above =
        NearestVisible(records, component, smallest.nominal, range.high, out.kl_visible_nats);
    if (range.low < std::log(smallest.nominal)) {
      smallest.below =
          NearestVisible(records, component, smallest.nominal, range.low, out.kl_visible_nats);
    }
  }
}

FaultIsolability Judge(const FaultRecords& records,
                       const IsolabilityOptions& options,
                       const FaultSize& fault,
                       const Isolability& limits) {
  FaultIsolability judged;
  judged.fault = fault;
  const std::vector<Observation> record =
      records.MeanRecord(records.ModelWith(fault.component, fault.value));
  judged.kl_nominal_nats = records.Distance(record, records.healthy());
  judged.visible = judged.kl_nominal_nats >= limits.kl_visible_nats;
  judged.group.push_back(fault.component);
  judged.rival.resize(static_cast<std::size_t>(options.bench->component_count()));
  for (Component rival : options.bench->components()) {
    NearestRival& nearest = judged.rival[static_cast<std::size_t>(Index(rival))];
    if (rival == fault.component) {
      nearest = {rival, 0.0, fault.value};
      continue;
    }
    const LogRange range = SearchRange(rival, options.rig.plant.Get(rival));
    const auto [log_value, distance] = Minimise(range.low, range.high, [&](double at) {
      return records.Distance(record, records.ModelWith(rival, std::exp(at)));
    });
    nearest = {rival, distance, std::exp(log_value)};
    if (distance < limits.kl_separable_nats) {
      judged.group.push_back(rival);
    }
  }
  return judged;
}

void FillAmbiguous(const Bench& bench, Isolability& out) {
  const std::vector<Component> all = bench.components();
  const auto alike = [&](Component a, Component b) {
    const double cosine = out.overlap(Index(a), Index(b));
    return 1.0 - cosine * cosine < kSameEffect;
  };
  std::vector<bool> placed(all.size());
  for (Component first : all) {
    if (placed[static_cast<std::size_t>(Index(first))]) {
      continue;
    }
    std::vector<Component> group = {first};
    for (std::size_t i = 0; i < group.size(); ++i) {
      for (Component next : all) {
        const bool joined = std::find(group.begin(), group.end(), next) != group.end();
        if (!joined && alike(group[i], next)) {
          group.push_back(next);
        }
      }
    }
    for (Component member : group) {
      placed[static_cast<std::size_t>(Index(member))] = true;
    }
    if (group.size() > 1) {
      out.ambiguous.push_back(std::move(group));
    }
  }
}

Status Check(const IsolabilityOptions& options) {
  LAB_CHECK(options.bench != nullptr);
  if (options.window_samples < 1 ||
      options.uc_v.size() < static_cast<std::size_t>(options.window_samples) + kHistorySamplesMin) {
    return Refuse("window_wrong", "window_samples");
  }
  if (!std::all_of(
          options.uc_v.begin(), options.uc_v.end(), [](double u) { return std::isfinite(u); })) {
    return Refuse("voltages_wrong", "uc_v");
  }
  if (!(options.period_s > 0.0 && options.rig.delta_s > 0.0 &&
        options.rig.delta_s < options.period_s)) {
    return Refuse("delay_outside_period", "period_s");
  }
  if (!(options.false_alarms_per_day > 0.0)) {
    return Refuse("question_outside", "false_alarms_per_day");
  }
  if (!(options.detection_probability > 0.5 && options.detection_probability < 1.0)) {
    return Refuse("number_outside",
                  "detection_probability",
                  {{"member", "detection_probability"}, {"lowest", 0.5}, {"highest", 1}});
  }
  if (!(options.confusion_probability > 0.0 && options.confusion_probability < 0.5)) {
    return Refuse("number_outside",
                  "confusion_probability",
                  {{"member", "confusion_probability"}, {"lowest", 0}, {"highest", 0.5}});
  }
  for (std::size_t i = 0; i < options.faults.size(); ++i) {
    if (!(options.faults[i].value > 0.0) || !std::isfinite(options.faults[i].value)) {
      return Refuse("fault_value_not_positive", "faults");
    }
  }
  return Done{};
}

}  // namespace

std::vector<FaultSize> FaultsOf(const Bench& bench) {
  std::vector<FaultSize> faults;
  for (const Component component : bench.components()) {
    for (const double value : component.info().published) faults.push_back({component, value});
  }
  if (!faults.empty()) return faults;
  for (const Component component : bench.components()) {
    const ComponentInfo& info = component.info();
    for (std::size_t i = 1; i < info.positions.size(); ++i) {
      faults.push_back({component, info.positions[i].value});
    }
    for (const double value : info.offered) faults.push_back({component, value});
  }
  return faults;
}

Result<Isolability> AnalyseIsolability(const IsolabilityOptions& options) {
  if (Status checked = Check(options); !checked.ok()) {
    return checked.error();
  }
  Isolability out;
  constexpr double kSecondsPerDay = 86400.0;
  const double tests_per_day = kSecondsPerDay / options.period_s;
  const double threshold = NormalQuantile(0.5 * options.false_alarms_per_day / tests_per_day);
  const double visible = threshold + NormalQuantile(1.0 - options.detection_probability);
  out.kl_visible_nats = 0.5 * visible * visible;
  const double separable = 2.0 * NormalQuantile(options.confusion_probability);
  out.kl_separable_nats = 0.5 * separable * separable;

  const FaultRecords records(options);
  FillFisher(records, options, out);
  FillSmallest(records, options, out);
  const std::vector<FaultSize> faults =
      options.faults.empty() ? FaultsOf(*options.bench) : options.faults;
  for (const FaultSize& fault : faults) {
    out.faults.push_back(Judge(records, options, fault, out));
  }
  FillAmbiguous(*options.bench, out);
  return out;
}

}  // namespace faultlab::core
