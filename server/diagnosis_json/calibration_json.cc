#include "server/diagnosis_json/calibration_json.h"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/parse.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/calibration/calibrate.h"
#include "core/filter/rig_parameters.h"
#include "core/types/number_text.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/plant_json.h"
#include "server/json/document_reader.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Calibration;
using core::Error;
using core::ErrorCode;
using core::Result;

constexpr int kVersion = 1;
constexpr std::size_t kRows = core::kCoordinateCount;
constexpr std::size_t kRowsWithLa = core::kCoordinateCountWithLa;
constexpr std::size_t kRowsMax = core::kCoordinateMax;

/// Numbers that a calibration must have, and their least values.
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
     {"um_noise_v", &Calibration::um_noise_v, 0.0},
     {"ia_noise_a", &Calibration::ia_noise_a, 0.0},
     {"n_noise_rpm", &Calibration::n_noise_rpm, 0.0},
     {"friction_noise_nm", &Calibration::friction_noise_nm, 0.0},
     {"friction_tau_s", &Calibration::friction_tau_s, 1e-6},
     {"part_tolerance", &Calibration::part_tolerance, 0.0}}};

/// Numbers that older documents lack: 0 then.
struct LaterField {
  std::string_view name;
  double Calibration::*member;
};
constexpr std::array<LaterField, 4> kLater = {{{"impulse_share", &Calibration::impulse_share},
                                               {"um_zero_v", &Calibration::um_zero_v},
                                               {"ia_zero_a", &Calibration::ia_zero_a},
                                               {"n_zero_rpm", &Calibration::n_zero_rpm}}};

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

/// 64 numbers, or 81 of a bench that states a tolerance of La, or 100 of one whose lag can be seen,
/// row by row; with nothing below `diagonal_min` on the diagonal.
void ReadMatrix(DocumentReader& reader,
                std::string_view member,
                double diagonal_min,
                std::vector<double>& out) {
  for (const json::value& one : reader.Array(member)) {
    out.push_back(one.is_number() ? one.to_number<double>() : core::kAbsent);
  }
  const std::size_t rows = out.size() == kRowsMax * kRowsMax         ? kRowsMax
                           : out.size() == kRowsWithLa * kRowsWithLa ? kRowsWithLa
                                                                     : kRows;
  bool sound = out.size() == rows * rows;
  for (std::size_t i = 0; sound && i < out.size(); ++i) {
    const std::size_t row = i / rows;
    const std::size_t column = i % rows;
    sound = std::isfinite(out[i]) && (row != column || out[i] >= diagonal_min);
  }
  if (!sound) {
    reader.Refuse(
        member, "expected " + std::to_string(kRows * kRows) + " numbers, row by row, a covariance");
  }
}

constexpr double kFactorMax = 1e6;

/// As many numbers as `out` has, from -1 to 1: with more no change would be a fault. An older
/// calibration tells that of Ra alone.
void ReadWalk(DocumentReader& reader, const json::object& left, std::array<double, 3>& out) {
  json::array of_ra{left.contains("ra_walk") ? left.at("ra_walk") : 0.0, 0.0, 0.0};
  const json::array& numbers = left.contains("walk") ? reader.Array("walk") : of_ra;
  bool fits = numbers.size() == out.size();
  for (std::size_t i = 0; fits && i < out.size(); ++i) {
    out[i] = numbers[i].is_number() ? numbers[i].to_number<double>() : core::kAbsent;
    fits = std::abs(out[i]) <= core::ModelError::kWalkMax;
  }
  if (!fits) reader.Refuse("walk", "expected three numbers from -1 to 1");
}

/// Lists of as many numbers as `out` has, each at least 1.
template <std::size_t Rows, std::size_t Columns>
void ReadFactors(DocumentReader& reader,
                 std::string_view member,
                 std::array<std::array<double, Columns>, Rows>& out) {
  const json::array& rows = reader.Array(member);
  bool fits = rows.size() == Rows;
  for (std::size_t row = 0; fits && row < Rows; ++row) {
    const json::array* numbers = rows[row].if_array();
    fits = numbers != nullptr && numbers->size() == Columns;
    for (std::size_t i = 0; fits && i < Columns; ++i) {
      const json::value& number = (*numbers)[i];
      out[row][i] = number.is_number() ? number.to_number<double>() : 0.0;
      fits = out[row][i] >= 1.0 && out[row][i] <= kFactorMax;
    }
  }
  if (!fits) reader.Refuse(member, "expected lists of numbers from 1 to 1000000");
}

