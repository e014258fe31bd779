#include "core/isolation/verdict_text.h"
#include "core/types/number_text.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {

std::string ValueText(const Candidate& candidate) {
  const char sign = candidate.bound != 0 ? candidate.bound : '=';
  double value = candidate.value;
  std::string unit(Unit(candidate.component));
  if (unit == "farad") {
    value *= 1e6;
    unit = "uF";
  } else if (unit == "ohm" && value >= 1e4) {
    value *= 1e-3;
    unit = "kohm";
  }
  const std::string name(Name(candidate.component));
  return Format("%s %c %.4g %s", name.c_str(), sign, value, unit.c_str());
}

std::string RateText(Component component, double rate) {
  if (rate == 0.0) return " after it has moved";
  const std::string unit(Unit(component));
  return Format(", and moves by %+.3g %s a second", rate, unit.c_str());
}

std::string FaultSentence(const Verdict& verdict) {
  std::string sentence;
  for (Component component : verdict.group) {
    const auto found = std::find_if(
        verdict.candidates.begin(), verdict.candidates.end(), [&](const Candidate& candidate) {
          return candidate.component == component;
        });
    if (found == verdict.candidates.end()) continue;
    if (!sentence.empty()) sentence += " or ";
    sentence += ValueText(*found);
  }
  return sentence;
}

std::string SensorSentence(const SensorChange& change) {
  if (change.kind == SensorChange::Kind::kLost) {
    return change.channel + " does not follow the motor: its sensor, no component";
  }
  if (change.kind == SensorChange::Kind::kGain) {
    return Format("%s reads %.4g times what it should: its sensor, no component",
                  change.channel.c_str(),
                  change.value);
  }
  const char* unit = change.channel == "um" ? "V" : change.channel == "ia" ? "A" : "rpm";
  const char* format = change.value > 0.0 ? "%s reads %.3g %s too much: its sensor, no component"
                                          : "%s reads %.3g %s too little: its sensor, no component";
  return Format(format, change.channel.c_str(), std::abs(change.value), unit);
}

std::string FrictionSentence(const FrictionChange& change) {
  return Format("dry friction takes %.3g mNm, %.3g before: bearings or brushes, no component",
                1e3 * change.after_nm,
                1e3 * change.before_nm);
}

std::string ChannelsOf(const Calibration& calibration) {
  std::string first = calibration.used_um ? "um" : "";
  const auto add = [&first](bool used, const char* name, const char* between) {
    if (used) first += (first.empty() ? "" : between) + std::string(name);
  };
  add(calibration.used_ia, "ia", calibration.used_um && calibration.used_n ? ", " : " and ");
  add(calibration.used_n, "n", " and ");
  return first;
}

}  // namespace faultlab::core
