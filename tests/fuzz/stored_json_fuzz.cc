// Documents that the server stored: diagnoses, options, calibrations. The first byte chooses one.
// What passes is written and read back.
#include <boost/json.hpp>

#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/options_json.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const int which = input.Byte() % 3;
  const std::string_view text = input.Rest();
  if (which == 0) {
    const auto diagnosis = server::ParseDiagnosis(text);
    Require(diagnosis.ok() || !diagnosis.error().message.empty());
    if (diagnosis.ok()) {
      Require(!server::ToText(diagnosis.value(), "fuzz").empty());
      Require(
          server::ParseDiagnosis(boost::json::serialize(server::ToJson(diagnosis.value()))).ok());
    }
  } else if (which == 1) {
    const auto options = server::ParseOptions(text);
    Require(options.ok() || !options.error().message.empty());
    if (options.ok()) Require(server::ParseOptions(server::OptionsText(options.value())).ok());
  } else {
    const auto calibration = server::ParseCalibration(text, "fuzz");
    Require(calibration.ok() || !calibration.error().message.empty());
    if (calibration.ok()) {
      const std::string again = boost::json::serialize(server::ToJson(calibration.value()));
      Require(server::ParseCalibration(again, "again").ok());
    }
  }
  return 0;
}
