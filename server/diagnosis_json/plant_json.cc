#include "server/diagnosis_json/plant_json.h"

#include <array>
#include <string_view>

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kAboveZero = 1e-18;

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

}  // namespace

void AddPlant(const core::PlantParameters& plant, json::object& out) {
  json::object nominal;
  for (const core::Component component : core::kAllComponents) {
    nominal[core::Name(component)] = plant.Get(component);
  }
  json::object constants;
  for (const Constant& constant : kConstants) {
    constants[constant.name] = plant.*constant.member;
  }
  out["nominal"] = std::move(nominal);
  out["constants"] = std::move(constants);
}

core::PlantParameters ReadPlant(DocumentReader& document, std::optional<core::Error>& error) {
  core::PlantParameters plant;
  DocumentReader nominal(document.Object("nominal"), "nominal/", error);
  for (const core::Component component : core::kAllComponents) {
    const double value = nominal.Number(core::Name(component), kAboveZero);
    if (value >= kAboveZero) plant.Set(component, value);  // refused already otherwise
  }
  DocumentReader constants(document.Object("constants"), "constants/", error);
  for (const Constant& constant : kConstants) {
    plant.*constant.member = constants.Number(constant.name, kAboveZero);
  }
  return plant;
}

}  // namespace faultlab::server
