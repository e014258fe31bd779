#include "server/diagnosis_json/calibration_json.h"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/parse.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/diagnosis/rig_parameters.h"
#include "server/diagnosis_json/diagnosis_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Calibration;
using core::Error;
using core::ErrorCode;
using core::Result;

constexpr int kVersion = 1;
constexpr std::size_t kCovarianceSize =
    static_cast<std::size_t>(core::kCoordinateCount) * core::kCoordinateCount;

/// The plant's constants beside the seven components.
struct Constant {
  std::string_view name;
  double core::PlantParameters::*member;
};
constexpr std::array<Constant, 7> kConstants = {{{"Ke", &core::PlantParameters::ke_v_per_rad_s},
                                                 {"KT", &core::PlantParameters::kt_nm_per_a},
                                                 {"La", &core::PlantParameters::la_henry},
                                                 {"R5", &core::PlantParameters::r5_ohm},
                                                 {"R10", &core::PlantParameters::r10_ohm},
                                                 {"R14", &core::PlantParameters::r14_ohm},
                                                 {"R15", &core::PlantParameters::r15_ohm}}};

/// Numbers that a calibration cannot do without, and their least values.
struct Field {
  std::string_view name;
  double Calibration::*member;
  double least;
};
constexpr std::array<Field, 13> kFields = {
    {{"from_s", &Calibration::from_s, -1e9},
     {"to_s", &Calibration::to_s, -1e9},
     {"period_s", &Calibration::period_s, 1e-6},
     {"delta_s", &Calibration::delta_s, 0.0},
     {"gain_factor", &Calibration::gain_factor, 1e-6},
     {"mc_nm", &Calibration::mc_nm, 0.0},
     {"mc_sigma_nm", &Calibration::mc_sigma_nm, 0.0},
     {"um_noise_v", &Calibration::um_noise_v, 1e-9},
     {"ia_noise_a", &Calibration::ia_noise_a, 0.0},
     {"n_noise_rpm", &Calibration::n_noise_rpm, 0.0},
     {"friction_noise_nm", &Calibration::friction_noise_nm, 0.0},
     {"friction_tau_s", &Calibration::friction_tau_s, 1e-6},
     {"part_tolerance", &Calibration::part_tolerance, 0.0}}};

struct Threshold {
  std::string_view name;
  double core::DetectionThresholds::*member;
};
constexpr std::array<Threshold, 6> kThresholds = {
    {{"false_alarms_per_day", &core::DetectionThresholds::false_alarms_per_day},
     {"residual", &core::DetectionThresholds::residual},
     {"cusum", &core::DetectionThresholds::cusum},
     {"glr_25", &core::DetectionThresholds::glr_short},
     {"glr_100", &core::DetectionThresholds::glr_long},
     {"glr_500", &core::DetectionThresholds::glr_slow}}};

/// Reads members one by one and remembers the first that was not as it must be.
class Reader {
 public:
  Reader(const json::object& object, std::string prefix, std::optional<Error>& error)
      : object_(object), prefix_(std::move(prefix)), error_(error) {}

  double Number(std::string_view member, double least) {
    const json::value* value = object_.if_contains(member);
    const bool number = value != nullptr && value->is_number();
    const double read = number ? value->to_number<double>() : 0.0;
    if (!number || !std::isfinite(read) || read < least) {
      Refuse(member, least > 0.0 ? "expected a number above 0" : "expected a number");
    }
    return read;
  }

  std::string Text(std::string_view member) {
    const json::value* value = object_.if_contains(member);
    if (value == nullptr || !value->is_string()) {
      Refuse(member, "expected a text");
      return {};
    }
    return std::string(value->get_string());
  }

  bool Flag(std::string_view member) {
    const json::value* value = object_.if_contains(member);
    if (value == nullptr || !value->is_bool()) {
      Refuse(member, "expected true or false");
      return false;
    }
    return value->get_bool();
  }

  const json::object& Object(std::string_view member) {
    const json::value* value = object_.if_contains(member);
    if (value == nullptr || !value->is_object()) {
      Refuse(member, "expected an object");
      static const json::object kNothing;
      return kNothing;
    }
    return value->get_object();
  }

  const json::array& Array(std::string_view member) {
    const json::value* value = object_.if_contains(member);
    if (value == nullptr || !value->is_array()) {
      Refuse(member, "expected an array");
      static const json::array kNothing;
      return kNothing;
    }
    return value->get_array();
  }

  void Refuse(std::string_view member, const std::string& message) {
    if (!error_) {
      error_ = Error{ErrorCode::kInvalid,
                     "member " + prefix_ + std::string(member) + ": " + message,
                     prefix_ + std::string(member)};
    }
  }

 private:
  const json::object& object_;
  std::string prefix_;
  std::optional<Error>& error_;
};

/// An entry of an array of objects; an empty one is refused by its first member.
const json::object& Entry(const json::value& value) {
  static const json::object kNothing;
  return value.is_object() ? value.get_object() : kNothing;
}

/// 64 numbers, row by row; with nothing below `diagonal_min` on the diagonal.
void ReadMatrix(Reader& reader,
                std::string_view member,
                double diagonal_min,
                std::vector<double>& out) {
  for (const json::value& one : reader.Array(member)) {
    out.push_back(one.is_number() ? one.to_number<double>() : core::kAbsent);
  }
  bool sound = out.size() == kCovarianceSize;
  for (std::size_t i = 0; sound && i < kCovarianceSize; ++i) {
    const std::size_t row = i / core::kCoordinateCount;
    const std::size_t column = i % core::kCoordinateCount;
    sound = std::isfinite(out[i]) && (row != column || out[i] >= diagonal_min);
  }
  if (!sound) {
    reader.Refuse(
        member,
        "expected " + std::to_string(kCovarianceSize) + " numbers, row by row, a covariance");
  }
}

