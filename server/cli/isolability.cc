#include "server/cli/isolability.h"

#include <boost/json/serialize.hpp>

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
  if (!options.calibration.empty()) {
    Result<core::Calibration> calibration = ReadCalibrationFile(options.calibration);
    if (!calibration) {
      return calibration.error();
    }
    question.calibration = std::move(calibration).value();
  }
  Result<core::ExcitationSpec> excitation = ReadExcitation(options.excitation, 1);
  if (!excitation) {
    return excitation.error();
  }
  question.excitation = std::move(excitation).value();
  question.excitation_name = options.excitation;
  for (const std::string& text : options.faults) {
    const Result<core::Fault> fault = ParseFault(text + "@0");
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
