#include "server/api/bench/bench_json.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/diagnosis/diagnosis_options.h"
#include "core/paper/paper_tables.h"
#include "core/plant/coefficients.h"
#include "hardware/relay_board.h"
#include "server/experiment/experiment_plan.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Component;

struct MotorValue {
  Component component;
  double value;
};
/// What simulators offer beside the motor faults of the paper.
constexpr std::array<MotorValue, 3> kMoreMotorValues = {
    {{Component::kRa, 14.8}, {Component::kJ, 1.43e-5}, {Component::kB, 1.8e-8}}};

/// A smaller change of a model parameter is lost in the estimators' noise.
constexpr double kSeenChange = 1e-3;

json::array ToArray(const std::array<double, 3>& values) {
  return {values[0], values[1], values[2]};
}

/// Nominal first, then rising.
std::vector<double> MotorValues(Component component, double nominal) {
  std::vector<double> values{nominal};
  for (const core::PaperFault& fault : core::PrintedFaults()) {
    if (fault.component == component) values.push_back(fault.value);
  }
  for (const MotorValue& more : kMoreMotorValues) {
    if (more.component == component) values.push_back(more.value);
  }
  std::sort(values.begin() + 1, values.end());
  return values;
}

json::array RelayValuesToJson(Component component) {
  const hardware::RelayWiring wiring;
  const auto& boards = hardware::kRelayComponents;
  const auto board = std::find(boards.begin(), boards.end(), component) - boards.begin();
  const auto& lines = wiring.line[static_cast<std::size_t>(board)];
  json::array out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out.push_back(json::object{{"value", core::RelayValues(component)[i]},
                               {"line", "Do" + std::to_string(lines[i])}});
  }
  return out;
}

json::array MotorValuesToJson(Component component, double nominal) {
  json::array out;
  for (const double value : MotorValues(component, nominal)) {
    out.push_back(json::object{{"value", value}, {"line", nullptr}});
  }
  return out;
}

/// The model parameters that one of `values` moves visibly.
json::array MovedBy(Component component, const json::array& values) {
  const core::ContinuousCoefficients nominal = core::MakeContinuous(core::PlantParameters{});
  struct Moved {
    const char* name;
    double core::ContinuousCoefficients::*parameter;
  };
  constexpr std::array<Moved, 3> kParameters = {{{"b0", &core::ContinuousCoefficients::b0},
                                                 {"b1", &core::ContinuousCoefficients::b1},
                                                 {"a1", &core::ContinuousCoefficients::a1}}};
  json::array out;
  for (const Moved& moved : kParameters) {
    const bool seen = std::any_of(values.begin(), values.end(), [&](const json::value& each) {
      core::PlantParameters plant;
      plant.Set(component, each.at("value").as_double());
      const double after = core::MakeContinuous(plant).*moved.parameter;
      const double before = nominal.*moved.parameter;
      return std::abs(after - before) > kSeenChange * std::abs(before);
    });
    if (seen) out.push_back(moved.name);
  }
  return out;
}

json::object ComponentToJson(Component component) {
  const double nominal = core::PlantParameters{}.Get(component);
  const bool relay = core::IsRelaySwitched(component);
  json::array values = relay ? RelayValuesToJson(component) : MotorValuesToJson(component, nominal);
  json::array moves = MovedBy(component, values);
  return {{"symbol", core::Name(component)},
          {"unit", core::Unit(component)},
          {"switched_by", relay ? "relay" : "simulator"},
          {"nominal", nominal},
          {"values", std::move(values)},
          {"moves", std::move(moves)}};
}

json::object PublishedToJson() {
  json::array faults;
  for (const core::PaperFault& fault : core::PrintedFaults()) {
    faults.push_back(json::object{{"component", core::Name(fault.component)},
                                  {"value", fault.value},
                                  {"swa", ToArray(fault.swa)},
                                  {"sia", ToArray(fault.sia)},
                                  {"identified", fault.identified},
                                  {"tables",
                                   {{"swa", fault.swa_table},
                                    {"sia", fault.sia_table},
                                    {"identified", fault.identified_table}}}});
  }
  return {{"source", "doi:10.3390/app15158322"}, {"faults", std::move(faults)}};
}

}  // namespace

json::object PaperBenchToJson() {
  const core::DiagnosisOptions pipeline;
  json::array components;
  for (const Component component : core::kAllComponents) {
    components.push_back(ComponentToJson(component));
  }
  return {{"id", kPaperBench},
          {"period_s", core::kSamplePeriodSeconds},
          {"healthy", {{"from_s", pipeline.healthy_from_s}, {"to_s", pipeline.healthy_to_s}}},
          {"run", {{"min_s", kRunSecondsMin}, {"max_s", kRunSecondsMax}}},
          {"components", std::move(components)},
          {"published", PublishedToJson()}};
}

json::object ModelToJson(const core::PlantParameters& plant, double period_s, double delta_s) {
  const core::ContinuousCoefficients continuous = core::MakeContinuous(plant);
  const core::DiscreteCoefficients discrete = core::Discretise(continuous, period_s, delta_s);
  return {{"period_s", period_s},
          {"delta_s", delta_s},
          {"swa", ToArray({discrete.b0d, discrete.b1d, discrete.a1d})},
          {"sia", ToArray({continuous.b0, continuous.b1, continuous.a1})}};
}

}  // namespace faultlab::server
