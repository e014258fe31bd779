#include "hardware/bench_rig.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/types/check.h"
#include "hardware/delta_watch.h"
#include "hardware/fault_injector.h"
#include "hardware/self_test.h"
#include "hardware/speed_loop.h"

namespace faultlab::hardware {
namespace {

constexpr int kSafeTries = 3;

Trip HangTrip(const DriverHang& hang, std::int64_t index, double t_s) {
  return {.name = std::string(kDriverHang),
          .value = hang.waited_s(),
          .limit = hang.limit_s(),
          .index = index,
          .t_s = t_s,
          .text = hang.what()};
}

/// A driver's call that acts about half way between its beginning and its end.
Nanoseconds Middle(Nanoseconds begin, Nanoseconds end) {
  return begin + (end - begin) / 2;
}

class BenchMachine final : public RigMachine {
 public:
  BenchMachine(BenchConfig config,
               std::unique_ptr<Daq> daq,
               SimulatorPort* port,
               std::shared_ptr<Clock> wall)
      : config_(Completed(std::move(config))),
        daq_(std::move(daq)),
        port_(port),
        wall_(std::move(wall)),
        relays_(*daq_, config_.wiring, config_.timing),
        interlocks_(config_.limits),
        injector_(config_.description, config_.limits.relay_rest_s, relays_, port),
        speed_loop_(config_.description, config_.limits) {
    LAB_CHECK(relays_.duration() < Delta(), config_.description.delta_s);
  }

  const RigDescription& description() const override { return config_.description; }

  core::Status Check(const RunPlan& plan) const override {
    if (auto good = CheckExcitation(plan, config_.limits); !good) return good;
    if (plan.period_s <= config_.description.delta_s) {
      return core::Error{.code = core::ErrorCode::kInvalid,
                         .message = "the period must be longer than the time from DAC to ADC",
                         .field = "period_s"};
    }
    if (auto good = speed_loop_.Check(plan); !good) return good;
    return injector_.Check(plan);
  }
  core::Status Check(const RigCommand& command) const override {
    if (command.kind == RigCommand::Kind::kControl) return speed_loop_.Check(command);
    return injector_.Check(command);
  }

  void Prepare(const RunPlan& plan) override {
    daq_->Prepare();
    if (port_ != nullptr) {
      port_->BeginRun(plan.seed);
      interlocks_ = Interlocks(config_.limits);
    }
    if (wall_ != nullptr) {
      interlocks_.Rest(std::chrono::duration<double>(wall_->Now() - motor_off_since_).count());
    }
    interlocks_.StartRun();
    if (const std::string unsafe = MakeSafe(); !unsafe.empty()) throw IoError(unsafe);
    plan_ = plan;
    period_ = Nanoseconds(std::llround(plan.period_s * 1e9));
    injector_.Begin(plan);
    speed_loop_.Begin(plan);
    phase_ = Phase::kDrive;
    index_ = 0;
    before_s_ = -plan.period_s;
    delta_watch_.emplace(config_.description.delta_s, plan.period_s);
  }

  std::optional<Nanoseconds> Step(const StepTime& time,
                                  std::span<const RigCommand> commands,
                                  std::vector<RigMessage>& out) override {
    injector_.Accept(commands, index_, out);
    speed_loop_.Accept(commands);
    try {
      switch (phase_) {
        case Phase::kDrive:
          return Drive(time, out);
        case Phase::kRelays:
          return Relays(time.planned, out);
        case Phase::kRead:
          return Read(time, out);
      }
    } catch (const DriverHang& hang) {
      trip_ = HangTrip(hang, index_, t_s_);
    }
    return std::nullopt;
  }

  std::string MakeSafe() noexcept override {
    std::string failures;
    try {
      Try("drive 0", failures, [this] { daq_->WriteDrive(config_.scaling.uc.ToTerminal(0.0)); });
      Try("relays nominal", failures, [this] {
        relays_.ForceNominalFirst();
        Wait(config_.timing.gap);
        relays_.ForceNominalSecond();
        Wait(config_.timing.settle);
        if (const std::string other = relays_.ReadbackDifference(); !other.empty()) {
          throw IoError(other);
        }
      });
      if (wall_ != nullptr) motor_off_since_ = wall_->Now();
    } catch (const std::exception& error) {
      failures += error.what();
    }
    return failures;
  }

