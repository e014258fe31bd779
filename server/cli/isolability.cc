#include "server/cli/isolability.h"

#include <boost/json/serialize.hpp>

#include "core/diagnosis/isolability.h"
#include "core/plant/profile.h"
#include "server/cli/console.h"
#include "server/cli/excitation_text.h"
#include "server/cli/figure_file.h"
#include "server/csv/fault_text.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/plots/isolability_figure.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;

/// Samples before the fault, in which the filter settles.
constexpr double kSettlingSeconds = 5.0;

Result<core::IsolabilityOptions> Parse(const IsolabilityCommandOptions& options) {
  core::IsolabilityOptions out;
  const Result<core::BenchProfile> profile = core::FindBenchProfile(options.profile);
  if (!profile) {
    return profile.error();
  }
  if (options.channels != "um" && options.channels != "all") {
    return Error{ErrorCode::kInvalid,
                 "--channels '" + options.channels + "': expected um or all",
                 "channels"};
  }
  const core::BenchProfile& bench = profile.value();
  out.rig.delta_s = bench.delta_s;
  out.rig.mc_nm = bench.friction.mc_nm;
  out.noise = {bench.noise.um_v,
               bench.noise.ia_a,
               bench.noise.n_rpm * core::kRadPerSecondOfRpm,
               bench.friction.noise_rms_nm,
               bench.friction.noise_tau_s};
  out.channels = options.channels == "um" ? core::Channels::kUmOnly : core::Channels::kAll;
  out.window_samples = options.window_samples;
  const Result<core::ExcitationSpec> excitation = ParseExcitation(options.excitation, 1);
  if (!excitation) {
    return excitation.error();
  }
  const double duration_s = kSettlingSeconds + out.window_samples * out.period_s;
  Result<std::vector<double>> uc = core::Generate(excitation.value(), duration_s, out.period_s);
  if (!uc) {
    return uc.error();
  }
  out.uc_v = std::move(uc).value();
  for (const std::string& text : options.faults) {
    const Result<core::Fault> fault = ParseFault(text + "@0");
    if (!fault) {
      return fault.error();
    }
    out.faults.push_back({fault.value().component, fault.value().value});
  }
  return out;
}

}  // namespace

int RunIsolability(const IsolabilityCommandOptions& options) {
  const Result<core::IsolabilityOptions> parsed = Parse(options);
  if (!parsed) {
    return Fail(parsed.error(), kExitBadInput);
  }
  const Result<core::Isolability> isolability = core::AnalyseIsolability(parsed.value());
  if (!isolability) {
    return Fail(isolability.error(), kExitBadInput);
  }
  if (!options.output.empty()) {
    const std::string subtitle = options.profile + " profile, " + options.excitation + ", " +
                                 (options.channels == "um" ? "U_{m} alone" : "all channels") +
                                 ", " + std::to_string(options.window_samples) +
                                 " samples of the fault";
    const core::Status written =
        WriteFigure(MakeIsolabilityFigure(isolability.value(), subtitle), options.output, 1);
    if (!written) {
      return Fail(written.error(), kExitFailure);
    }
  }
  return Print(options.json ? boost::json::serialize(ToJson(isolability.value())) + "\n"
                            : ToText(isolability.value()));
}

}  // namespace faultlab::server
