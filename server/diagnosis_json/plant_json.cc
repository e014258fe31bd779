#include "server/diagnosis_json/plant_json.h"

#include <algorithm>
#include <string_view>
#include <vector>

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kAboveZero = 1e-18;

/// Parameters of the structure that no component of the bench changes, in the order in which they
/// are written.
std::vector<int> ConstantsOf(const core::Bench& bench) {
  std::vector<int> order = {
      core::kKe, core::kKt, core::kLa, core::kSeries, core::kRa, core::kJ, core::kB};
  for (int i = core::kMotorParameters; i < bench.structure->parameter_count(); ++i) {
    order.push_back(i);
  }
  std::erase_if(order, [&](int parameter) {
    if (parameter == core::kSeries && bench.structure->drives_current()) return true;
    return std::ranges::any_of(
        bench.parts, [&](const core::ComponentInfo& part) { return part.parameter == parameter; });
  });
  return order;
}

std::string_view SymbolOf(const core::Bench& bench, int parameter) {
  return bench.structure->parameters[static_cast<std::size_t>(parameter)].symbol;
}

/// The least value of a parameter: a bench may have no series resistor.
double LeastOf(const core::Bench& bench, int parameter) {
  return bench.nominal.Get(parameter) > 0.0 ? kAboveZero : 0.0;
}

}  // namespace

void AddPlant(const core::PlantParameters& plant, const core::Bench& bench, json::object& out) {
  json::object nominal;
  for (const core::Component component : bench.components()) {
    nominal[core::Name(component)] = plant.Get(component);
  }
  json::object constants;
  for (const int parameter : ConstantsOf(bench)) {
    constants[SymbolOf(bench, parameter)] = plant.Get(parameter);
  }
  out["nominal"] = std::move(nominal);
  out["constants"] = std::move(constants);
}

core::PlantParameters ReadPlant(DocumentReader& document,
                                const core::Bench& bench,
                                std::optional<core::Error>& error) {
  core::PlantParameters plant = bench.nominal;
  DocumentReader nominal(document.Object("nominal"), "nominal/", error);
  for (const core::Component component : bench.components()) {
    const double value = nominal.Number(core::Name(component), kAboveZero);
    // Smaller values have already been refused. Coupled parameters are among the constants.
    if (value >= kAboveZero) plant.Set(component.info().parameter, value);
  }
  DocumentReader constants(document.Object("constants"), "constants/", error);
  for (const int parameter : ConstantsOf(bench)) {
    plant.Set(parameter, constants.Number(SymbolOf(bench, parameter), LeastOf(bench, parameter)));
  }
  return plant;
}

}  // namespace faultlab::server
