#include "server/course/hints.h"

#include <algorithm>
#include <boost/json.hpp>
#include <string>
#include <vector>

#include "core/types/component.h"

namespace faultlab::server::course {

namespace json = boost::json;

json::object HintOf(int number, const core::Diagnosis& diagnosis) {
  const core::Verdict& verdict = diagnosis.verdict;
  if (number == 0) {
    return {{"kind", "when"},
            {"at_s", verdict.detected_at_s ? json::value(*verdict.detected_at_s) : nullptr}};
  }
  // By their names: their order would tell which of them is the most likely.
  std::vector<std::string> names;
  for (const core::Candidate& each : verdict.candidates) {
    if (names.size() < kHintParts) names.emplace_back(core::Name(each.component));
  }
  std::ranges::sort(names);
  return {{"kind", "parts"}, {"components", json::array(names.begin(), names.end())}};
}

}  // namespace faultlab::server::course
