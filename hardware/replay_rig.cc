#include "hardware/replay_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/types/check.h"
#include "hardware/paced_rig.h"

namespace faultlab::hardware {
namespace {

/// Plays samples and events of a recording; index k is due at k periods.
class ReplayMachine final : public RigMachine {
 public:
  ReplayMachine(std::vector<core::Sample> samples, ReplayRigOptions options)
      : samples_(std::move(samples)), events_(std::move(options.events)) {
    LAB_CHECK(!samples_.empty() && options.bench != nullptr);
    description_.bench = options.bench;
    description_.id = std::move(options.id);
    description_.rig_class = "replay";
    description_.kind = RigKind::kReplay;
    description_.has_ua = Has(&core::Sample::ua_v);
    description_.has_ia = Has(&core::Sample::ia_a);
    description_.has_n = Has(&core::Sample::n_rpm);
  }

  const RigDescription& description() const override { return description_; }

  core::Status Check(const RunPlan& plan) const override {
    if (!plan.uc_v.empty() || !plan.faults.empty() || plan.control) {
      return core::Error{.code = core::ErrorCode::kInvalid,
                         .message = "a recording brings its own excitation and faults",
                         .field = plan.uc_v.empty() ? "faults" : "uc_v"};
    }
    if (!(plan.period_s >= 1e-3 && plan.period_s <= 1.0)) {
      return core::Error{.code = core::ErrorCode::kInvalid,
                         .message = "the period must lie between 1 ms and 1 s",
                         .field = "period_s"};
    }
    return core::Done{};
  }

  core::Status Check(const RigCommand&) const override {
    return core::Error{.code = core::ErrorCode::kForbidden,
                       .message = "this is a recording: its components cannot be changed",
                       .field = {}};
  }

  void Prepare(const RunPlan& plan) override {
    period_ = Nanoseconds(std::llround(plan.period_s * 1e9));
    next_sample_ = next_event_ = 0;
  }

  std::optional<Nanoseconds> Step(const StepTime&,
                                  std::span<const RigCommand>,
                                  std::vector<RigMessage>& out) override {
    if (next_sample_ == samples_.size()) return std::nullopt;
    const core::Sample& sample = samples_[next_sample_];
    while (next_event_ < events_.size() && events_[next_event_].index <= sample.index) {
      out.emplace_back(events_[next_event_++]);
    }
    out.emplace_back(sample);
    ++next_sample_;
    return static_cast<std::int64_t>(next_sample_) * period_;
  }

  std::string MakeSafe() noexcept override { return {}; }
  SelfTestReport SelfTest() override { return {.positions = {}, .ok = true}; }
  std::optional<Trip> trip() const override { return std::nullopt; }
  void ClearTrip() override {}

 private:
  bool Has(double core::Sample::*channel) const {
    return std::ranges::any_of(
        samples_, [channel](const core::Sample& sample) { return !std::isnan(sample.*channel); });
  }

  RigDescription description_;
  const std::vector<core::Sample> samples_;
  const std::vector<RigEvent> events_;
  Nanoseconds period_{0};
  std::size_t next_sample_ = 0;
  std::size_t next_event_ = 0;
};

}  // namespace

std::unique_ptr<Rig> MakeReplayRig(std::vector<core::Sample> samples, ReplayRigOptions options) {
  const double speed = options.speed;
  PacedRigOptions paced{.clock = MakeSimulatedClock(speed, Nanoseconds(0)),
                        .wall = MakeSteadyClock(),
                        .queue_messages = options.queue_messages,
                        .wait_for_reader = speed != 1.0,
                        .watchdog = speed > 0.0 ? Nanoseconds(options.watchdog) : Nanoseconds(0)};
  return std::make_unique<PacedRig>(
      std::make_unique<ReplayMachine>(std::move(samples), std::move(options)), std::move(paced));
}

RunPlan ReplayPlan(double period_s) {
  RunPlan plan;
  plan.period_s = period_s;
  return plan;
}

}  // namespace faultlab::hardware
