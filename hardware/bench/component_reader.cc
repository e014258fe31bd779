#include "hardware/bench/component_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hardware/bench/value_bounds.h"
#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

using core::Bench;
using core::ComponentInfo;

constexpr int kLinesMax = 32;
/// Values of one list: each is judged one by one, and a person chooses among them.
constexpr std::size_t kValuesMax = 32;
/// Two values that differ by less are one.
constexpr double kSameShare = 1e-6;

bool AreSame(double a, double b) {
  return std::abs(a - b) <= kSameShare * std::abs(b);
}

bool IsSymbol(const std::string& text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && text.size() <= core::kSymbolBytesMax && letter(text.front()) &&
         std::ranges::all_of(
             text, [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

/// What other components of the file have taken already.
struct Taken {
  std::map<int, std::string> lines;       ///< and the component that they belong to
  std::map<int, std::string> parameters;  ///< the same
};

void ReadSymbol(TomlTable& table, const Bench& bench, ComponentInfo& part) {
  table.Text("symbol", part.symbol);
  if (part.symbol.empty()) table.Refuse("symbol", "is missing");
  if (!IsSymbol(part.symbol)) {
    table.Refuse("symbol",
                 "must be of A-Z, a-z, 0-9 and _, begin with a letter, at most " +
                     std::to_string(core::kSymbolBytesMax) + " characters");
  }
  if (bench.Find(part.symbol)) table.Refuse("symbol", "stands twice in this file");
}

/// A parameter that two components change would make each show the other's fault.
void Take(TomlTable& table,
          const std::string& key,
          int parameter,
          const Bench& bench,
          const std::string& symbol,
          Taken& taken) {
  const auto [at, fresh] = taken.parameters.emplace(parameter, symbol);
  if (fresh) return;
  const auto which = static_cast<std::size_t>(parameter);
  table.Refuse(table.Has(key) ? key : "symbol",
               "is " + std::string(bench.structure->parameters[which].symbol) +
                   ", which the component " + at->second +
                   " changes already: one component for each parameter");
}

void ReadParameter(TomlTable& table, const Bench& bench, Taken& taken, ComponentInfo& part) {
  std::string changes = part.symbol;
  std::string with;
  table.Text("changes", changes);
  table.Text("and_with_it", with);
  const int first = bench.structure->drives_current() ? core::kRa : core::kSeries;
  part.parameter = bench.structure->Find(changes);
  part.coupled = with.empty() ? -1 : bench.structure->Find(with);
  const std::string key = table.Has("changes") ? "changes" : "symbol";
  if (part.parameter < first) {
    std::string all;
    for (const core::ParameterInfo& each :
         bench.structure->parameters.subspan(static_cast<std::size_t>(first))) {
      all += (all.empty() ? "" : ", ") + std::string(each.symbol);
    }
    table.Refuse(key,
                 "must be a parameter of the structure: " + all +
                     (key == "symbol" ? "; `changes` names it when the symbol is another" : ""));
  }
  if (!with.empty() && (part.parameter >= core::kMotorParameters || part.coupled < 0 ||
                        part.coupled >= core::kMotorParameters || part.coupled == part.parameter)) {
    table.Refuse("and_with_it", "must be another parameter of the motor, such as KT beside Ke");
  }
  Take(table, "changes", part.parameter, bench, part.symbol, taken);
  if (part.coupled >= 0) Take(table, "and_with_it", part.coupled, bench, part.symbol, taken);
  const auto which = static_cast<std::size_t>(part.parameter);
  const core::ParameterInfo& info = bench.structure->parameters[which];
  part.unit = info.unit;
  part.kind = info.kind;
  part.nominal = bench.nominal.Get(part.parameter);
  if (!(part.nominal > 0.0)) table.Refuse(key, "is 0 in [plant]: there is no such part");
  if (part.coupled >= 0) part.coupled_ratio = bench.nominal.Get(part.coupled) / part.nominal;
}

void ReadRange(TomlTable& table, ComponentInfo& part) {
  constexpr double kReach = 1e3;
  std::vector<double> range = {part.nominal / kReach, part.nominal * kReach};
  table.Numbers("range", range, kValueMin, kValueMax);
  if (range.size() != 2 || !(range[0] < range[1])) {
    table.Refuse("range", "must be two numbers, the smaller first");
  }
  part.value_min = range[0];
  part.value_max = range[1];
  table.Integer("scan_points", part.scan_points, 8, 200);
  table.Number("least_visible", part.least_visible, 0.0, kValueMax);
  // Of a part that is below its least visible value, the diagnosis looks for larger ones only.
  const bool sees_no_nominal = part.least_visible > part.nominal;
  if (part.nominal > part.value_max || (part.nominal < part.value_min && !sees_no_nominal)) {
    table.Refuse("range",
                 "must have the nominal value " + Number(part.nominal) + " of [plant] inside");
  }
}

/// Values of faults, `values` without the nominal one that they begin with.
void CheckFaults(TomlTable& table,
                 const std::string& key,
                 const std::vector<double>& values,
                 const ComponentInfo& part) {
  if (values.size() > kValuesMax) {
    table.Refuse(key, "must be at most " + std::to_string(kValuesMax) + " values");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    if (AreSame(value, part.nominal)) {
      table.Refuse(key, "must not hold the nominal value: " + Number(value) + " is no fault");
    }
    if (value < part.value_min || value > part.value_max) {
      table.Refuse(key,
                   "must lie inside `range`, where a diagnosis looks: " + Number(value) +
                       " is outside " + Number(part.value_min) + " to " + Number(part.value_max));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (AreSame(value, values[j])) table.Refuse(key, "holds " + Number(value) + " twice");
    }
  }
}

/// The values that relays connect and their lines.
void ReadPositions(TomlTable& table, Taken& taken, ComponentInfo& part) {
  std::vector<double> values;
  std::vector<int> lines;
  table.Numbers("values", values, kValueMin, kValueMax);
  table.Integers("lines", lines, 0, kLinesMax - 1);
  if (values.empty() && lines.empty()) return;
  if (values.size() != lines.size() || values.size() < 2) {
    table.Refuse("lines", "must be as many as `values`, two or more: one line for each value");
  }
  if (!AreSame(values.front(), part.nominal)) {
    table.Refuse("values", "must begin with the nominal value of [plant]");
  }
  CheckFaults(table, "values", {values.begin() + 1, values.end()}, part);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [at, fresh] = taken.lines.emplace(lines[i], part.symbol);
    if (!fresh) {
      table.Refuse(
          "lines",
          "uses line " + std::to_string(lines[i]) + ", which is in use already by " + at->second);
    }
    part.positions.push_back({values[i], lines[i]});
  }
}

void ReadComponent(TomlTable& table, Taken& taken, Bench& bench) {
  ComponentInfo part;
  part.index = bench.component_count();
  ReadSymbol(table, bench, part);
  ReadParameter(table, bench, taken, part);
  ReadRange(table, part);
  ReadPositions(table, taken, part);
  part.order = static_cast<core::SwitchOrder>(
      table.Choice("order", 0, {"break before make", "make before break"}));
  table.Numbers("offered", part.offered, kValueMin, kValueMax);
  CheckFaults(table, "offered", part.offered, part);
  table.Numbers("published", part.published, kValueMin, kValueMax);
  CheckFaults(table, "published", part.published, part);
  bench.parts.push_back(std::move(part));
}

}  // namespace

void ReadComponents(TomlTable& root, Bench& bench) {
  const std::vector<TomlTable*> tables = root.Subs("component");
  if (tables.empty() || tables.size() > core::kComponentsMax) {
    root.Refuse(
        "component",
        "must stand 1 to " + std::to_string(core::kComponentsMax) + " times: [[component]]");
  }
  Taken taken;
  for (TomlTable* table : tables) ReadComponent(*table, taken, bench);
}

}  // namespace faultlab::hardware
