#pragma once

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "hardware/simulated/simulated_daq.h"
#include "tests/hardware/stand_in.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {

/// The common part of both stand-ins: the simulated bench behind terminals, and a record of misuse.
class StandInPlant {
 public:
  StandInControl control;

  SimulatedDaq& daq() {
    if (!daq_) {
      daq_ = std::make_unique<SimulatedDaq>(paper::Bench(),
                                            paper::Hardware(),
                                            ScalingOf(paper::Bench()),
                                            WiringOf(paper::Bench()),
                                            clock_);
      daq_->WriteRelayLines(control.relay_levels);
      daq_->BeginRun(control.seed);
    }
    clock_->now_ns = &control.now_ns;
    if (control.begin_run) {
      control.begin_run = false;
      daq_->BeginRun(control.seed);
    }
    return *daq_;
  }

  /// @returns true when this call is to fail.
  bool Called() { return control.calls++ == control.fail_at; }

  void Misuse(const char* what) {
    if (control.misuses++ == 0) std::snprintf(control.misuse, sizeof control.misuse, "%s", what);
  }

  void Drive(double volt) {
    control.drive_v = daq().WriteDrive(volt);
    Save();
  }
  void Relays(std::uint32_t levels) {
    daq().WriteRelayLines(levels);
    control.relay_levels = levels;
    Save();
  }

 private:
  struct ControlledClock final : Clock {
    std::int64_t* now_ns = nullptr;
    Nanoseconds Now() const override {
      return Nanoseconds(now_ns != nullptr ? std::atomic_ref(*now_ns).load() : 0);
    }
    Wake SleepUntil(Nanoseconds) override { return {}; }
  };

  /// The state of the terminals outlives the process that set them, as on a real board.
  void Save() const {
    const char* path = std::getenv("STAND_IN_STATE");
    if (path == nullptr) return;
    if (std::FILE* file = std::fopen(path, "w")) {
      std::fprintf(file, "%g %u\n", control.drive_v, control.relay_levels);
      std::fclose(file);
    }
  }

  std::shared_ptr<ControlledClock> clock_ = std::make_shared<ControlledClock>();
  std::unique_ptr<SimulatedDaq> daq_;
};

}  // namespace faultlab::hardware
