#pragma once

#include <boost/json/object.hpp>
#include <optional>

#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "server/json/document_reader.h"

namespace faultlab::server {

/// Adds "nominal":{"R1":..,"R9",..}, the seven components, and "constants":{"Ke":..}, the rest.
void AddPlant(const core::PlantParameters& plant, boost::json::object& out);

/// Reads what AddPlant wrote. Refuses what is missing or not above 0.
core::PlantParameters ReadPlant(DocumentReader& document, std::optional<core::Error>& error);

}  // namespace faultlab::server
