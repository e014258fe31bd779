#include "hardware/device/device_machine.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "hardware/delta_watch.h"
#include "hardware/device/device_check.h"
#include "hardware/device/encoder_speed.h"
#include "hardware/fault_injector.h"
#include "hardware/refusal.h"
#include "hardware/relay_board.h"
#include "hardware/rig_limits.h"
#include "hardware/self_test.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;

constexpr Nanoseconds kStepMin = milliseconds(1);
constexpr Nanoseconds kStepMax = milliseconds(5);
constexpr Nanoseconds kResendEvery = milliseconds(20);
/// Above what gap and settling take: a board that does not get ready.
constexpr Nanoseconds kSettleSlack = milliseconds(100);
/// Of a device that was there a moment ago.
constexpr Nanoseconds kReconnect = milliseconds(150);
/// Samples that wait for one before them.
constexpr std::int64_t kEarlyMax = 1024;

/// The lines as the relay board sees them while the device switches them later.
class PlannedLines final : public RelayLines {
 public:
  void WriteRelayLines(std::uint32_t levels) override { lines_ = levels; }
  std::uint32_t ReadRelayLines() override { return lines_; }

 private:
  std::uint32_t lines_ = 0;
};

class DeviceMachine final : public RigMachine {
 public:
  DeviceMachine(BenchConfig config,
                DeviceAddress address,
                std::shared_ptr<Clock> clock,
                DeviceTiming timing)
      : config_(std::move(config)),
        timing_(timing),
        clock_(std::move(clock)),
        port_(std::move(address), clock_),
        relays_(lines_, config_.wiring, config_.timing),
        interlocks_(config_.limits),
        injector_(config_.description, config_.limits.relay_rest_s, relays_, nullptr),
        speed_(config_.scaling) {
    config_.description.uc_v_min = config_.limits.uc_v_min;
    config_.description.uc_v_max = config_.limits.uc_v_max;
    nominal_ = relays_.LevelsOf(std::vector<int>(config_.wiring.boards.size(), 0));
    Connect(timing_.connect);
  }

  const RigDescription& description() const override { return config_.description; }

  core::Status Check(const RunPlan& plan) const override {
    if (auto good = CheckExcitation(plan, config_.limits); !good) return good;
    if (auto good = CheckPlanOf(info_, config_, plan); !good) return good;
    if (plan.control) return NoSpeedControl(config_.description.id);
    return injector_.Check(plan);
  }
  core::Status Check(const RigCommand& command) const override { return injector_.Check(command); }

  void Prepare(const RunPlan& plan) override;
  std::optional<Nanoseconds> Step(const StepTime& time,
                                  std::span<const RigCommand> commands,
                                  std::vector<RigMessage>& out) override;
  std::string MakeSafe() noexcept override;
  SelfTestReport SelfTest() override;
  std::optional<Trip> trip() const override { return trip_; }
  void ClearTrip() override { trip_.reset(); }

 private:
  /// What the fault injector has asked for at a sample that has not come yet.
  struct Switching {
    std::int64_t index = 0;
    std::optional<std::uint32_t> lines;
    std::vector<RigMessage> commanded;
    std::vector<RigMessage> confirmed;
  };

  void Connect(Nanoseconds patience) {
    info_ = port_.Connect(patience);
    CheckWiringOf(info_, config_, nominal_);
  }
  std::int64_t samples() const { return static_cast<std::int64_t>(plan_.uc_v.size()); }
  void Arm() {
    const auto us = [](Nanoseconds time) {
      return static_cast<std::uint16_t>(std::clamp<std::int64_t>(time.count() / 1000, 0, 65535));
    };
    const auto watchdog_ms = static_cast<std::uint16_t>(timing_.watchdog / milliseconds(1));
    port_.Ask(DeviceMessage::kArm,
              ArmPayload(watchdog_ms, us(config_.timing.gap), us(config_.timing.settle)));
  }

  void Begin();
  void PlanRelaysUntil(std::int64_t end);
  void SendData();
  void AskForMissing();
  void KeepTalking();
  void TakeSamples(std::vector<RigMessage>& out);
  void Deliver(const DeviceSample& raw, std::vector<RigMessage>& out);
  void FollowSwitchings(const DeviceSample& raw, std::vector<RigMessage>& out);
  void LookAtState();
  void SetTrip(std::string_view name, std::string text) {
    if (trip_) return;
    trip_ = Trip{.name = std::string(name), .index = done_, .t_s = t_s_, .text = std::move(text)};
  }
  DeviceAck WaitForLines(std::uint32_t lines);

