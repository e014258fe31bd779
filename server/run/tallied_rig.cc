#include "server/run/tallied_rig.h"

#include <utility>

#include "core/bench/bench.h"
#include "hardware/relay_board.h"

namespace faultlab::server {

TalliedRig::TalliedRig(std::shared_ptr<hardware::Rig> rig, std::shared_ptr<RigTally> tally)
    : rig_(std::move(rig)), tally_(std::move(tally)) {}

core::Status TalliedRig::Arm(hardware::RunPlan plan, hardware::Epoch epoch) {
  return rig_->Arm(std::move(plan), epoch);
}

hardware::ReadStatus TalliedRig::Read(std::vector<hardware::RigMessage>& out,
                                      std::chrono::milliseconds patience) {
  const std::size_t known = out.size();
  const hardware::ReadStatus status = rig_->Read(out, patience);
  for (std::size_t i = known; i < out.size(); ++i) {
    if (const auto* event = std::get_if<hardware::RigEvent>(&out[i])) Note(*event);
  }
  if (status == hardware::ReadStatus::kEnded) ReturnToNominal();
  return status;
}

void TalliedRig::SafeStop(std::string_view reason) {
  rig_->SafeStop(reason);
  ReturnToNominal();
}

core::Result<hardware::SelfTestReport> TalliedRig::SelfTest(hardware::Epoch epoch) {
  core::Result<hardware::SelfTestReport> report = rig_->SelfTest(epoch);
  if (!report || rig_->description().any_value) return report;
  // Each position is reached from nominal.
  for (const hardware::SelfTestPosition& position : report.value().positions) {
    if (!position.ok) continue;
    MoveTo(position.component, hardware::RelayPositionOf(position.component, position.value));
    ReturnToNominal();
  }
  return report;
}

void TalliedRig::Note(const hardware::RigEvent& event) {
  switch (event.kind) {
    case hardware::RigEventKind::kRelayConfirmed:
      if (rig_->description().any_value) return;
      return MoveTo(event.component, hardware::RelayPositionOf(event.component, event.value));
    case hardware::RigEventKind::kTrip:
      return tally_->Tell({RigTally::Event::kTrip, id(), event.text});
    case hardware::RigEventKind::kDeltaStrays:
      return tally_->Tell({RigTally::Event::kDeltaStrays, id(), event.text});
    default:
      return;
  }
}

void TalliedRig::MoveTo(core::Component component, int position) {
  if (position < 0 || !core::IsSwitched(component)) return;
  const std::lock_guard lock(mutex_);
  int& now = position_[component.info().index];
  if (now == position) return;
  now = position;
  tally_->Closed(id(), component.info().positions[static_cast<std::size_t>(position)].line);
}

void TalliedRig::ReturnToNominal() {
  const std::lock_guard lock(mutex_);
  for (const auto& [index, position] : std::exchange(position_, {})) {
    if (position == 0) continue;
    const core::Component component = rig_->description().bench->component(index);
    tally_->Closed(id(), component.info().positions.front().line);
  }
}

}  // namespace faultlab::server
