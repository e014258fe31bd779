#include "server/run/verdict_teller.h"

#include <cmath>
#include <utility>

#include "server/run/run_messages.h"

namespace faultlab::server {

std::vector<RecordedEvent> VerdictTeller::Hear(const core::Verdict& verdict, std::int64_t now) {
  std::vector<RecordedEvent> told;
  // A later alarm may turn out to belong to an earlier one, which was told already.
  if (verdict.detected_at_s && *verdict.detected_at_s > told_s_) {
    told_s_ = *verdict.detected_at_s;
    const auto index = static_cast<std::int64_t>(std::llround(told_s_ / period_s_));
    told.push_back(MakeDiagnosisEvent("detected", index, period_s_, verdict.detector));
    isolated_.clear();
  }
  if (detected_at_s_ && !verdict.detected_at_s && verdict.kind == core::VerdictKind::kNominal) {
    told.push_back(MakeDiagnosisEvent("returned", now, period_s_, "back to nominal"));
    isolated_.clear();
  }
  detected_at_s_ = verdict.detected_at_s;
  if (verdict.kind == core::VerdictKind::kFault && !verdict.candidates.empty()) {
    if (std::vector<core::Component> named = core::NamedBy(verdict); named != isolated_) {
      isolated_ = std::move(named);
      told.push_back(MakeIsolationEvent(verdict, now, period_s_));
    }
  }
  return told;
}

void VerdictTeller::Restart() {
  detected_at_s_.reset();
  isolated_.clear();
}

}  // namespace faultlab::server