  SelfTestReport SelfTest() override;
  std::optional<Trip> trip() const override { return trip_; }
  void ClearTrip() override { trip_.reset(); }

 private:
  enum class Phase { kDrive, kRelays, kRead };

  static BenchConfig Completed(BenchConfig config) {
    config.description.uc_v_min = config.limits.uc_v_min;
    config.description.uc_v_max = config.limits.uc_v_max;
    config.description.controls_speed = config.description.has_n;
    return config;
  }

  Nanoseconds Delta() const { return Nanoseconds(std::llround(config_.description.delta_s * 1e9)); }
  Nanoseconds TickStart() const { return index_ * period_; }

  std::optional<Nanoseconds> Drive(const StepTime& time, std::vector<RigMessage>& out);
  std::optional<Nanoseconds> Relays(Nanoseconds now, std::vector<RigMessage>& out);
  std::optional<Nanoseconds> Read(const StepTime& time, std::vector<RigMessage>& out);
  double ReadSpeedRpm(Nanoseconds now);

  void Wait(Nanoseconds time) {
    if (wall_ != nullptr && time.count() > 0) wall_->SleepUntil(wall_->Now() + time);
  }

  template <typename Action>
  void Try(const char* what, std::string& failures, Action action) {
    std::string why;
    for (int attempt = 0; attempt < kSafeTries; ++attempt) {
      try {
        action();
        return;
      } catch (const DriverHang& hang) {
        trip_ = HangTrip(hang, index_, t_s_);
        why = hang.what();
        break;
      } catch (const std::exception& error) {
        why = error.what();
      }
    }
    failures += (failures.empty() ? "" : "; ") + std::string(what) + " failed: " + why;
  }

  BenchConfig config_;
  const std::unique_ptr<Daq> daq_;
  SimulatorPort* const port_;
  const std::shared_ptr<Clock> wall_;
  RelayBoard relays_;
  Interlocks interlocks_;
  FaultInjector injector_;
  SpeedLoop speed_loop_;
  std::optional<Trip> trip_;
  Nanoseconds motor_off_since_{0};

