#include "server/methods/method_run_json.h"

#include <array>
#include <boost/json/array.hpp>
#include <cmath>
#include <cstdio>

#include "server/json/number_or_null.h"

namespace faultlab::server {

namespace json = boost::json;

json::object ToJson(const core::MethodRun& run) {
  const core::MethodInfo* info = core::FindMethod(run.method);
  json::array looks;
  for (const core::MethodLook& look : run.looks) {
    json::array answer;
    for (std::size_t i = 0; i < look.finding.named; ++i) {
      const core::MethodCandidate& named = look.finding.candidates[i];
      answer.emplace_back(json::object{{"component", core::Name(named.component)},
                                       {"value", NumberOrNull(named.value)},
                                       {"unit", core::Unit(named.component)}});
    }
    looks.emplace_back(json::object{{"after_s", look.after_s},
                                    {"isolation", core::Name(look.finding.isolation)},
                                    {"identification", core::Name(look.finding.identification)},
                                    {"answer", std::move(answer)}});
  }
  return {{"method", run.method},
          {"title", info != nullptr ? info->title : run.method},
          {"detected_at_s", run.alarmed_at_s ? json::value(*run.alarmed_at_s) : nullptr},
          {"looks", std::move(looks)}};
}

std::string ToText(const core::MethodRun& run, const std::string& file) {
  const std::string head = file + ": " + std::string(run.method) + ": ";
  if (!run.alarmed_at_s) return head + "no alarm\n";
  std::array<char, 120> text;
  std::snprintf(text.data(), text.size(), "alarm at %.2f s\n", *run.alarmed_at_s);
  std::string out = head + text.data();
  for (const core::MethodLook& look : run.looks) {
    std::snprintf(text.data(), text.size(), "  %6.2f s later: ", look.after_s);
    out += text.data();
    if (look.finding.isolation != core::Answer::kGiven) {
      out += look.finding.isolation == core::Answer::kCannot ? "cannot isolate\n" : "no answer\n";
      continue;
    }
    for (std::size_t i = 0; i < look.finding.named; ++i) {
      const core::MethodCandidate& named = look.finding.candidates[i];
      out += (i > 0 ? " or " : "") + std::string(core::Name(named.component));
      if (!std::isfinite(named.value)) continue;
      std::snprintf(text.data(),
                    text.size(),
                    " = %.4g %s",
                    named.value,
                    std::string(core::Unit(named.component)).c_str());
      out += text.data();
    }
    out += look.finding.identification == core::Answer::kCannot ? " (cannot size it)\n" : "\n";
  }
  return out;
}

}  // namespace faultlab::server
