// method_tunings [METHOD ..]: finds the tuning and the alarm level of each method of the literature
// on the paper's bench by the rule of core/methods/README.md, and prints the lines of
// core/methods/method_tunings.h.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/isolability/isolability.h"
#include "core/methods/method_session.h"
#include "core/numerics/statistics.h"
#include "core/types/number_text.h"
#include "core/types/time_span.h"
#include "hardware/bench/benches.h"
#include "server/methods/method_study.h"
#include "server/methods/same_kind.h"

namespace faultlab::server {
namespace {

using core::MethodInfo;

/// Of no figure.
constexpr std::uint64_t kTuningSeed = 500'000;
constexpr std::size_t kHealthyRecords = 120;
constexpr std::size_t kHealthySamples = 6000;
constexpr std::size_t kRecordSamples = 2000;
constexpr std::size_t kBlocks = 5;
constexpr std::uint64_t kTrials = 2;

/// Exceedances of a high level decay exponentially: extrapolates the maxima of blocks to one
/// exceedance a day.
double LevelOfOneADay(std::vector<double> maxima, double block_s) {
  if (maxima.empty()) return 0.0;
  std::ranges::sort(maxima);
  constexpr double kTail = 0.1;
  const auto from = static_cast<std::size_t>((1.0 - kTail) * static_cast<double>(maxima.size()));
  const double level = maxima[from];
  double excess = 0.0;
  for (std::size_t i = from; i < maxima.size(); ++i) excess += maxima[i] - level;
  excess /= static_cast<double>(maxima.size() - from);
  const double blocks_a_day = 86400.0 / block_s;
  return level + excess * std::log(kTail * blocks_a_day);
}

/// Largest statistic of each block of a healthy record after its calibration.
void CollectMaxima(const MethodInfo& info,
                   const core::MethodTask& task,
                   const MethodRecord& record,
                   double from_s,
                   std::size_t block,
                   double tuning,
                   std::vector<double>& maxima) {
  core::MethodSession session(info, task, tuning, std::numeric_limits<double>::infinity());
  double most = -std::numeric_limits<double>::infinity();
  std::size_t inside = 0;
  for (const core::Sample& sample : record.samples) {
    if (sample.t_s < from_s) continue;
    session.Push(sample);
    most = std::max(most, session.statistic());
    if (++inside < block) continue;
    maxima.push_back(most);
    most = -std::numeric_limits<double>::infinity();
    inside = 0;
  }
}

void PrintTunings(const std::vector<std::string>& methods) {
  const core::Bench& bench = *hardware::LoadBench("paper").value();
  const core::MethodOptions asked = core::MethodOptionsOf(bench, bench.period_s);
  const std::size_t samples = core::SpanOf(kHealthySamples, bench.period_s);
  const auto block = static_cast<std::size_t>(
      (static_cast<double>(samples) - asked.healthy_to_s / bench.period_s) / kBlocks);
  const double block_s = static_cast<double>(block) * bench.period_s;
  std::vector<std::pair<MethodRecord, core::MethodTask>> healthy;
  for (std::size_t h = 0; h < kHealthyRecords; ++h) {
    MethodRecord record = SimulateMethodRecord(bench, nullptr, kTuningSeed + h, samples);
    core::Result<core::MethodTask> task = core::PrepareMethods(record.samples, asked);
    if (task) healthy.emplace_back(std::move(record), std::move(task).value());
  }
  std::vector<MethodRecord> faulty;
  const std::vector<core::FaultSize> faults = core::FaultsOf(bench);
  const auto same_kinds = SameKinds(bench, asked.channels, faults);
  for (std::size_t f = 0; f < faults.size(); ++f) {
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      faulty.push_back(SimulateMethodRecord(bench,
                                            &faults[f],
                                            kTuningSeed + 10'000 + 100 * f + trial,
                                            core::SpanOf(kRecordSamples, bench.period_s)));
      faulty.back().same_kind = same_kinds[f];
    }
  }
  for (const MethodInfo& info : core::AllMethods()) {
    const bool wanted = methods.empty() || std::ranges::find(methods, info.name) != methods.end();
    if (!wanted || info.group == "faultlab" || !core::Fits(info, bench)) continue;
    std::tuple<int, double, double> best_score{-1, 0.0, 0.0};
    double best_tuning = 0.0;
    double best_level = 0.0;
    std::string tried;
    double level = 0.0;
    for (std::size_t t = 0; t < info.tunings.size(); ++t) {
      const double tuning = info.tunings[t];
      // The effort of a search does not change how it detects.
      if (t == 0 || info.pace != core::MethodPace::kAfterwards) {
        std::vector<double> maxima;
        for (const auto& [record, task] : healthy) {
          CollectMaxima(info, task, record, asked.healthy_to_s, block, tuning, maxima);
        }
        level = LevelOfOneADay(maxima, block_s);
      }
      int named = 0;
      std::vector<double> errors;
      std::vector<double> delays;
      for (const MethodRecord& record : faulty) {
        const MethodOutcome outcome = TryMethod(info, asked, record, tuning, level);
        delays.push_back(outcome.detected ? outcome.delay_samples
                                          : std::numeric_limits<double>::infinity());
        if (!outcome.detected) continue;
        named += (outcome.isolated[2] ? 1 : 0) + (outcome.isolated.back() ? 1 : 0);
        if (outcome.isolated.back() && std::isfinite(outcome.error)) {
          errors.push_back(outcome.error);
        }
      }
      const double error = errors.empty() ? 1.0 : core::Quantile(errors, 0.5);
      const double delay = delays.empty() ? 0.0 : core::Quantile(delays, 0.5);
      tried += core::Format(" %g: level %.4g, named %d of %zu, error %.3g %%, delay %g;",
                            tuning,
                            level,
                            named,
                            2 * faulty.size(),
                            100.0 * error,
                            delay);
      const std::tuple<int, double, double> score{named, -error, -delay};
      if (score > best_score) {
        best_score = score;
        best_tuning = tuning;
        best_level = level;
      }
    }
    std::printf("    MethodTuning{\"%s\", %.6g, %.6g},  //%s\n",
                std::string(info.name).c_str(),
                best_tuning,
                best_level,
                tried.c_str());
  }
}

}  // namespace
}  // namespace faultlab::server

int main(int argc, char** argv) {
  faultlab::server::PrintTunings({argv + 1, argv + argc});
}
