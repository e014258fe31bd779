#include "server/cli/isolability.h"

#include <boost/json/serialize.hpp>

#include "hardware/bench/benches.h"
#include "server/cli/calibration_file.h"
#include "server/cli/console.h"
#include "server/cli/excitation_source.h"
#include "server/cli/figure_file.h"
#include "server/csv/fault_text.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/plots/isolability_figure.h"

namespace faultlab::server {
namespace {

using core::Result;

Result<IsolabilityQuestion> Question(const IsolabilityCommandOptions& options) {
  IsolabilityQuestion question = options.question;
  const Result<const core::Bench*> bench = hardware::LoadBench(options.bench);
  if (!bench) return bench.error();
  question.bench = bench.value();
  if (!options.calibration.empty()) {
    Result<core::Calibration> calibration =
        ReadCalibrationFile(options.calibration, *bench.value());
    if (!calibration) {
      return calibration.error();
    }
    question.calibration = std::move(calibration).value();
  }
  const std::string excitation_name =
      options.excitation.empty() ? bench.value()->excitation_text : options.excitation;
  Result<core::ExcitationSpec> excitation = ReadExcitation(excitation_name, 1);
  if (!excitation) {
    return excitation.error();
  }
  question.excitation = std::move(excitation).value();
  question.excitation_name = excitation_name;
  for (const std::string& text : options.faults) {
    const Result<core::Fault> fault = ParseFault(text + "@0", *bench.value());
    if (!fault) {
      return fault.error();
    }
    question.faults.push_back({fault.value().component, fault.value().value});
  }
  return question;
}

Result<core::Isolability> Analyse(const IsolabilityQuestion& question) {
  const Result<core::IsolabilityOptions> options = ToOptions(question);
  if (!options) {
    return options.error();
  }
  return core::AnalyseIsolability(options.value());
}

}  // namespace

int RunIsolability(const IsolabilityCommandOptions& options) {
  const Result<IsolabilityQuestion> question = Question(options);
  if (!question) {
    return Fail(question.error(), kExitBadInput);
  }
  const Result<core::Isolability> isolability = Analyse(question.value());
  if (!isolability) {
    return Fail(isolability.error(), kExitBadInput);
  }
  if (!options.output.empty()) {
    const core::Status written = WriteFigure(
        MakeIsolabilityFigure(isolability.value(), ToText(question.value())), options.output, 1);
    if (!written) {
      return Fail(written.error(), kExitFailure);
    }
  }
  return Print(options.json ? boost::json::serialize(ToJson(isolability.value())) + "\n"
                            : ToText(isolability.value()));
}

}  // namespace faultlab::server
