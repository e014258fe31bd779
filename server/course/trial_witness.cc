#include "server/course/trial_witness.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <string>
#include <utility>

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
          const Clock& clock,
          std::function<void(std::string_view)> log)
      : trials_(trials),
        trial_(trial),
        drawn_(std::move(drawn)),
        clock_(clock),
        log_(std::move(log)) {}

  void OnEvent(const hardware::RigEvent& event, double period_s) override {
    events_.push_back(event);
    const RecordedEvent recorded = MakeEvent(event, period_s);
    kept_.push_back(boost::json::object{
        {"index", recorded.index}, {"kind", recorded.kind}, {"json", recorded.json}});
  }

  void OnEnd(RunState state, bool tripped, double length_s) override {
    const bool stands =
        state == RunState::kFinished || state == RunState::kStopped || (tripped && length_s > 0.0);
    const char* why = !stands                          ? "rig_failed"
                      : ConfirmsWhatWasDrawn(length_s) ? ""
                                                       : "relay_mismatch";
    const core::Status done =
        *why == '\0' ? trials_.Ended(trial_, boost::json::serialize(kept_), clock_.Wall())
                     : trials_.Void(trial_, why, clock_.Wall());
    if (!done.ok()) {
      log_("trial " + std::to_string(trial_) +
           ": its end is not stored, so it will be void: " + done.error().message);
    }
  }

 private:
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
  const Clock& clock_;
  const std::function<void(std::string_view)> log_;
  std::vector<hardware::RigEvent> events_;
  boost::json::array kept_;
};

}  // namespace

std::shared_ptr<SealedWitness> MakeWitness(Trials trials,
                                           std::int64_t trial,
                                           std::vector<core::Fault> drawn,
                                           const Clock& clock,
                                           std::function<void(std::string_view)> log) {
  return std::make_shared<Witness>(trials, trial, std::move(drawn), clock, std::move(log));
}

}  // namespace faultlab::server::course
