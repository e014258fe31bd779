#include "hardware/speed_loop.h"

#include <cmath>
#include <utility>

#include "core/bench/bench.h"
#include "core/types/plant_parameters.h"
#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

// The first value is of a few samples, the later ones of more.
constexpr double kNewsShare = 0.02;

bool AreSame(const std::optional<core::BelievedFault>& a,
             const std::optional<core::BelievedFault>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->component == b->component && std::abs(a->value - b->value) < kNewsShare * b->value;
}

}  // namespace

SpeedLoop::SpeedLoop(RigDescription description, RigLimits limits)
    : description_(std::move(description)), limits_(limits) {}

core::Status SpeedLoop::Check(const RunPlan& plan) const {
  if (!plan.control) return core::Done{};
  if (!description_.controls_speed) return NoSpeedControl(description_.id);
  const auto samples = static_cast<std::int64_t>(plan.uc_v.size());
  const double dither_v = plan.control->options.dither_v;
  if (plan.control->from < 0 || plan.control->from > samples ||
      !(dither_v >= 0.0 && dither_v <= core::ToleranceOptions::kDitherMaxV)) {
    return Invalid("a control begins within its run, with a dither of at most 1 V",
                   "control",
                   "control_reference");
  }
  const core::Status good = core::Validate(plan.control->reference, plan.period_s);
  if (good.ok()) return good;
  return Invalid(
      good.error().message, "control/reference/" + good.error().field, good.error().reason);
}

core::Status SpeedLoop::Check(const RigCommand& command) const {
  if (!plan_ || !command.control) return NoSpeedControl(description_.id);
  return core::Validate(*command.control);
}

void SpeedLoop::Begin(const RunPlan& plan) {
  plan_ = plan.control;
  period_s_ = plan.period_s;
  order_.reset();
  order_is_new_ = false;
  drive_.reset();
  told_.reset();
  refuted_.reset();
  newest_ = {};
  reference_.reset();
  if (plan_) reference_.emplace(plan_->reference, period_s_);
}

void SpeedLoop::Accept(std::span<const RigCommand> commands) {
  for (const RigCommand& command : commands) {
    if (command.kind != RigCommand::Kind::kControl) continue;
    order_ = command.control;
    order_is_new_ = true;
  }
}

double SpeedLoop::Input(std::int64_t index, double planned_v, std::vector<RigMessage>& out) {
  if (!plan_ || !order_ || index < plan_->from || index == 0) return planned_v;
  if (!drive_) {
    drive_.emplace(limits_, *order_, period_s_, plan_->options, newest_.uc_v);
    out.emplace_back(RigEvent{.kind = RigEventKind::kControlBegan, .index = index, .text = ""});
  }
  if (order_is_new_) drive_->Heard(*order_);
  order_is_new_ = false;
  const double rad_per_s = core::RadPerSecondOfRpm(description_.bench->nominal.gear_ratio);
  const double input_v = drive_->Tick(reference_->At(static_cast<std::size_t>(index - plan_->from)),
                                      newest_.n_rpm * rad_per_s);
  Tell(index, out);
  return input_v;
}

/// What has changed in what is compensated. A value that is refined a little is no news.
void SpeedLoop::Tell(std::int64_t index, std::vector<RigMessage>& out) {
  const auto tell = [&](RigEventKind kind, const core::BelievedFault& of, const char* why) {
    out.emplace_back(RigEvent{
        .kind = kind, .index = index, .component = of.component, .value = of.value, .text = why});
  };
  const std::optional<core::BelievedFault>& now = drive_->believed();
  const std::optional<core::BelievedFault>& refuted = drive_->refuted();
  if (now && !AreSame(now, told_)) {
    tell(RigEventKind::kCompensated, *now, "");
  } else if (!now && drive_->gave_up() && !AreSame(refuted, refuted_)) {
    // Also of one that was never made up for: what was read since the alarm refutes it.
    tell(RigEventKind::kCompensationEnded, *refuted, "the speed refutes the diagnosis");
  } else if (!now && told_) {
    tell(RigEventKind::kCompensationEnded, *told_, "withdrawn");
  } else {
    return;
  }
  told_ = now;
  refuted_ = refuted;
}

}  // namespace faultlab::hardware
