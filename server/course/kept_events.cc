#include "server/course/kept_events.h"

#include <boost/json.hpp>

#include "server/json/list_of.h"

namespace faultlab::server::course {

namespace json = boost::json;

std::string EventsText(std::span<const RecordedEvent> events) {
  return json::serialize(ListOf(events, [](const RecordedEvent& event) {
    return json::object{{"index", event.index}, {"kind", event.kind}, {"json", event.json}};
  }));
}

std::vector<RecordedEvent> ParseEvents(const std::string& text) {
  const json::value parsed = json::parse(text);
  std::vector<RecordedEvent> events;
  for (const json::value& each : parsed.as_array()) {
    events.push_back({each.at("index").to_number<std::int64_t>(),
                      std::string(each.at("kind").as_string()),
                      std::string(each.at("json").as_string())});
  }
  return events;
}

}  // namespace faultlab::server::course
