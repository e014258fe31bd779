#include "server/diagnosis_json/isolability_json.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <cmath>
#include <vector>

#include "core/types/number_text.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kNameWidth = 26;
constexpr int kValueDigits = 6;  // "33000", not "3.3e+04"

template <typename Matrix>
json::array Rows(const Matrix& matrix) {
  json::array rows;
  for (int r = 0; r < matrix.rows(); ++r) {
    json::array row;
    for (int c = 0; c < matrix.cols(); ++c) {
      row.push_back(NumberOrNull(matrix(r, c)));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

json::object FaultJson(const core::FaultIsolability& fault) {
  const auto rival_json = [](const core::NearestRival& rival) {
    return json::object{{"component", core::Name(rival.component)},
                        {"kl", NumberOrNull(rival.kl_nats)},
                        {"value", NumberOrNull(rival.value)}};
  };
  return {{"component", core::Name(fault.fault.component)},
          {"value", fault.fault.value},
          {"unit", core::Unit(fault.fault.component)},
          {"kl_nominal", NumberOrNull(fault.kl_nominal_nats)},
          {"visible", fault.visible},
          {"rivals", ListOf(fault.rival, rival_json)},
          {"group", ComponentNames(fault.group)}};
}

std::string Significant(double value, int digits = 3) {
  return core::Format("%.*g", digits, value);
}

std::string Padded(std::string text) {
  text.resize(std::max(text.size() + 1, kNameWidth), ' ');
  return text;
}

}  // namespace

json::object ToJson(const core::Isolability& isolability) {
  const auto smallest_json = [](const core::SmallestVisible& one) {
    return json::object{{"component", core::Name(one.component)},
                        {"nominal", one.nominal},
                        {"unit", core::Unit(one.component)},
                        {"below", NumberOrNull(one.below)},
                        {"above", NumberOrNull(one.above)},
                        {"relative_sigma", NumberOrNull(one.relative_sigma)}};
  };
  std::vector<core::Component> components;
  for (const core::SmallestVisible& one : isolability.smallest) components.push_back(one.component);
  return {{"components", ComponentNames(components)},
          {"fisher", Rows(isolability.fisher)},
          {"overlap", Rows(isolability.overlap)},
          {"smallest", ListOf(isolability.smallest, smallest_json)},
          {"faults", ListOf(isolability.faults, FaultJson)},
          {"ambiguous", ListOf(isolability.ambiguous, ComponentNames)},
          {"kl_visible", NumberOrNull(isolability.kl_visible_nats)},
          {"kl_separable", NumberOrNull(isolability.kl_separable_nats)}};
}

std::string ToText(const core::Isolability& isolability) {
  std::string out = Padded("Fault") + Padded("seen") + "can be taken for\n";
  for (const core::FaultIsolability& fault : isolability.faults) {
    const std::string name = std::string(core::Name(fault.fault.component)) + " = " +
                             Significant(fault.fault.value, kValueDigits) + " " +
                             std::string(core::Unit(fault.fault.component));
    std::string rivals;
    for (std::size_t i = 1; i < fault.group.size(); ++i) {
      rivals += (rivals.empty() ? "" : ", ") + std::string(core::Name(fault.group[i]));
    }
    const std::string seen =
        (fault.visible ? "yes, " : "no, ") + Significant(fault.kl_nominal_nats) + " nats";
    out += Padded(name) + Padded(seen) + (rivals.empty() ? "nothing else" : rivals) + "\n";
  }
  out += "\n" + Padded("Smallest visible fault") + "below nominal    above nominal    best error\n";
  for (const core::SmallestVisible& one : isolability.smallest) {
    constexpr double kPercent = 100.0;
    const auto value = [](const std::optional<double>& limit) {
      std::string text = limit ? Significant(*limit, kValueDigits) : "none";
      text.resize(17, ' ');
      return text;
    };
    out += Padded(std::string(core::Name(one.component)) + " (nominal " +
                  Significant(one.nominal, kValueDigits) + ")") +
           value(one.below) + value(one.above) +
           (std::isfinite(one.relative_sigma) ? Significant(kPercent * one.relative_sigma) + " %"
                                              : "none") +
           "\n";
  }
  for (const std::vector<core::Component>& group : isolability.ambiguous) {
    out += "No amount of this data tells apart:";
    for (const core::Component component : group) {
      out += " " + std::string(core::Name(component));
    }
    out += "\n";
  }
  return out;
}

}  // namespace faultlab::server
