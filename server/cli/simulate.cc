#include "server/cli/simulate.h"

#include <algorithm>
#include <cmath>

#include "core/plant/simulate_record.h"
#include "server/cli/console.h"
#include "server/cli/excitation_source.h"
#include "server/csv/csv_record.h"
#include "server/csv/csv_writer.h"
#include "server/csv/fault_text.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;

constexpr double kConverterRange_v = 10.0;  // NI 9263: what a control voltage can be at all

Result<std::vector<core::Fault>> ParseFaults(const SimulateOptions& options, double end_s) {
  std::vector<core::Fault> faults;
  for (const std::string& text : options.faults) {
    Result<core::Fault> fault = ParseFault(text);
    if (!fault) {
      return fault.error();
    }
    if (fault.value().at_s >= end_s) {
      return Error{ErrorCode::kInvalid,
                   "fault '" + text + "': it comes after the end of the run at " +
                       std::to_string(end_s) + " s",
                   "fault"};
    }
    faults.push_back(fault.value());
  }
  return faults;
}

Result<std::vector<double>> MakeInput(const SimulateOptions& options) {
  const Result<core::ExcitationSpec> spec = ReadExcitation(options.excitation, options.seed);
  if (!spec) {
    return spec.error();
  }
  const std::size_t samples_max = CsvLimits{}.rows_max;
  if (!(options.duration_s / options.period_s <= static_cast<double>(samples_max))) {
    return Error{ErrorCode::kTooLarge,
                 "the run would have more than " + std::to_string(samples_max) +
                     " samples; use a shorter --duration",
                 "duration_s"};
  }
  Result<std::vector<double>> uc =
      core::Generate(spec.value(), options.duration_s, options.period_s);
  if (!uc) {
    Error error = uc.error();
    const bool named = error.field.empty() || error.message.find(error.field) != std::string::npos;
    error.message = "excitation: " + (named ? "" : error.field + ": ") + error.message;
    return error;
  }
  for (const double value : uc.value()) {
    if (!(std::abs(value) <= kConverterRange_v)) {
      return Error{ErrorCode::kInvalid,
                   "excitation: " + std::to_string(value) +
                       " V is beyond the converter's range of -10 V to 10 V",
                   "excitation"};
    }
  }
  return uc;
}

CsvWriteOptions Describe(const SimulateOptions& options, const std::vector<core::Fault>& faults) {
  CsvWriteOptions out;
  out.comments.push_back("faultlab " + std::string(Version()) + " simulate");
  out.comments.push_back("profile " + options.profile + ", seed " + std::to_string(options.seed) +
                         ", excitation " + options.excitation);
  for (const core::Fault& fault : faults) {
    out.comments.push_back(FaultComment(fault));
  }
  return out;
}

}  // namespace

int RunSimulate(const SimulateOptions& options) {
  const Result<core::BenchProfile> profile = core::FindBenchProfile(options.profile);
  if (!profile) {
    return Fail(profile.error(), kExitBadInput);
  }
  if (!(options.period_s > profile.value().delta_s) || options.period_s > 1.0) {
    PrintError("--period must be above the profile's delay of " +
               std::to_string(1e3 * profile.value().delta_s) + " ms and at most 1 s");
    return kExitBadInput;
  }
  const Result<std::vector<double>> uc = MakeInput(options);
  if (!uc) {
    return Fail(uc.error(), kExitBadInput);
  }
  const double end_s = static_cast<double>(uc.value().size()) * options.period_s;
  const Result<std::vector<core::Fault>> faults = ParseFaults(options, end_s);
  if (!faults) {
    return Fail(faults.error(), kExitBadInput);
  }
  const std::vector<core::Sample> samples = core::SimulateRecord(profile.value(),
                                                                 core::PlantParameters{},
                                                                 uc.value(),
                                                                 faults.value(),
                                                                 options.seed,
                                                                 options.period_s);
  const core::Status written = WriteCsv(options.output, samples, Describe(options, faults.value()));
  return written ? kExitOk : Fail(written.error(), kExitFailure);
}

}  // namespace faultlab::server
