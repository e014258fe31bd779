#include "server/methods/method_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/isolability/isolability.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/signals/random.h"
#include "core/types/time_span.h"
#include "server/methods/same_kind.h"

namespace faultlab::server {
namespace {

using core::Component;
using core::MethodInfo;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// At 100 Hz 20 s and a minute; at higher rates the same time (SpanOf).
constexpr std::size_t kRecordSamples = 2000;
constexpr std::size_t kHealthySamples = 6000;
std::size_t HealthySamples(const core::Bench& bench) {
  return core::SpanOf(kHealthySamples, bench.period_s);
}

core::ExcitationSpec WithSeed(core::ExcitationSpec spec, std::uint64_t seed) {
  if (auto* prbs = std::get_if<core::PrbsSpec>(&spec)) prbs->seed = seed;
  if (auto* multisine = std::get_if<core::MultisineSpec>(&spec)) multisine->seed = seed;
  return spec;
}

double HealthyTo(const core::Bench& bench) {
  return core::MethodOptionsOf(bench, bench.period_s).healthy_to_s;
}

bool Names(const core::MethodFinding& finding, const std::vector<Component>& same_kind) {
  if (finding.isolation != core::Answer::kGiven || finding.named == 0) return false;
  for (std::size_t i = 0; i < finding.named; ++i) {
    const Component named = finding.candidates[i].component;
    if (std::ranges::find(same_kind, named) == same_kind.end()) return false;
  }
  return true;
}

double ErrorOf(const core::MethodFinding& finding, const core::Fault& fault) {
  if (finding.identification != core::Answer::kGiven) return kNone;
  for (const core::MethodCandidate& candidate : finding.candidates) {
    if (!(candidate.component == fault.component)) continue;
    return std::abs(candidate.value - fault.value) / fault.value;
  }
  return kNone;
}

void Count(const MethodOutcome& outcome, bool faulty, MethodRow& row) {
  if (!outcome.refused.empty()) {
    ++row.refused;
    return;
  }
  row.false_alarms += outcome.false_alarm ? 1 : 0;
  row.watched_days += outcome.watched_s / 86400.0;
  row.bytes = std::max(row.bytes, outcome.bytes);
  if (!faulty) return;
  ++row.faulty;
  row.isolated.resize(core::kLookAfterS.size() + 1, 0);
  if (outcome.sample_us > 0.0) row.sample_us.push_back(outcome.sample_us);
  if (!outcome.detected) return;
  ++row.detected;
  row.delays.push_back(outcome.delay_samples);
  row.diagnosis_ms.push_back(outcome.diagnosis_ms);
  for (std::size_t i = 0; i < outcome.isolated.size(); ++i) {
    row.isolated[i] += outcome.isolated[i] ? 1 : 0;
  }
  if (outcome.isolated.back() && std::isfinite(outcome.error)) row.errors.push_back(outcome.error);
}

std::vector<const MethodInfo*> MethodsOf(const MethodStudyOptions& options) {
  std::vector<const MethodInfo*> chosen;
  for (const MethodInfo& info : core::AllMethods()) {
    const bool asked = options.methods.empty() ||
                       std::ranges::find(options.methods, info.name) != options.methods.end();
    if (asked) chosen.push_back(&info);
  }
  return chosen;
}

MethodStudy EmptyStudy(const MethodStudyOptions& options) {
  MethodStudy study;
  study.options = options;
  study.period_s = options.bench->period_s;
  for (const MethodInfo* info : MethodsOf(options)) {
    MethodRow row;
    row.info = info;
    row.fits = core::Fits(*info, *options.bench);
    row.isolated.resize(core::kLookAfterS.size() + 1, 0);
    study.rows.push_back(std::move(row));
  }
  return study;
}

/// What each method did with each of the faults.
void SumByFault(MethodStudy& study) {
  const std::size_t faults = study.faults.size();
  std::vector<std::vector<const MethodOutcome*>> of_fault(faults);
  for (const MethodOutcome& outcome : study.outcomes) {
    if (!outcome.fault) continue;
    const auto at = std::ranges::find_if(study.faults, [&](const core::FaultSize& fault) {
      return fault.component == outcome.fault->component && fault.value == outcome.fault->value;
    });
    of_fault[static_cast<std::size_t>(at - study.faults.begin())].push_back(&outcome);
  }
  study.records_of.assign(faults, 0);
  for (MethodRow& row : study.rows) {
    if (!row.fits) continue;
    for (std::size_t f = 0; f < faults; ++f) {
      MethodRow of;
      of.isolated.assign(core::kLookAfterS.size() + 1, 0);
      for (const MethodOutcome* outcome : of_fault[f]) {
        if (outcome->method == row.info->name) Count(*outcome, true, of);
      }
      study.records_of[f] = of.faulty;
      row.isolated_of.push_back(of.isolated.back());
      row.detected_of.push_back(of.detected);
      row.error_of.push_back(core::Quantile(of.errors, 0.5));
      row.delay_of.push_back(core::Quantile(of.delays, 0.5));
    }
  }
}

}  // namespace

core::MethodOptions TaskOptions(const MethodStudyOptions& options, double period_s) {
  core::MethodOptions task = core::MethodOptionsOf(*options.bench, period_s);
  if (options.channels) task.channels = *options.channels;
  return task;
}

MethodRecord SimulateMethodRecord(const core::Bench& bench,
                                  const core::FaultSize* fault,
                                  std::uint64_t seed,
                                  std::size_t samples) {
  core::Random random(core::StreamSeed(seed, 7));
  MethodRecord record;
  record.period_s = bench.period_s;
  const double duration_s = static_cast<double>(samples) * bench.period_s;
  if (fault != nullptr) {
    core::Fault injected;
    injected.component = fault->component;
    injected.value = fault->value;
    injected.at_s = duration_s * random.Uniform(0.4, 0.6);
    record.faults.push_back(injected);
  }
  const auto input = core::Generate(
      WithSeed(bench.excitation, 1 + random.Below(1000)), duration_s, bench.period_s);
  LAB_CHECK(input.ok(), bench.name);
  record.samples = core::SimulateRecord(
      bench.profiles.front(), bench.nominal, input.value(), record.faults, seed, bench.period_s);
  return record;
}

MethodOutcome TryMethod(const MethodInfo& info,
                        const core::MethodOptions& options,
                        const MethodRecord& record,
                        double tuning,
                        double level) {
  using Clock = std::chrono::steady_clock;
  MethodOutcome outcome;
  outcome.method = info.name;
  outcome.record = record.name;
  if (!record.faults.empty()) outcome.fault = record.faults.front();
  const core::Result<core::MethodTask> task = core::PrepareMethods(record.samples, options);
  if (!task) {
    outcome.refused = task.error().message;
    return outcome;
  }
  core::MethodSession session(info, task.value(), tuning, level);
  const double fault_s =
      record.faults.empty() ? std::numeric_limits<double>::infinity() : record.faults.front().at_s;
  core::MethodFinding finding;
  std::size_t looked = 0;
  Clock::duration pushing{};
  int pushed = 0;
  const auto look = [&] {
    const Clock::time_point begin = Clock::now();
    finding = session.Diagnose();
    outcome.diagnosis_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    outcome.isolated.push_back(Names(finding, record.same_kind));
  };
  Clock::time_point since = Clock::now();
  for (const core::Sample& sample : record.samples) {
    if (sample.t_s < options.healthy_to_s) continue;
    const bool alarm = session.Push(sample);
    ++pushed;
    if (sample.t_s < fault_s) outcome.watched_s += record.period_s;
    if (alarm) {
      outcome.alarmed_at_s = sample.t_s;
      if (sample.t_s < fault_s) {
        outcome.false_alarm = true;
        return outcome;
      }
      outcome.detected = true;
      outcome.delay_samples = 1.0 + std::floor((sample.t_s - fault_s) / record.period_s + 1e-6);
    }
    const bool due =
        session.alarmed() && looked < core::kLookAfterS.size() &&
        sample.t_s + 0.5 * record.period_s >= *session.alarmed_at_s() + core::kLookAfterS[looked];
    if (due) {
      pushing += Clock::now() - since;
      look();
      ++looked;
      since = Clock::now();
    }
  }
  pushing += Clock::now() - since;
  outcome.sample_us =
      std::chrono::duration<double, std::micro>(pushing).count() / std::max(pushed, 1);
  outcome.bytes = session.bytes();
  if (!outcome.detected) return outcome;
  while (looked++ < core::kLookAfterS.size()) outcome.isolated.push_back(false);
  look();
  outcome.error = ErrorOf(finding, record.faults.front());
  outcome.finding = std::move(finding);
  return outcome;
}

MethodStudy StudyMethods(const MethodStudyOptions& options, const Progress& progress) {
  const core::Bench& bench = *options.bench;
  const core::MethodOptions given = TaskOptions(options, bench.period_s);
  MethodStudy study = EmptyStudy(options);
  study.faults = core::FaultsOf(bench);
  const std::size_t faults = study.faults.size();
  const double healthy_s =
      static_cast<double>(HealthySamples(bench)) * bench.period_s - HealthyTo(bench);
  const auto healthy_records =
      static_cast<std::size_t>(std::ceil(options.healthy_hours * 3600.0 / healthy_s));
  const double all =
      static_cast<double>(faults * static_cast<std::size_t>(options.trials) + healthy_records);
  const auto same_kinds = SameKinds(bench, given.channels, study.faults);
  double done = 0.0;
  for (std::size_t f = 0; f < faults; ++f) {
    for (int trial = 0; trial < options.trials; ++trial) {
      const std::uint64_t seed = options.seed + 1000 * f + static_cast<std::uint64_t>(trial);
      MethodRecord record = SimulateMethodRecord(
          bench, &study.faults[f], seed, core::SpanOf(kRecordSamples, bench.period_s));
      record.same_kind = same_kinds[f];
      record.name = "seed " + std::to_string(seed);
      for (MethodRow& row : study.rows) {
        if (!row.fits) continue;
        MethodOutcome outcome = TryMethod(
            *row.info, given, record, row.info->tuning, row.info->LevelFor(given.channels));
        Count(outcome, true, row);
        study.outcomes.push_back(std::move(outcome));
      }
      if (!progress(++done / all)) return study;
    }
  }
  SumByFault(study);
  for (std::size_t h = 0; h < healthy_records; ++h) {
    const MethodRecord record =
        SimulateMethodRecord(bench, nullptr, options.seed + 100'000 + h, HealthySamples(bench));
    for (MethodRow& row : study.rows) {
      if (!row.fits) continue;
      const double level = row.info->LevelFor(given.channels);
      Count(TryMethod(*row.info, given, record, row.info->tuning, level), false, row);
    }
    if (!progress(++done / all)) return study;
  }
  return study;
}

MethodStudy StudyRecordings(const MethodStudyOptions& options,
                            const std::vector<MethodRecord>& records,
                            const Progress& progress) {
  MethodStudy study = EmptyStudy(options);
  study.recordings = static_cast<int>(records.size());
  std::vector<core::FaultSize> faults;
  for (const MethodRecord& record : records) {
    if (record.faults.empty()) continue;
    faults.push_back({record.faults.front().component, record.faults.front().value});
  }
  const core::Bench& bench = *options.bench;
  const auto same_kinds = SameKinds(bench, TaskOptions(options, bench.period_s).channels, faults);
  auto same_kind = same_kinds.begin();
  double done = 0.0;
  for (const MethodRecord& given : records) {
    MethodRecord record = given;
    if (!record.faults.empty()) record.same_kind = *same_kind++;
    const core::MethodOptions task = TaskOptions(options, record.period_s);
    for (MethodRow& row : study.rows) {
      if (!row.fits) continue;
      const double level = row.info->LevelFor(task.channels);
      MethodOutcome outcome = TryMethod(*row.info, task, record, row.info->tuning, level);
      Count(outcome, !record.faults.empty(), row);
      study.outcomes.push_back(std::move(outcome));
    }
    if (!progress(++done / static_cast<double>(records.size()))) break;
  }
  for (const core::FaultSize& fault : faults) {
    const bool known = std::ranges::any_of(study.faults, [&](const core::FaultSize& each) {
      return each.component == fault.component && each.value == fault.value;
    });
    if (!known) study.faults.push_back(fault);
  }
  SumByFault(study);
  return study;
}

}  // namespace faultlab::server
