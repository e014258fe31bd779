// Changes of the rig during a run, and how they wait until the healthy rig is calibrated.
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/run/refusals.h"
#include "server/run/run.h"
#include "server/run/switchable.h"

namespace faultlab::server {
namespace {

/// Rounding error of values that went through JSON.
constexpr double kSameValue = 1e-9;

bool Same(double a, double b) {
  return std::abs(a - b) <= kSameValue * std::abs(b);
}

hardware::RigCommand SetTo(const WaitingChanges::Change& change) {
  return {hardware::RigCommand::Kind::kSetComponent, change.first, change.second};
}

}  // namespace

core::Result<Accepted> Run::Command(hardware::Epoch epoch, const hardware::RigCommand& command) {
  using Kind = hardware::RigCommand::Kind;
  const std::lock_guard lock(control_mutex_);
  if (!rig_is_ours_) return core::Refuse("run_ended");
  if (request_.witness) return core::Refuse("run_sealed");
  // A waiting change does not reach the rig, which would check the epoch, so the check is made
  // here.
  if (epoch != epoch_ || request_.hold.revoked()) return core::Refuse("stale_epoch", "epoch");
  if (command.kind == Kind::kAllNominal) waiting_.DropAll();
  if (command.kind == Kind::kSetComponent) {
    TRY_DONE(CheckSwitchable(rig_->description(), command.component, command.value));
    if (Same(command.value, request_.diagnosis.nominal.Get(command.component))) {
      waiting_.Drop(command.component);
    } else if (!waiting_.open()) {
      return Defer(command);
    }
  }
  TRY_DONE(rig_->Command(epoch, command));
  return Accepted{};
}

core::Result<Accepted> Run::LearnAgain() {
  const std::lock_guard lock(control_mutex_);
  if (!rig_is_ours_) return core::Refuse("run_ended");
  if (request_.witness) return core::Refuse("run_sealed");
  if (request_.hold.revoked()) return core::Refuse("stale_epoch", "epoch");
  const bool replay = rig_->description().kind == hardware::RigKind::kReplay;
  if (replay || request_.hidden_faults || request_.plan.control) return core::Refuse("learns_once");
  {
    const std::lock_guard state(mutex_);
    if (!faulty_.empty()) return core::Refuse("not_nominal", "", {{"component", faulty_}});
  }
  const core::DiagnosisOptions& options = request_.diagnosis;
  const double now_s = static_cast<double>(next_index_.load()) * options.period_s;
  const double until_s = now_s + options.healthy_to_s - options.healthy_from_s;
  if (static_cast<double>(request_.plan.uc_v.size()) * options.period_s <= until_s) {
    return core::Refuse("run_too_short");
  }
  for (const core::Fault& fault : request_.plan.faults) {
    if (fault.at_s >= now_s && fault.at_s < until_s) {
      return core::Refuse(
          "change_planned",
          "",
          {{"component", std::string(core::Name(fault.component))}, {"at_s", fault.at_s}});
    }
  }
  // Once a second is enough for anybody.
  constexpr double kPauseS = 1.0;
  if (learn_again_ || (learnt_again_ && now_s - options.healthy_from_s < kPauseS)) {
    return Accepted{learn_again_ ? until_s : options.healthy_to_s};
  }
  waiting_.Restart(until_s);
  learn_again_ = true;
  return Accepted{until_s};
}

void Run::NoteFaulty() {
  std::string faulty;
  for (const auto& [component, position] : positions_) {
    const bool nominal = Same(position.value, request_.diagnosis.nominal.Get(component));
    if (nominal && position.state != "commanded") continue;
    if (!faulty.empty()) faulty += ", ";
    faulty += core::Name(component);
  }
  const std::lock_guard lock(mutex_);
  faulty_ = std::move(faulty);
}

/// Before the sample at `next_t_s`. A rig may answer a command slowly: then the next sample tries
/// again, so that this thread waits for nobody.
void Run::RestartLearning(double next_t_s) {
  const std::unique_lock lock(control_mutex_, std::try_to_lock);
  if (!lock) return;
  learn_again_ = false;
  core::DiagnosisOptions& options = request_.diagnosis;
  const double length_s = options.healthy_to_s - options.healthy_from_s;
  options.healthy_from_s = next_t_s;
  options.healthy_to_s = next_t_s + length_s;
  options.calibration.reset();
  learnt_again_ = true;
  waiting_.Restart(options.healthy_to_s);
  pipeline_.LearnAgain(next_t_s);
  learning_ = pipeline_.learning();
  teller_.Restart();
  const std::int64_t now = last_frame_ ? last_frame_->sample.index + 1 : 0;
  AddEvent(MakeLearningEvent(now, options.healthy_to_s, state_.period_s));
}

/// Called with control_mutex_ held. Refuses at once what the rig would refuse later.
core::Result<Accepted> Run::Defer(const hardware::RigCommand& change) {
  const double until_s = request_.diagnosis.healthy_to_s;
  const double duration_s =
      static_cast<double>(request_.plan.uc_v.size()) * request_.diagnosis.period_s;
  if (duration_s <= until_s) {
    return core::Refuse("run_too_short");
  }
  if (waiting_.Defer(change.component, change.value)) return Accepted{until_s};
  const core::Status taken = rig_->Command(epoch_, change);  // the run ended just now
  if (!taken.ok()) return taken.error();
  return Accepted{};
}

void Run::FollowLearning() {
  const core::Learning before = std::exchange(learning_, pipeline_.learning());
  if (before == core::Learning::kStretch) ReleaseChanges();
  const std::int64_t now = last_frame_ ? last_frame_->sample.index : 0;
  if (learning_ == core::Learning::kLearnt) {
    AddEvent(MakeDiagnosisEvent("learnt", now, state_.period_s, "the healthy rig is learnt"));
  } else if (learning_ == core::Learning::kGivenUp) {
    AddEvent(MakeDiagnosisEvent("not_learnt", now, state_.period_s, pipeline_.verdict().reason));
  }
}

/// A rig may answer slowly. The run's thread can wait for it only while simulated time stands
/// still.
void Run::ReleaseChanges() {
  if (!real_time_) {
    ApplyWaitingChanges();
    TellChanges();
    return;
  }
  release_due_ = !services_.commands.Submit([weak = weak_from_this()] {
    if (const std::shared_ptr<Run> run = weak.lock()) run->ApplyWaitingChanges();
  });
}

void Run::ApplyWaitingChanges() {
  for (;;) {
    const std::lock_guard lock(control_mutex_);  // per change: Stop need not wait
    if (!rig_is_ours_) return;
    const auto change = waiting_.Next();
    if (!change) return;
    const core::Status taken = rig_->Command(epoch_, SetTo(*change));
    if (!taken.ok()) {
      waiting_.Refuse(*change, refusal::OfLease(rig_->description().id, taken.error()));
    }
  }
}

void Run::TellChanges() {
  const std::int64_t now = last_frame_ ? last_frame_->sample.index : 0;
  for (const ChangeNote& note : waiting_.TakeNotes()) {
    if (note.kind == "refused") positions_[note.component].state = "refused";
    AddEvent(MakeChangeEvent(note, now, state_.period_s));
  }
}

}  // namespace faultlab::server
