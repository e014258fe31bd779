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
  TRY(const auto bench, hardware::LoadBench(options.bench));
  question.bench = bench;
  if (!options.calibration.empty()) {
    TRY(question.calibration, ReadCalibrationFile(options.calibration, *bench));
  }
  const std::string excitation_name =
      options.excitation.empty() ? bench->excitation_text : options.excitation;
  TRY(question.excitation, ReadExcitation(excitation_name, 1));
  question.excitation_name = excitation_name;
  for (const std::string& text : options.faults) {
    TRY(const auto fault, ParseFault(text + "@0", *bench));
    question.faults.push_back({fault.component, fault.value});
  }
  return question;
}

Result<core::Isolability> Analyse(const IsolabilityQuestion& question) {
  TRY(const auto options, ToOptions(question));
  return core::AnalyseIsolability(options);
}

}  // namespace

int RunIsolability(const IsolabilityCommandOptions& options) {
  TRY_INPUT(const auto question, Question(options));
  TRY_INPUT(const auto isolability, Analyse(question));
  if (!options.output.empty()) {
    const Figure figure = MakeIsolabilityFigure(isolability, ToText(question));
    const int ended = Ended(WriteFigure(figure, options.output, 1));
    if (ended != kExitOk) return ended;
  }
  return Print(options.json ? boost::json::serialize(ToJson(isolability)) + "\n"
                            : ToText(isolability));
}

}  // namespace faultlab::server
