#include "server/api/run/found_json.h"

#include <algorithm>

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kFindingsMax = 8;

json::value MemberOr(const json::object& of, std::string_view name, json::value fallback) {
  const json::value* found = of.if_contains(name);
  return found != nullptr ? *found : fallback;
}

/// The best candidate, or all that look alike: they come first in the list.
json::object FindingOf(const json::object& verdict) {
  const json::array group = MemberOr(verdict, "group", json::array{}).as_array();
  json::array named = MemberOr(verdict, "candidates", json::array{}).as_array();
  const std::size_t most = std::max<std::size_t>(1, group.size());
  if (named.size() > most) named.resize(most);
  json::object out{{"verdict", MemberOr(verdict, "verdict", "calibrating")},
                   {"detected_at_s", MemberOr(verdict, "detected_at_s", nullptr)},
                   {"onset_s", MemberOr(verdict, "onset_s", nullptr)},
                   {"ended_at_s", MemberOr(verdict, "ended_at_s", nullptr)},
                   {"group", group},
                   {"candidates", std::move(named)}};
  for (const char* optional : {"further", "sensor"}) {
    if (verdict.contains(optional)) out[optional] = verdict.at(optional);
  }
  return out;
}

}  // namespace

json::array ChangesToJson(std::span<const RecordedEvent> changes) {
  json::array out;
  for (const RecordedEvent& change : changes) {
    boost::system::error_code ec;
    const json::value parsed = json::parse(change.json, ec);
    const json::object* event = ec ? nullptr : parsed.if_object();
    if (event == nullptr || !event->contains("component")) continue;
    out.push_back(json::object{{"component", event->at("component")},
                               {"value", MemberOr(*event, "value", nullptr)},
                               {"at_s", MemberOr(*event, "t_s", nullptr)}});
  }
  return out;
}

json::array FindingsToJson(std::string_view diagnosis_json) {
  json::array out;
  boost::system::error_code ec;
  const json::value parsed = json::parse(diagnosis_json, ec);
  const json::object* diagnosis = ec ? nullptr : parsed.if_object();
  if (diagnosis == nullptr) return out;
  const json::value episodes = MemberOr(*diagnosis, "episodes", nullptr);
  if (const json::array* list = episodes.if_array()) {
    for (const json::value& episode : *list) {
      if (out.size() == kFindingsMax) break;
      if (episode.is_object()) out.push_back(FindingOf(episode.get_object()));
    }
  } else if (!MemberOr(*diagnosis, "detected_at_s", nullptr).is_null()) {
    out.push_back(FindingOf(*diagnosis));
  }
  return out;
}

}  // namespace faultlab::server
