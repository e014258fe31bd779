#include "server/api/bench/bench_json.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/diagnosis/diagnosis_options.h"
#include "core/plant/coefficients.h"
#include "server/experiment/control_json.h"
#include "server/experiment/plan_json.h"
#include "server/json/list_of.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Component;

/// A smaller change of a model parameter is lost in the estimators' noise.
constexpr double kSeenChange = 1e-3;

json::array RelayValuesToJson(Component component) {
  return ListOf(component.info().positions, [](const core::SwitchPosition& position) {
    return json::object{{"value", position.value}, {"line", "Do" + std::to_string(position.line)}};
  });
}

/// Nominal first, then rising.
json::array OfferedToJson(Component component, double nominal) {
  std::vector<double> values{nominal};
  for (const double value : component.info().offered) values.push_back(value);
  std::sort(values.begin() + 1, values.end());
  return ListOf(values, [](double value) {
    return json::object{{"value", value}, {"line", nullptr}};
  });
}

/// The model parameters that one of `values` moves visibly.
json::array MovedBy(const core::Bench& bench, Component component, const json::array& values) {
  const core::ContinuousCoefficients nominal = core::MakeContinuous(bench.nominal);
  struct Moved {
    const char* name;
    double core::ContinuousCoefficients::*parameter;
  };
  constexpr std::array<Moved, 3> kParameters = {{{"b0", &core::ContinuousCoefficients::b0},
                                                 {"b1", &core::ContinuousCoefficients::b1},
                                                 {"a1", &core::ContinuousCoefficients::a1}}};
  json::array out;
  for (const Moved& moved : kParameters) {
    const bool seen = std::ranges::any_of(values, [&](const json::value& each) {
      core::PlantParameters plant = bench.nominal;
      plant.Set(component, each.at("value").as_double());
      const double after = core::MakeContinuous(plant).*moved.parameter;
      const double before = nominal.*moved.parameter;
      return std::abs(after - before) > kSeenChange * std::abs(before);
    });
    if (seen) out.push_back(moved.name);
  }
  return out;
}

const core::ParameterInfo& ParameterOf(const core::Bench& bench, Component component) {
  return bench.structure->parameters[static_cast<std::size_t>(component.info().parameter)];
}

json::object ComponentToJson(const core::Bench& bench, Component component) {
  const double nominal = bench.nominal.Get(component);
  const bool relay = core::IsSwitched(component);
  json::array values = relay ? RelayValuesToJson(component) : OfferedToJson(component, nominal);
  json::array moves = MovedBy(bench, component, values);
  return {{"symbol", core::Name(component)},
          {"unit", core::Unit(component)},
          {"changes", ParameterOf(bench, component).symbol},
          {"meaning", ParameterOf(bench, component).meaning},
          {"switched_by", relay ? "relay" : "simulator"},
          {"nominal", nominal},
          {"values", std::move(values)},
          {"moves", std::move(moves)}};
}

/// What the description says was published; null when it says nothing.
json::value PublishedToJson(const core::Bench& bench) {
  if (bench.published.faults.empty()) return nullptr;
  const auto fault_to_json = [](const core::PublishedFault& fault) {
    return json::object{
        {"component", fault.component},
        {"value", fault.value},
        {"swa", ListOf(fault.swa)},
        {"sia", ListOf(fault.sia)},
        {"identified", fault.identified},
        {"tables",
         {{"swa", fault.tables[0]}, {"sia", fault.tables[1]}, {"identified", fault.tables[2]}}}};
  };
  return json::object{{"source", bench.published.source},
                      {"faults", ListOf(bench.published.faults, fault_to_json)}};
}

json::object ChannelToJson(const core::BenchChannel& channel) {
  json::object out{{"exists", channel.exists}, {"min", nullptr}, {"max", nullptr}};
  if (channel.exists) {
    out["min"] = channel.min;
    out["max"] = channel.max;
  }
  return out;
}

json::array ParametersToJson(const core::Bench& bench) {
  json::array out;
  for (int i = 0; i < bench.structure->parameter_count(); ++i) {
    const core::ParameterInfo& info = bench.structure->parameters[static_cast<std::size_t>(i)];
    out.push_back(json::object{{"symbol", info.symbol},
                               {"unit", info.unit},
                               {"value", bench.nominal.Get(i)},
                               {"meaning", info.meaning}});
  }
  return out;
}

/// Where charts of the estimates begin: around nominal, and 0 in sight.
json::object RangesToJson(const core::Bench& bench) {
  const core::ContinuousCoefficients model = core::MakeContinuous(bench.nominal);
  const core::DiscreteCoefficients discrete =
      core::Discretise(model, bench.period_s, bench.delta_s);
  const auto range = [](double nominal) {
    constexpr double kRoom = 1.5;
    return json::array{std::min(0.0, kRoom * nominal), std::max(0.0, kRoom * nominal)};
  };
  return {{"b0d", range(discrete.b0d)},
          {"b1d", range(discrete.b1d)},
          {"a1d", range(discrete.a1d)},
          {"b0", range(model.b0)},
          {"b1", range(model.b1)},
          {"a1", range(model.a1)}};
}

}  // namespace

json::object BenchToJson(const core::Bench& bench) {
  const core::DiagnosisOptions pipeline = core::OptionsOf(bench);
  const auto component_to_json = [&](Component component) {
    return ComponentToJson(bench, component);
  };
  const core::EstimatedChannelInfo& estimated = core::InfoOf(bench.structure->estimated);
  return {{"id", bench.id},
          {"name", bench.name},
          {"title", bench.title},
          {"structure", {{"name", bench.structure->name}, {"title", bench.structure->title}}},
          {"period_s", bench.period_s},
          {"delta_s", bench.delta_s},
          {"gear_ratio", bench.nominal.gear_ratio},
          {"excitation", ToJson(bench.excitation)},
          {"input", {{"min_v", bench.limits.uc_v_min}, {"max_v", bench.limits.uc_v_max}}},
          {"channels",
           {{"um", ChannelToJson(bench.um)},
            {"ua", ChannelToJson(bench.ua)},
            {"ia", ChannelToJson(bench.ia)},
            {"n", ChannelToJson(bench.n)}}},
          {"estimated", {{"channel", estimated.name}, {"unit", estimated.unit}}},
          {"estimate_ranges", RangesToJson(bench)},
          {"parameters", ParametersToJson(bench)},
          {"healthy", {{"from_s", pipeline.healthy_from_s}, {"to_s", pipeline.healthy_to_s}}},
          {"run", {{"min_s", kRunSecondsMin}, {"max_s", kRunSecondsMax}}},
          {"control", ControlOf(bench)},
          {"components", ListOf(bench.components(), component_to_json)},
          {"published", PublishedToJson(bench)}};
}

json::object ModelToJson(const core::PlantParameters& plant, double period_s, double delta_s) {
  const core::ContinuousCoefficients continuous = core::MakeContinuous(plant);
  const core::DiscreteCoefficients discrete = core::Discretise(continuous, period_s, delta_s);
  return {{"period_s", period_s},
          {"delta_s", delta_s},
          {"swa", json::array{discrete.b0d, discrete.b1d, discrete.a1d}},
          {"sia", json::array{continuous.b0, continuous.b1, continuous.a1}}};
}

}  // namespace faultlab::server
