#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <string>
#include <string_view>

#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/number_or_null.h"
#include "server/story/run_story.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::string_view Name(StoryDetection::Of of) {
  constexpr std::array<std::string_view, 3> kNames = {"first", "further", "return"};
  return kNames[static_cast<std::size_t>(of)];
}

/// `each` of the newest `most`.
template <typename List, typename Make>
json::array Newest(const List& list, std::size_t most, Make make) {
  json::array out;
  const std::size_t from = list.size() - std::min(most, list.size());
  for (std::size_t i = from; i < list.size(); ++i) out.push_back(make(list[i]));
  return out;
}

json::value ChangeJson(const RigChange& change) {
  return {{"component", core::Name(change.component)},
          {"value", change.value},
          {"before", change.before},
          {"at_s", change.at_s},
          {"nominal", change.nominal},
          {"others", ComponentNames(change.others)}};
}

/// What is named: the best candidate, or all that look alike, which come first in the list.
json::object FindingJson(const core::FaultEpisode& found) {
  core::Verdict verdict = found.verdict;
  const std::size_t named = std::max<std::size_t>(1, verdict.group.size());
  if (verdict.candidates.size() > named) verdict.candidates.resize(named);
  verdict.path.clear();
  json::object out = ToJson(verdict);
  for (const char* of_the_verdict_alone : {"path", "detector", "reason", "settled"}) {
    out.erase(of_the_verdict_alone);
  }
  out["ended_at_s"] = NumberOrNull(found.ended_at_s);
  return out;
}

}  // namespace

json::object ToJson(const RunStory& story, std::size_t most) {
  const auto detection = [](const StoryDetection& each) -> json::value {
    return {{"detected_at_s", each.at_s},
            {"delay_s", NumberOrNull(each.delay_s)},
            {"isolated_at_s", NumberOrNull(each.isolated_s)},
            {"named", ComponentNames(each.named)},
            {"of", Name(each.of)}};
  };
  const auto episode = [&](const StoryEpisode& each) -> json::value {
    return {{"onset_s", each.onset_s},
            {"since_s", each.since_s()},
            {"ended_s", NumberOrNull(each.ended_s)},
            {"changes", Newest(each.changes, most, ChangeJson)},
            {"detections", Newest(each.detections, most, detection)},
            {"finding", each.found ? json::value(FindingJson(*each.found)) : json::value(nullptr)}};
  };
  return {{"episodes", Newest(story.episodes, most, episode)},
          {"changes", Newest(story.changes, most, ChangeJson)},
          {"change_times_s",
           Newest(story.ChangeTimes(), 2 * most, [](double t_s) -> json::value { return t_s; })},
          {"set_back", story.set_back}};
}

std::string StoryText(const RunStory& story, std::size_t most) {
  return json::serialize(ToJson(story, most));
}

}  // namespace faultlab::server
