#include "server/cli/simulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/plant/simulate_record.h"
#include "core/types/number_text.h"
#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/excitation_source.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/csv/csv_writer.h"
#include "server/csv/fault_text.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;

/// The settings from the flags and the bench together.
struct Plan {
  const core::Bench* bench = nullptr;
  const core::BenchProfile* profile = nullptr;
  double period_s = 0.0;
  std::string excitation;
};

Result<Plan> MakePlan(const SimulateOptions& options) {
  TRY(const auto bench, hardware::LoadBench(options.bench));
  TRY(const auto profile, hardware::FindProfile(*bench, options.profile));
  return Plan{bench,
              profile,
              options.period_s.value_or(bench->period_s),
              options.excitation.empty() ? bench->excitation_text : options.excitation};
}

Result<std::vector<core::Fault>> ParseFaults(const SimulateOptions& options,
                                             const core::Bench& bench,
                                             double end_s) {
  std::vector<core::Fault> faults;
  for (const std::string& text : options.faults) {
    TRY(auto fault, ParseFault(text, bench));
    if (fault.at_s >= end_s) {
      return Error{ErrorCode::kInvalid,
                   "fault '" + text + "': it comes after the end of the run at " +
                       std::to_string(end_s) + " s",
                   "fault"};
    }
    faults.push_back(fault);
  }
  return faults;
}

Result<std::vector<double>> MakeInput(const SimulateOptions& options, const Plan& plan) {
  TRY(const auto spec, ReadExcitation(plan.excitation, options.seed));
  const std::size_t samples_max = CsvLimits{}.rows_max;
  if (!(options.duration_s / plan.period_s <= static_cast<double>(samples_max))) {
    return Error{ErrorCode::kTooLarge,
                 "the run would have more than " + std::to_string(samples_max) +
                     " samples; use a shorter --duration",
                 "duration_s"};
  }
  Result<std::vector<double>> uc = core::Generate(spec, options.duration_s, plan.period_s);
  if (!uc) {
    Error error = uc.error();
    const bool named = error.field.empty() || error.message.find(error.field) != std::string::npos;
    error.message = "excitation: " + (named ? "" : error.field + ": ") + error.message;
    return error;
  }
  const double range_v = plan.profile->converters.range_v;
  for (const double value : uc.value()) {
    if (!(std::abs(value) <= range_v)) {
      std::array<char, 80> text;
      std::snprintf(text.data(),
                    text.size(),
                    "%f V is beyond the converter's range of -%g V to %g V",
                    value,
                    range_v,
                    range_v);
      return Error{ErrorCode::kInvalid, std::string("excitation: ") + text.data(), "excitation"};
    }
  }
  const auto [least, most] = std::minmax_element(uc.value().begin(), uc.value().end());
  const double low = least == uc.value().end() ? 0.0 : *least;
  const double high = most == uc.value().end() ? 0.0 : *most;
  if (low < plan.bench->input_min_v || high > plan.bench->input_max_v) {
    const std::string text = core::Format(
        "note: the excitation goes from %g V to %g V; a rig of this bench refuses what is "
        "outside %g V to %g V",
        low,
        high,
        plan.bench->input_min_v,
        plan.bench->input_max_v);
    PrintError(text);
  }
  return uc;
}

CsvWriteOptions Describe(const SimulateOptions& options,
                         const Plan& plan,
                         const std::vector<core::Fault>& faults) {
  CsvWriteOptions out;
  out.comments.push_back("faultlab " + std::string(Version()) + " simulate");
  out.comments.push_back(BenchComment(*plan.bench) + ", profile " + plan.profile->name + ", seed " +
                         std::to_string(options.seed) + ", excitation " + plan.excitation);
  for (const core::Fault& fault : faults) {
    out.comments.push_back(FaultComment(fault));
  }
  return out;
}

}  // namespace

int RunSimulate(const SimulateOptions& options) {
  TRY_INPUT(const auto plan, MakePlan(options));
  if (!(plan.period_s > plan.profile->delta_s) || plan.period_s > 1.0) {
    PrintError("--period must be above the profile's delay of " +
               std::to_string(1e3 * plan.profile->delta_s) + " ms and at most 1 s");
    return kExitBadInput;
  }
  TRY_INPUT(const auto uc, MakeInput(options, plan));
  const double end_s = static_cast<double>(uc.size()) * plan.period_s;
  TRY_INPUT(const auto faults, ParseFaults(options, *plan.bench, end_s));
  const std::vector<core::Sample> samples = core::SimulateRecord(
      *plan.profile, plan.bench->nominal, uc, faults, options.seed, plan.period_s);
  return Ended(WriteCsv(options.output, samples, Describe(options, plan, faults)));
}

}  // namespace faultlab::server