  BenchConfig config_;
  const DeviceTiming timing_;
  const std::shared_ptr<Clock> clock_;
  DevicePort port_;
  DeviceInfo info_;
  PlannedLines lines_;
  RelayBoard relays_;
  Interlocks interlocks_;
  FaultInjector injector_;
  EncoderSpeed speed_;
  std::uint32_t nominal_ = 0;
  std::optional<Trip> trip_;
  Nanoseconds motor_off_since_{0};

  RunPlan plan_;
  std::vector<std::int16_t> codes_;
  bool begun_ = false;
  std::int64_t lead_ = 0;                       ///< samples
  std::int64_t planned_ = 0;                    ///< samples for which the fault injector was asked
  std::int64_t done_ = 0;                       ///< samples that were delivered
  std::int64_t sent_ = 0;                       ///< values of the plan
  std::map<std::int64_t, DeviceSample> early_;  ///< samples behind one that is missing
  Nanoseconds asked_for_missing_at_{0};
  std::deque<Switching> switchings_;
  std::uint32_t expected_lines_ = 0;
  double t_s_ = 0.0;
  double before_s_ = 0.0;
  std::uint64_t t_us_ = 0;
};

void DeviceMachine::Prepare(const RunPlan& plan) {
  interlocks_.Rest(std::chrono::duration<double>(clock_->Now() - motor_off_since_).count());
  interlocks_.StartRun();
  if (const std::string unsafe = MakeSafe(); !unsafe.empty()) throw IoError(unsafe);
  plan_ = plan;
  codes_ = CodesOf(info_, config_, plan);
  port_.Ask(DeviceMessage::kClear);
  port_.Ask(
      DeviceMessage::kPlan,
      PlanPayload(static_cast<std::uint32_t>(plan.uc_v.size()),
                  static_cast<std::uint32_t>(std::llround(plan.period_s * 1e6)),
                  static_cast<std::uint32_t>(std::llround(config_.description.delta_s * 1e6))));
  planned_ = done_ = sent_ = 0;
  while (sent_ < std::min<std::int64_t>(samples(), info_.plan_values)) SendData();
  (void)port_.TakeRestart();
  (void)port_.TakeSamples();
  injector_.Begin(plan);
  speed_.StartRun();
  early_.clear();
  switchings_.clear();
  expected_lines_ = nominal_;
  lead_ =
      std::llround(std::ceil(std::chrono::duration<double>(timing_.lead).count() / plan.period_s)) +
      1;
  begun_ = false;
  t_s_ = 0.0;
  before_s_ = -plan.period_s;
  t_us_ = 0;
}

void DeviceMachine::Begin() {
  begun_ = true;
  Arm();
  PlanRelaysUntil(lead_);
  port_.Ask(DeviceMessage::kStart);
}

std::optional<Nanoseconds> DeviceMachine::Step(const StepTime& time,
                                               std::span<const RigCommand> commands,
                                               std::vector<RigMessage>& out) {
  injector_.Accept(commands, planned_, out);
  try {
    if (!begun_) Begin();
    port_.Poll();
    TakeSamples(out);
    if (!trip_ && done_ < samples()) KeepTalking();
    if (!trip_ && done_ < samples()) LookAtState();
  } catch (const IoError& error) {
    SetTrip(kDeviceLost,
            std::string(error.what()) + ". The device makes itself safe " +
                std::to_string(timing_.watchdog / milliseconds(1)) +
                " ms after the last word it heard");
    port_.Disconnect();
  }
  if (trip_ || done_ == samples()) return std::nullopt;
  const Nanoseconds period(std::llround(plan_.period_s * 1e9));
  return std::max(time.planned, time.actual) + std::clamp(period / 2, kStepMin, kStepMax);
}

void DeviceMachine::KeepTalking() {
  PlanRelaysUntil(std::min(samples(), done_ + lead_));
  while (sent_ < std::min(samples(), done_ + info_.plan_values - 1)) {
    // Whole messages, but for the last of the plan.
    const std::int64_t room = std::min(samples(), done_ + info_.plan_values - 1) - sent_;
    if (room < static_cast<std::int64_t>(kDataValuesMax) && sent_ + room < samples()) break;
    SendData();
  }
  AskForMissing();
  if (clock_->Now() - port_.asked_at() >= timing_.heartbeat) port_.Ask(DeviceMessage::kHeartbeat);
  if (clock_->Now() - port_.heard_at() > timing_.silence) {
    throw IoError("the device has been silent for " +
                  std::to_string(timing_.silence / milliseconds(1)) +
                  " ms: check its cable and its power");
  }
}