  RunPlan plan_;
  Nanoseconds period_{0};
  Phase phase_ = Phase::kDrive;
  std::int64_t index_ = 0;
  double uc_v_ = 0.0;        ///< as the converter put it out
  double t_s_ = 0.0;         ///< of the drive edge
  double before_s_ = 0.0;    ///< t_s of the sample before
  Nanoseconds drive_at_{0};  ///< the middle of the call that put uc out
  std::optional<DeltaWatch> delta_watch_;
  std::uint32_t pulses_ = 0;
  Nanoseconds pulses_at_{0};
};

std::optional<Nanoseconds> BenchMachine::Drive(const StepTime& time, std::vector<RigMessage>& out) {
  if (index_ == static_cast<std::int64_t>(plan_.uc_v.size())) return std::nullopt;
  const double nominal_s = static_cast<double>(index_) * plan_.period_s;
  t_s_ =
      time.actual == time.planned ? nominal_s : std::chrono::duration<double>(time.actual).count();
  const double wanted_v =
      speed_loop_.Input(index_, plan_.uc_v[static_cast<std::size_t>(index_)], out);
  const double terminal_v = config_.scaling.uc.ToTerminal(wanted_v);
  const Nanoseconds before = time.Now();
  uc_v_ = config_.scaling.uc.ToUnit(daq_->WriteDrive(terminal_v));
  drive_at_ = Middle(before, time.Now());
  daq_->FeedWatchdog();
  if (index_ == 0 && config_.description.has_n &&
      config_.scaling.speed == SpeedMethod::kGatedCount) {
    pulses_ = daq_->ReadPulseCount();
    pulses_at_ = time.actual;
  }
  injector_.Act(index_, nominal_s, out);
  return Relays(time.planned, out);
}

std::optional<Nanoseconds> BenchMachine::Relays(Nanoseconds now, std::vector<RigMessage>& out) {
  while (relays_.busy()) {
    const RelayBoard::Stage stage = relays_.Advance();
    if (stage.progress == RelayBoard::Progress::kMismatch) {
      trip_ = Trip{.name = "relay_readback",
                   .value = 0.0,
                   .limit = 0.0,
                   .index = index_,
                   .t_s = t_s_,
                   .text = stage.text};
      return std::nullopt;
    }
    if (stage.wait.count() > 0) {
      phase_ = Phase::kRelays;
      return now + stage.wait;
    }
  }
  injector_.Confirm(index_, out);
  phase_ = Phase::kRead;
  return TickStart() + Delta();
}

std::optional<Nanoseconds> BenchMachine::Read(const StepTime& time, std::vector<RigMessage>& out) {
  const Nanoseconds before = time.Now();
  const AnalogReading analog = daq_->ReadAnalog();
  const Nanoseconds middle = Middle(before, time.Now());
  const ChannelScaling& scaling = config_.scaling;
  core::Sample sample;
  sample.index = index_;
  sample.t_s = t_s_;
  sample.uc_v = uc_v_;
  if (config_.description.has_um) sample.um_v = scaling.um.ToUnit(analog.um_v);
  if (config_.description.has_ua) sample.ua_v = scaling.ua.ToUnit(analog.ua_v);
  if (config_.description.has_ia) sample.ia_a = scaling.ia.ToUnit(analog.ia_v);
  if (config_.description.has_n) sample.n_rpm = ReadSpeedRpm(time.actual);
  if (port_ == nullptr) {
    const std::chrono::duration<double> by_this_clock = middle - drive_at_;
    sample.delta_s = analog.middle_after_s.value_or(by_this_clock.count());
  }
  if (auto strays = delta_watch_->Push(sample)) out.emplace_back(*std::move(strays));
  out.emplace_back(sample);
  speed_loop_.Heard(sample);

  trip_ = interlocks_.Check(sample, sample.t_s - before_s_);
  if (trip_) return std::nullopt;
  before_s_ = sample.t_s;
  ++index_;
  phase_ = Phase::kDrive;
  return TickStart();
}

double BenchMachine::ReadSpeedRpm(Nanoseconds now) {
  if (config_.scaling.speed == SpeedMethod::kPulseFrequency) {
    return config_.scaling.RpmOfFrequency(daq_->ReadPulseFrequencyHz());
  }
  const std::uint32_t pulses = daq_->ReadPulseCount();
  const double gate_s = std::chrono::duration<double>(now - pulses_at_).count();
  const auto counted = static_cast<std::int32_t>(pulses - pulses_);  // wraps at 2^32
  pulses_ = pulses;
  pulses_at_ = now;
  return gate_s > 0.0 ? config_.scaling.RpmOfFrequency(counted / gate_s) : core::kAbsent;
}

SelfTestReport BenchMachine::SelfTest() {
  daq_->Prepare();
  return WalkPositions(config_.wiring, relays_, [this](core::Component component, int position) {
    if (const std::string unsafe = MakeSafe(); !unsafe.empty()) throw IoError(unsafe);
    relays_.Request(component, position);
    while (relays_.busy()) {
      const RelayBoard::Stage stage = relays_.Advance();
      if (stage.progress == RelayBoard::Progress::kMismatch) throw IoError(stage.text);
      Wait(stage.wait);
    }
    Wait(Nanoseconds(std::llround(config_.limits.relay_rest_s * 1e9)));
  });
}

}  // namespace

BenchConfig ConfigOf(const core::Bench& bench) {
  BenchConfig config;
  config.description.bench = &bench;
  config.description.rig_class = bench.rig_class;
  config.description.delta_s = bench.delta_s;
  config.description.has_um = bench.um.exists;
  config.description.has_ua = bench.ua.exists;
  config.description.has_ia = bench.ia.exists;
  config.description.has_n = bench.n.exists;
  config.scaling = ScalingOf(bench);
  config.wiring = WiringOf(bench);
  config.limits = bench.limits;
  return config;
}

std::unique_ptr<RigMachine> MakeBenchMachine(BenchConfig config,
                                             std::unique_ptr<Daq> daq,
                                             SimulatorPort* port,
                                             std::shared_ptr<Clock> wall) {
  return std::make_unique<BenchMachine>(std::move(config), std::move(daq), port, std::move(wall));
}

}  // namespace faultlab::hardware