template <std::size_t Rows, std::size_t Columns>
json::array FactorsOf(const std::array<std::array<double, Columns>, Rows>& factors) {
  json::array rows;
  for (const auto& row : factors) rows.push_back(json::array(row.begin(), row.end()));
  return rows;
}

void ReadLists(const json::object& object, std::optional<Error>& error, Calibration& out) {
  DocumentReader reader(object, "", error);
  for (const json::value& one : reader.Array("quantities")) {
    DocumentReader entry(EntryOf(one), "quantities/", error);
    out.quantities.push_back({entry.Text("name"),
                              entry.Text("unit"),
                              entry.Number("value", -1e300),
                              entry.Number("sigma", 0.0),
                              entry.Number("prior_value", -1e300),
                              entry.Number("prior_sigma", 0.0),
                              entry.Flag("from_data")});
  }
  for (const json::value& one : reader.Array("checks")) {
    DocumentReader entry(EntryOf(one), "checks/", error);
    out.checks.push_back({entry.Text("name"),
                          entry.Text("sentence"),
                          entry.Number("value", -1e300),
                          entry.Number("limit", -1e300),
                          entry.Flag("passed")});
  }
  ReadMatrix(reader, "covariance", 0.0, out.covariance);
  ReadMatrix(reader, "covariance_doubt", -1.0, out.tolerance_covariance);
  if (object.contains("covariance_model")) {
    ReadMatrix(reader, "covariance_model", -1.0, out.model_covariance);
  }
  if (object.contains("model_error")) {
    const json::object& document = reader.Object("model_error");
    DocumentReader left(document, "model_error/", error);
    out.model_error.step_v = left.Number("step_v", 0.0);
    ReadWalk(left, document, out.model_error.walk);
    ReadFactors(left, "growth", out.model_error.growth);
    ReadFactors(left, "raised", out.model_error.raised);
  }
}

}  // namespace

json::object ToJson(const Calibration& learnt, const core::Bench& bench) {
  // Who reads it has another run before them, with another phase of the hum.
  const Calibration calibration = core::WithHumAsNoise(learnt);
  json::object thresholds;
  for (const Threshold& threshold : kThresholds) {
    thresholds[threshold.name] = NumberOrNull(calibration.thresholds.*threshold.member);
  }
  json::object out = {{"version", calibration.version},
                      {"dated", calibration.dated},
                      {"samples", calibration.samples},
                      {"used_um", calibration.used_um},
                      {"used_ia", calibration.used_ia},
                      {"used_n", calibration.used_n}};
  for (const Field& field : kFields) {
    out[field.name] = NumberOrNull(calibration.*field.member);
  }
  for (const LaterField& field : kLater) {
    out[field.name] = NumberOrNull(calibration.*field.member);
  }
  if (calibration.covariance.size() == kRowsMax * kRowsMax) {
    out["lag_factor"] = NumberOrNull(calibration.lag_factor);
  }
  AddPlant(calibration.nominal, bench, out);
  out["quantities"] = ListOf(calibration.quantities, [](const core::CalibratedQuantity& quantity) {
    return json::object{{"name", quantity.name},
                        {"unit", quantity.unit},
                        {"value", NumberOrNull(quantity.value)},
                        {"sigma", NumberOrNull(quantity.sigma)},
                        {"prior_value", NumberOrNull(quantity.prior_value)},
                        {"prior_sigma", NumberOrNull(quantity.prior_sigma)},
                        {"from_data", quantity.from_data}};
  });
  out["checks"] = ListOf(calibration.checks, [](const core::CalibrationCheck& check) {
    return json::object{{"name", check.name},
                        {"sentence", check.sentence},
                        {"value", NumberOrNull(check.value)},
                        {"limit", NumberOrNull(check.limit)},
                        {"passed", check.passed}};
  });
  out["thresholds"] = std::move(thresholds);
  out["covariance"] = NumbersOrNull(calibration.covariance);
  out["covariance_doubt"] = NumbersOrNull(calibration.tolerance_covariance);
  if (!calibration.model_covariance.empty()) {
    out["covariance_model"] = NumbersOrNull(calibration.model_covariance);
  }
  if (const core::ModelError& left = calibration.model_error; left.any()) {
    out["model_error"] = {{"step_v", left.step_v},
                          {"walk", NumbersOrNull(left.walk)},
                          {"growth", FactorsOf(left.growth)},
                          {"raised", FactorsOf(left.raised)}};
  }
  return out;
}

