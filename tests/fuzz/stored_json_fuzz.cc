// Documents that the server stores: diagnoses, options, calibrations. The first byte selects one.
// An accepted document is written and read back.
#include <boost/json.hpp>

#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/options_json.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/paper_bench.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const int which = input.Byte() % 3;
  const std::string_view text = input.Rest();
  if (which == 0) {
    const auto diagnosis = server::ParseDiagnosis(text, faultlab::paper::Bench());
    Require(diagnosis.ok() || !diagnosis.error().message.empty());
    if (diagnosis.ok()) {
      Require(!server::ToText(diagnosis.value(), "fuzz").empty());
      Require(server::ParseDiagnosis(boost::json::serialize(server::ToJson(
                                         diagnosis.value(), faultlab::paper::Bench())),
                                     faultlab::paper::Bench())
                  .ok());
    }
  } else if (which == 1) {
    const auto options = server::ParseOptions(text, faultlab::paper::Bench());
    Require(options.ok() || !options.error().message.empty());
    if (options.ok())
      Require(server::ParseOptions(server::OptionsText(options.value()), faultlab::paper::Bench())
                  .ok());
  } else {
    const auto calibration = server::ParseCalibration(text, "fuzz", faultlab::paper::Bench());
    Require(calibration.ok() || !calibration.error().message.empty());
    if (calibration.ok()) {
      const std::string again =
          boost::json::serialize(server::ToJson(calibration.value(), faultlab::paper::Bench()));
      Require(server::ParseCalibration(again, "again", faultlab::paper::Bench()).ok());
    }
  }
  return 0;
}
