#pragma once

#include <boost/json/object.hpp>
#include <optional>

#include "core/bench/bench.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "server/json/document_reader.h"

namespace faultlab::server {

/// Adds "nominal":{"R1":..,"R9",..}, which the components of `bench` change, and
/// "constants":{"Ke":..}, the other parameters of its structure.
void AddPlant(const core::PlantParameters& plant,
              const core::Bench& bench,
              boost::json::object& out);

/// Reads the output of AddPlant, for `bench`. Refuses values that are missing or not above 0. A
/// value that the document may omit (gear) is taken from the data sheet.
core::PlantParameters ReadPlant(DocumentReader& document,
                                const core::Bench& bench,
                                std::optional<core::Error>& error);

}  // namespace faultlab::server