Result<Calibration> CalibrationFromJson(const json::value& value,
                                        std::string_view name,
                                        const core::Bench& bench) {
  const auto refuse = [&](const std::string& message, std::string field) {
    return Error{
        ErrorCode::kInvalid, std::string(name) + ": " + message, std::move(field), "internal"};
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
  DocumentReader reader(*object, "", error);
  if (reader.Number("version", 1.0) != kVersion) {
    reader.Refuse("version", "only version " + std::to_string(kVersion) + " is known");
  }
  out.dated = reader.Text("dated");
  constexpr double kSamplesMax = 1e9;
  out.samples = static_cast<int>(std::min(kSamplesMax, reader.Number("samples", 1.0)));
  // Documents from before there were benches without um do not contain it.
  out.used_um = !object->contains("used_um") || reader.Flag("used_um");
  out.used_ia = reader.Flag("used_ia");
  out.used_n = reader.Flag("used_n");
  for (const Field& field : kFields) {
    out.*field.member = reader.Number(field.name, field.least);
  }
  for (const LaterField& field : kLater) {
    if (object->contains(field.name)) out.*field.member = reader.Number(field.name, -1e300);
  }
  if (object->contains("lag_factor")) {
    out.lag_factor = reader.Number("lag_factor", 1e-6);
  }
  constexpr double kNoiseLeast = 1e-9;
  if (out.used_um && out.um_noise_v < kNoiseLeast) {
    reader.Refuse("um_noise_v", "expected a number above 0");
  }
  out.nominal = ReadPlant(reader, bench, error);
  out.mc_unit_nm = core::McUnitOf(bench);
  constexpr double kAboveZero = 1e-18;
  DocumentReader thresholds(reader.Object("thresholds"), "thresholds/", error);
  for (const Threshold& threshold : kThresholds) {
    out.thresholds.*threshold.member = thresholds.Number(threshold.name, kAboveZero);
  }
  ReadLists(*object, error, out);
  if (error) {
    return refuse(error->message, error->field);
  }
  return out;
}

Result<Calibration> ParseCalibration(std::string_view text,
                                     std::string_view name,
                                     const core::Bench& bench) {
  boost::system::error_code failed;
  const json::value value = json::parse(text, failed);
  if (failed) {
    return Error{ErrorCode::kInvalid,
                 std::string(name) + ": not JSON (" + failed.message() + ")",
                 "calibration",
                 "internal"};
  }
  return CalibrationFromJson(value, name, bench);
}

core::Status CheckPeriod(const std::optional<core::Calibration>& calibration, double period_s) {
  constexpr double kSamePeriod = 1e-3;
  if (!calibration || std::abs(calibration->period_s - period_s) <= kSamePeriod * period_s) {
    return core::Done{};
  }
  const std::string its = core::Format("%.6g", 1e3 * calibration->period_s);
  const std::string wanted = core::Format("%.6g", 1e3 * period_s);
  return Error{ErrorCode::kInvalid,
               "the record has a period of " + wanted + " ms, the calibration is for " + its +
                   " ms; calibrate at the record's period",
               "calibration",
               "calibration_of_other_period",
               {{"its", its}, {"wanted", wanted}}};
}

}  // namespace faultlab::server
