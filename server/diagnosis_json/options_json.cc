#include "server/diagnosis_json/options_json.h"

#include <boost/json.hpp>

#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/plant_json.h"
#include "server/json/document_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kPeriodMin = 1e-6;
constexpr double kRateMin = 1e-12;

/// True for `yes`, false for `no`; anything else is refused.
bool Choice(DocumentReader& reader,
            std::string_view member,
            std::string_view yes,
            std::string_view no) {
  const std::string word = reader.Text(member);
  if (word != yes && word != no) reader.Refuse(member, "unknown word '" + word + "'");
  return word == yes;
}

}  // namespace

std::string OptionsText(const core::DiagnosisOptions& options) {
  json::object out;
  AddPlant(options.nominal, *options.bench, out);
  out["calibration"] = options.calibration
                           ? json::value(ToJson(*options.calibration, *options.bench))
                           : json::value(nullptr);
  out["healthy_from_s"] = options.healthy_from_s;
  out["healthy_to_s"] = options.healthy_to_s;
  out["channels"] = options.channels == core::Channels::kUmOnly ? "um" : "all";
  out["values"] = options.values == core::ValuePrior::kTable2 ? "table2" : "none";
  out["motor_faults"] = options.motor_faults;
  out["period_s"] = options.period_s;
  out["false_alarms_per_day"] = options.false_alarms_per_day;
  out["um_rail_v"] = options.um_rail_v;
  out["model_is_exact"] = options.model == core::ModelScope::kSimulator;
  out["built_rig"] = options.model == core::ModelScope::kBuiltRig;
  return json::serialize(out);
}

core::Result<core::DiagnosisOptions> ParseOptions(std::string_view text, const core::Bench& bench) {
  boost::system::error_code failed;
  const json::value value = json::parse(text, failed);
  std::optional<core::Error> error;
  const json::value nothing;
  DocumentReader reader(EntryOf(failed ? nothing : value), "", error);
  core::DiagnosisOptions options = core::OptionsOf(bench);
  options.nominal = ReadPlant(reader, bench, error);
  options.healthy_from_s = reader.Number("healthy_from_s", 0.0);
  options.healthy_to_s = reader.Number("healthy_to_s", 0.0);
  options.channels =
      Choice(reader, "channels", "um", "all") ? core::Channels::kUmOnly : core::Channels::kAll;
  options.values = Choice(reader, "values", "table2", "none") ? core::ValuePrior::kTable2
                                                              : core::ValuePrior::kNone;
  options.motor_faults = reader.Flag("motor_faults");
  options.period_s = reader.Number("period_s", kPeriodMin);
  options.false_alarms_per_day = reader.Number("false_alarms_per_day", kRateMin);
  options.um_rail_v = reader.Number("um_rail_v", 0.0);
  // Options from before they were known do not contain them.
  const json::object* object = value.if_object();
  const auto said = [&](const char* flag) {
    return object != nullptr && object->contains(flag) && reader.Flag(flag);
  };
  if (said("model_is_exact")) options.model = core::ModelScope::kSimulator;
  if (said("built_rig")) options.model = core::ModelScope::kBuiltRig;
  if (error) return *error;
  if (!value.at("calibration").is_null()) {
    TRY(options.calibration, CalibrationFromJson(value.at("calibration"), "stored options", bench));
  }
  return options;
}

}  // namespace faultlab::server
