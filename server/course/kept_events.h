#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/storage/recording_store.h"

namespace faultlab::server::course {

/// Trial::events: [{"index", "kind", "json"}]
std::string EventsText(std::span<const RecordedEvent> events);
std::vector<RecordedEvent> ParseEvents(const std::string& text);

}  // namespace faultlab::server::course