void DeviceMachine::LookAtState() {
  if (const auto restarted = port_.TakeRestart()) {
    SetTrip(kDeviceReset,
            "the device has started anew in mid-run, by " +
                std::string(ResetCauseText(restarted->reset_cause)));
    return;
  }
  const DeviceAck& status = port_.status();
  if (status.state == DeviceState::kFault) {
    // Of what it saw before, the samples are still worth having; the trip names its reason.
    if (status.fault == DeviceFault::kRelay) {
      SetTrip("relay_readback", "the device found it: " + std::string(TextOf(status.fault)));
    } else {
      SetTrip(kDeviceFault, "the device made itself safe: " + std::string(TextOf(status.fault)));
    }
  } else if (status.state != DeviceState::kRun &&
             status.next < static_cast<std::uint32_t>(samples())) {
    SetTrip(kDeviceReset, "the device has forgotten the run: it was started anew");
  }
}

void DeviceMachine::SendData() {
  const auto first = static_cast<std::size_t>(sent_);
  const std::size_t count = std::min(kDataValuesMax, codes_.size() - first);
  const std::int64_t room = done_ + info_.plan_values - sent_;
  const std::size_t fits =
      std::min(count, static_cast<std::size_t>(std::max<std::int64_t>(room, 1)));
  port_.Ask(DeviceMessage::kData,
            DataPayload(static_cast<std::uint32_t>(first), std::span(codes_).subspan(first, fits)));
  sent_ += static_cast<std::int64_t>(fits);
}

void DeviceMachine::PlanRelaysUntil(std::int64_t end) {
  for (; planned_ < end; ++planned_) {
    Switching switching{.index = planned_, .lines = {}, .commanded = {}, .confirmed = {}};
    injector_.Act(planned_, static_cast<double>(planned_) * plan_.period_s, switching.commanded);
    if (relays_.busy()) {
      while (relays_.busy()) (void)relays_.Advance();
      switching.lines = lines_.ReadRelayLines();
      port_.Ask(DeviceMessage::kRelay,
                RelayPayload(static_cast<std::uint32_t>(planned_), *switching.lines));
    }
    injector_.Confirm(planned_, switching.confirmed);
    if (!switching.commanded.empty()) switchings_.push_back(std::move(switching));
  }
}

void DeviceMachine::AskForMissing() {
  // A tick says that the sample before it was sent; the end of a run, that all were.
  const auto passed = [this](const DeviceAck& status) {
    const std::int64_t ticks = status.next;
    return status.state == DeviceState::kRun ? ticks > done_ + 1 : ticks > done_;
  };
  const bool behind = !early_.empty() || passed(port_.status());
  if (!behind || clock_->Now() - asked_for_missing_at_ < kResendEvery) return;
  asked_for_missing_at_ = clock_->Now();
  const auto k = static_cast<std::uint32_t>(done_);
  const DeviceAck answer = port_.AskFor(DeviceMessage::kResend, ResendPayload(k));
  if (answer.error == DeviceError::kRange && passed(answer)) {
    throw IoError("sample " + std::to_string(done_) +
                  " was lost on the line, and the device has it no more: check cable and earth");
  }
}

void DeviceMachine::TakeSamples(std::vector<RigMessage>& out) {
  for (const DeviceSample& sample : port_.TakeSamples()) {
    if (sample.k < std::min(samples(), done_ + kEarlyMax)) early_.emplace(sample.k, sample);
  }
  while (!early_.empty() && !trip_) {
    const auto first = early_.begin();
    if (first->first > done_) return;
    if (first->first == done_) Deliver(first->second, out);
    early_.erase(first);
  }
}

void DeviceMachine::FollowSwitchings(const DeviceSample& raw, std::vector<RigMessage>& out) {
  const bool settled = (raw.flags & kRelaysSettled) != 0;
  for (Switching& switching : switchings_) {
    if (switching.index > done_) break;
    out.insert(out.end(), switching.commanded.begin(), switching.commanded.end());
    switching.commanded.clear();
    if (switching.lines) expected_lines_ = *switching.lines;
  }
  if (!settled) return;
  if (raw.lines != expected_lines_) {
    SetTrip("relay_readback", LineDifference(expected_lines_, raw.lines));
    return;
  }
  while (!switchings_.empty() && switchings_.front().index <= done_) {
    for (RigMessage& message : switchings_.front().confirmed) {
      std::get<RigEvent>(message).index = done_;
      out.push_back(std::move(message));
    }
    switchings_.pop_front();
  }
}