void ReadLists(const json::object& object, std::optional<Error>& error, Calibration& out) {
  Reader reader(object, "", error);
  for (const json::value& one : reader.Array("quantities")) {
    Reader entry(Entry(one), "quantities/", error);
    out.quantities.push_back({entry.Text("name"),
                              entry.Text("unit"),
                              entry.Number("value", -1e300),
                              entry.Number("sigma", 0.0),
                              entry.Number("prior_value", -1e300),
                              entry.Number("prior_sigma", 0.0),
                              entry.Flag("from_data")});
  }
  for (const json::value& one : reader.Array("checks")) {
    Reader entry(Entry(one), "checks/", error);
    out.checks.push_back({entry.Text("name"),
                          entry.Text("sentence"),
                          entry.Number("value", -1e300),
                          entry.Number("limit", -1e300),
                          entry.Flag("passed")});
  }
  ReadMatrix(reader, "covariance", 0.0, out.covariance);
  ReadMatrix(reader, "covariance_doubt", -1.0, out.covariance_doubt);
}

json::array ListOf(const std::vector<double>& numbers) {
  json::array list;
  for (const double number : numbers) list.push_back(Number(number));
  return list;
}

}  // namespace

json::object ToJson(const Calibration& calibration) {
  json::object nominal;
  for (const core::Component component : core::kAllComponents) {
    nominal[core::Name(component)] = calibration.nominal.Get(component);
  }
  json::object constants;
  for (const Constant& constant : kConstants) {
    constants[constant.name] = calibration.nominal.*constant.member;
  }
  json::array quantities;
  for (const core::CalibratedQuantity& quantity : calibration.quantities) {
    quantities.emplace_back(json::object{{"name", quantity.name},
                                         {"unit", quantity.unit},
                                         {"value", Number(quantity.value)},
                                         {"sigma", Number(quantity.sigma)},
                                         {"prior_value", Number(quantity.prior_value)},
                                         {"prior_sigma", Number(quantity.prior_sigma)},
                                         {"from_data", quantity.from_data}});
  }
  json::array checks;
  for (const core::CalibrationCheck& check : calibration.checks) {
    checks.emplace_back(json::object{{"name", check.name},
                                     {"sentence", check.sentence},
                                     {"value", Number(check.value)},
                                     {"limit", Number(check.limit)},
                                     {"passed", check.passed}});
  }
  json::object thresholds;
  for (const Threshold& threshold : kThresholds) {
    thresholds[threshold.name] = Number(calibration.thresholds.*threshold.member);
  }
  json::object out = {{"version", calibration.version},
                      {"dated", calibration.dated},
                      {"samples", calibration.samples},
                      {"used_ia", calibration.used_ia},
                      {"used_n", calibration.used_n}};
  for (const Field& field : kFields) {
    out[field.name] = Number(calibration.*field.member);
  }
  out["nominal"] = std::move(nominal);
  out["constants"] = std::move(constants);
  out["quantities"] = std::move(quantities);
  out["checks"] = std::move(checks);
  out["thresholds"] = std::move(thresholds);
  out["covariance"] = ListOf(calibration.covariance);
  out["covariance_doubt"] = ListOf(calibration.covariance_doubt);
  return out;
}

Result<Calibration> CalibrationFromJson(const json::value& value, std::string_view name) {
  const auto refuse = [&](const std::string& message, std::string field) {
    return Error{ErrorCode::kInvalid, std::string(name) + ": " + message, std::move(field)};
  };
  const json::object* object = value.if_object();
  if (object != nullptr && object->contains("calibration")) {
    object = object->at("calibration").if_object();
  }
  if (object == nullptr) {
    return refuse("no calibration in it; make one with 'faultlab calibrate'", "");
  }
  std::optional<Error> error;
  Calibration out;
  Reader reader(*object, "", error);
  if (reader.Number("version", 1.0) != kVersion) {
    reader.Refuse("version", "only version " + std::to_string(kVersion) + " is known");
  }
  out.dated = reader.Text("dated");
  constexpr double kSamplesMax = 1e9;
  out.samples = static_cast<int>(std::min(kSamplesMax, reader.Number("samples", 1.0)));
  out.used_ia = reader.Flag("used_ia");
  out.used_n = reader.Flag("used_n");
  for (const Field& field : kFields) {
    out.*field.member = reader.Number(field.name, field.least);
  }
  constexpr double kAboveZero = 1e-18;
  Reader nominal(reader.Object("nominal"), "nominal/", error);
  for (const core::Component component : core::kAllComponents) {
    out.nominal.Set(component, nominal.Number(core::Name(component), kAboveZero));
  }
  Reader constants(reader.Object("constants"), "constants/", error);
  for (const Constant& constant : kConstants) {
    out.nominal.*constant.member = constants.Number(constant.name, kAboveZero);
  }
  Reader thresholds(reader.Object("thresholds"), "thresholds/", error);
  for (const Threshold& threshold : kThresholds) {
    out.thresholds.*threshold.member = thresholds.Number(threshold.name, kAboveZero);
  }
  ReadLists(*object, error, out);
  if (error) {
    return refuse(error->message, error->field);
  }
  return out;
}

Result<Calibration> ParseCalibration(std::string_view text, std::string_view name) {
  boost::system::error_code failed;
  const json::value value = json::parse(text, failed);
  if (failed) {
    return Error{ErrorCode::kInvalid,
                 std::string(name) + ": not JSON (" + failed.message() + ")",
                 "calibration"};
  }
  return CalibrationFromJson(value, name);
}

}  // namespace faultlab::server
