#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hardware/daq/daq.h"
#include "hardware/io_error.h"

namespace faultlab::hardware {

/// The calls at the terminals, and the failures to inject.
struct DaqJournal {
  int calls = 0;
  int fail_at = -1;             ///< this call throws (0 = the first) ..
  int failures = 1;             ///< .. and this many calls after it
  std::uint32_t stuck_low = 0;  ///< relay lines that read 0 whatever is written
  int hang_at = -1;             ///< this call does not return before Release
  std::vector<std::uint32_t> levels;
  /// What reaches the relays of the lines that were written; read-back sees the port, not the wire.
  std::function<std::uint32_t(std::uint32_t)> wires;
  std::atomic<double> drive_v = -1.0;
  /// What happens while a call is under way: a slow board lets time pass.
  std::function<void(std::string_view)> during = [](std::string_view) {};

  void Release() {
    const std::lock_guard lock(mutex);
    released = true;
    changed.notify_all();
  }
  bool hangs() {
    const std::lock_guard lock(mutex);
    return hung;
  }
  void Hang() {
    std::unique_lock lock(mutex);
    hung = true;
    changed.wait(lock, [this] { return released; });
  }

  std::mutex mutex;
  std::condition_variable changed;
  bool hung = false;
  bool released = false;
};

/// A Daq that fails or hangs at the n-th call.
class FaultyDaq final : public Daq {
 public:
  FaultyDaq(std::unique_ptr<Daq> inner, DaqJournal& journal)
      : inner_(std::move(inner)), journal_(journal) {}

  double WriteDrive(double terminal_v) override {
    Count("WriteDrive");
    journal_.drive_v = terminal_v;
    return inner_->WriteDrive(terminal_v);
  }
  AnalogReading ReadAnalog() override {
    Count("ReadAnalog");
    return inner_->ReadAnalog();
  }
  void WriteRelayLines(std::uint32_t levels) override {
    Count("WriteRelayLines");
    journal_.levels.push_back(levels);
    inner_->WriteRelayLines(journal_.wires ? journal_.wires(levels) : levels);
  }
  std::uint32_t ReadRelayLines() override {
    Count("ReadRelayLines");
    const bool by_port = journal_.wires && !journal_.levels.empty();
    return (by_port ? journal_.levels.back() : inner_->ReadRelayLines()) & ~journal_.stuck_low;
  }
  double ReadPulseFrequencyHz() override {
    Count("ReadPulseFrequencyHz");
    return inner_->ReadPulseFrequencyHz();
  }
  std::uint32_t ReadPulseCount() override {
    Count("ReadPulseCount");
    return inner_->ReadPulseCount();
  }
  void Prepare() override {
    Count("Prepare");
    inner_->Prepare();
  }
  void FeedWatchdog() override {
    Count("FeedWatchdog");
    inner_->FeedWatchdog();
  }
  bool has_watchdog() const override { return false; }

 private:
  void Count(const char* what) {
    const int call = journal_.calls++;
    journal_.during(what);
    if (call == journal_.hang_at) journal_.Hang();
    if (journal_.fail_at >= 0 && call >= journal_.fail_at &&
        call < journal_.fail_at + journal_.failures) {
      throw IoError(std::string(what) + " was made to fail");
    }
  }

  const std::unique_ptr<Daq> inner_;
  DaqJournal& journal_;
};

}  // namespace faultlab::hardware
