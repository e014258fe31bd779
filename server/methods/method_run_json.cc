#include "server/methods/method_run_json.h"

#include <cmath>
#include <span>

#include "core/types/number_text.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {

namespace json = boost::json;

json::object ToJson(const core::MethodRun& run) {
  const core::MethodInfo* info = core::FindMethod(run.method);
  const auto named_to_json = [](const core::MethodCandidate& named) {
    return json::object{{"component", core::Name(named.component)},
                        {"value", NumberOrNull(named.value)},
                        {"unit", core::Unit(named.component)}};
  };
  const auto look_to_json = [&](const core::MethodLook& look) {
    const auto named = std::span(look.finding.candidates).first(look.finding.named);
    return json::object{{"after_s", look.after_s},
                        {"isolation", core::Name(look.finding.isolation)},
                        {"identification", core::Name(look.finding.identification)},
                        {"answer", ListOf(named, named_to_json)}};
  };
  return {{"method", run.method},
          {"title", info != nullptr ? info->title : run.method},
          {"detected_at_s", run.alarmed_at_s ? json::value(*run.alarmed_at_s) : nullptr},
          {"looks", ListOf(run.looks, look_to_json)}};
}

std::string ToText(const core::MethodRun& run, const std::string& file) {
  const std::string head = file + ": " + std::string(run.method) + ": ";
  if (!run.alarmed_at_s) return head + "no alarm\n";
  std::string out = head + core::Format("alarm at %.2f s\n", *run.alarmed_at_s);
  for (const core::MethodLook& look : run.looks) {
    out += core::Format("  %6.2f s later: ", look.after_s);
    if (look.finding.isolation != core::Answer::kGiven) {
      out += look.finding.isolation == core::Answer::kCannot ? "cannot isolate\n" : "no answer\n";
      continue;
    }
    for (std::size_t i = 0; i < look.finding.named; ++i) {
      const core::MethodCandidate& named = look.finding.candidates[i];
      out += (i > 0 ? " or " : "") + std::string(core::Name(named.component));
      if (!std::isfinite(named.value)) continue;
      const std::string unit(core::Unit(named.component));
      out += core::Format(" = %.4g %s", named.value, unit.c_str());
    }
    out += look.finding.identification == core::Answer::kCannot ? " (cannot size it)\n" : "\n";
  }
  return out;
}

}  // namespace faultlab::server