void DeviceMachine::Deliver(const DeviceSample& raw, std::vector<RigMessage>& out) {
  const ChannelScaling& scaling = config_.scaling;
  const RigDescription& rig = config_.description;
  t_us_ += raw.t_us - static_cast<std::uint32_t>(t_us_);  // over the wrap at 2^32
  t_s_ = static_cast<double>(t_us_) / 1e6;
  FollowSwitchings(raw, out);
  core::Sample sample;
  sample.index = done_;
  sample.t_s = t_s_;
  sample.uc_v = scaling.uc.ToUnit(info_.uc.ToVolt(raw.uc));
  if (rig.has_um) sample.um_v = scaling.um.ToUnit(info_.um.ToVolt(raw.um));
  if (rig.has_ua) sample.ua_v = scaling.ua.ToUnit(info_.ua.ToVolt(raw.ua));
  if (rig.has_ia) sample.ia_a = scaling.ia.ToUnit(info_.ia.ToVolt(raw.ia));
  if (rig.has_n) sample.n_rpm = speed_.Rpm(raw, t_s_);
  sample.delta_s = raw.converted_us * 1e-6;
  out.emplace_back(sample);

  if (!trip_) trip_ = interlocks_.Check(sample, sample.t_s - before_s_);
  // Farther from delta it is no reading of this sample.
  if (std::abs(raw.converted_us * 1e-6 - rig.delta_s) > DeltaWatch::kDeltaTolerance) {
    SetTrip(kDeviceFault,
            "the device read " + std::to_string(raw.converted_us) +
                " us after the drive edge instead of at delta");
  }
  before_s_ = sample.t_s;
  ++done_;
}

DeviceAck DeviceMachine::WaitForLines(std::uint32_t lines) {
  const Nanoseconds until = clock_->Now() + relays_.duration() + kSettleSlack;
  while (true) {
    const DeviceAck ack = port_.Ask(DeviceMessage::kHeartbeat);
    const bool settled = (ack.flags & kRelaysSettled) != 0;
    if (settled && ack.lines == lines) return ack;
    if (ack.state == DeviceState::kFault && settled)
      throw IoError(LineDifference(lines, ack.lines));
    if (clock_->Now() > until) throw IoError(LineDifference(lines, ack.lines));
  }
}

std::string DeviceMachine::MakeSafe() noexcept {
  try {
    if (!port_.connected()) Connect(kReconnect);
    port_.Ask(DeviceMessage::kSafe);
    motor_off_since_ = clock_->Now();
    relays_.ForceNominalFirst();
    relays_.ForceNominalSecond();
    try {
      (void)WaitForLines(nominal_);
    } catch (const IoError& error) {
      return std::string("relays nominal failed: ") + error.what();
    }
    return {};
  } catch (const std::exception& error) {
    port_.Disconnect();
    return std::string("drive 0 is not confirmed: ") + error.what();
  }
}

SelfTestReport DeviceMachine::SelfTest() {
  return WalkPositions(config_.wiring, relays_, [this](core::Component component, int position) {
    if (const std::string unsafe = MakeSafe(); !unsafe.empty()) throw IoError(unsafe);
    port_.Ask(DeviceMessage::kClear);
    Arm();
    relays_.Request(component, position);
    while (relays_.busy()) (void)relays_.Advance();
    port_.Ask(DeviceMessage::kRelay, RelayPayload(kRelayNow, lines_.ReadRelayLines()));
    (void)WaitForLines(lines_.ReadRelayLines());
    clock_->SleepUntil(clock_->Now() +
                       Nanoseconds(std::llround(config_.limits.relay_rest_s * 1e9)));
  });
}

}  // namespace

std::unique_ptr<RigMachine> MakeDeviceMachine(BenchConfig config,
                                              DeviceAddress address,
                                              std::shared_ptr<Clock> clock,
                                              DeviceTiming timing) {
  return std::make_unique<DeviceMachine>(
      std::move(config), std::move(address), std::move(clock), timing);
}

}  // namespace faultlab::hardware
