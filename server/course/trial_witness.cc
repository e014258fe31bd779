#include "server/course/trial_witness.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "server/course/kept_events.h"
#include "server/run/run_messages.h"

namespace faultlab::server::course {
namespace {

/// How long a rig may take to confirm a fault.
constexpr double kConfirmedWithinS = 1.0;
constexpr double kSameValue = 1e-6;

class Witness final : public SealedWitness {
 public:
  Witness(Trials trials,
          std::int64_t trial,
          std::vector<core::Fault> drawn,
          std::function<bool(lab::SessionId)> ended_by_user,
          const Clock& clock,
          std::function<void(std::string_view)> log)
      : trials_(trials),
        trial_(trial),
        drawn_(std::move(drawn)),
        ended_by_user_(std::move(ended_by_user)),
        clock_(clock),
        log_(std::move(log)) {}

  void OnEvent(const hardware::RigEvent& event, double period_s) override {
    events_.push_back(event);
    kept_.push_back(MakeEvent(event, period_s));
  }

  void OnEnd(const SealedEnd& end) override {
    const std::string why = WhyVoid(end);
    const core::Status done = why.empty() ? trials_.Ended(trial_, EventsText(kept_), clock_.Wall())
                                          : trials_.Void(trial_, why, clock_.Wall());
    if (!done.ok()) {
      log_("trial " + std::to_string(trial_) +
           ": its end is not stored, so it will be void: " + done.error().message);
    }
  }

 private:
  std::string WhyVoid(const SealedEnd& end) const {
    const bool stopped = end.state == RunState::kStopped;
    const bool stands =
        stopped || end.state == RunState::kFinished || (end.tripped && end.length_s > 0.0);
    if (!stands || (end.tripped && NothingCameBy(end.length_s))) return "rig_failed";
    if (!ConfirmsWhatWasDrawn(end.length_s)) return "relay_mismatch";
    if (!stopped || end.by_owner) return "";
    if (end.by_another) return "stopped_by_another";
    if (end.revoked == lab::SessionId{}) return "interrupted";
    return ended_by_user_(end.revoked) ? "" : "session_ended";
  }
  bool NothingCameBy(double length_s) const {
    return !drawn_.empty() && std::ranges::all_of(drawn_, [length_s](const core::Fault& fault) {
      return fault.at_s >= length_s;
    });
  }
  bool ConfirmsWhatWasDrawn(double length_s) const {
    const auto drawn = [this](core::Component component) {
      return std::ranges::any_of(
          drawn_, [&](const core::Fault& fault) { return fault.component == component; });
    };
    for (const hardware::RigEvent& event : events_) {
      if (event.kind == hardware::RigEventKind::kRefused || !drawn(event.component)) return false;
    }
    return std::ranges::all_of(drawn_, [&](const core::Fault& fault) {
      // A run that was stopped before has nothing to confirm.
      const bool drifts = fault.kind == core::FaultKind::kDrift;
      const double done_s = drifts ? fault.until_s : fault.at_s;
      return length_s < done_s + kConfirmedWithinS || IsConfirmed(fault);
    });
  }

  bool IsConfirmed(const core::Fault& fault) const {
    return std::ranges::any_of(events_, [&](const hardware::RigEvent& event) {
      if (event.kind != hardware::RigEventKind::kRelayConfirmed) return false;
      // A drift is confirmed when it has come to its end.
      return event.component == fault.component &&
             (fault.kind == core::FaultKind::kDrift ||
              std::abs(event.value - fault.value) <= kSameValue * fault.value);
    });
  }

  Trials trials_;  ///< its own: the run may outlive whoever began it
  const std::int64_t trial_;
  const std::vector<core::Fault> drawn_;
  const std::function<bool(lab::SessionId)> ended_by_user_;
  const Clock& clock_;
  const std::function<void(std::string_view)> log_;
  std::vector<hardware::RigEvent> events_;
  std::vector<RecordedEvent> kept_;
};

}  // namespace

std::shared_ptr<SealedWitness> MakeWitness(Trials trials,
                                           std::int64_t trial,
                                           std::vector<core::Fault> drawn,
                                           std::function<bool(lab::SessionId)> ended_by_user,
                                           const Clock& clock,
                                           std::function<void(std::string_view)> log) {
  return std::make_shared<Witness>(
      trials, trial, std::move(drawn), std::move(ended_by_user), clock, std::move(log));
}

}  // namespace faultlab::server::course
