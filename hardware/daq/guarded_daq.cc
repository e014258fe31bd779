#include "hardware/daq/guarded_daq.h"

#include <pthread.h>
#include <sched.h>

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "hardware/daq/patience.h"

namespace faultlab::hardware {
namespace {

using Steady = std::chrono::steady_clock;

/// What the caller and the driver's thread share; the thread may outlive the Daq.
struct CallSlot {
  explicit CallSlot(std::unique_ptr<Daq> the_driver) : driver(std::move(the_driver)) {}

  const std::unique_ptr<Daq> driver;
  std::mutex mutex;
  std::condition_variable changed;
  std::function<void(Daq&)> call;  ///< empty = nothing to do
  bool busy = false;               ///< the driver has the call
  bool given_up = false;           ///< its caller has gone
  bool end = false;
  const char* name = "";
  Steady::time_point since{};
  std::exception_ptr failure;
};

void Serve(const std::shared_ptr<CallSlot>& slot, double drive_zero_v, int fifo_priority) {
  if (fifo_priority > 0) {
    const sched_param parameters{.sched_priority = fifo_priority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  }
  std::unique_lock lock(slot->mutex);
  while (true) {
    slot->changed.wait(lock, [&] { return slot->end || slot->call; });
    if (!slot->call) return;
    const std::function<void(Daq&)> call = std::exchange(slot->call, nullptr);
    lock.unlock();
    std::exception_ptr failure;
    try {
      call(*slot->driver);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (slot->given_up) {
      lock.unlock();
      try {
        slot->driver->WriteDrive(drive_zero_v);
      } catch (const std::exception&) {
        // The next MakeSafe, which an operator's clearing of the trip begins with, will tell.
      }
      lock.lock();
    }
    slot->failure = failure;
    slot->busy = slot->given_up = false;
    slot->changed.notify_all();
  }
}

class GuardedDaq final : public Daq {
 public:
  GuardedDaq(std::unique_ptr<Daq> driver, GuardedDaqOptions options)
      : options_(options),
        has_watchdog_(driver->has_watchdog()),
        slot_(std::make_shared<CallSlot>(std::move(driver))),
        thread_([slot = slot_, options] {
          Serve(slot, options.drive_zero_v, options.fifo_priority);
        }) {}

  ~GuardedDaq() override {
    bool hung = false;
    {
      const std::lock_guard lock(slot_->mutex);
      slot_->end = true;
      hung = slot_->busy;
      slot_->changed.notify_all();
    }
    if (hung) {
      thread_.detach();
    } else {
      thread_.join();
    }
  }

  double WriteDrive(double terminal_v) override {
    return Call<double>("WriteDrive", [=](Daq& daq) { return daq.WriteDrive(terminal_v); });
  }
  AnalogReading ReadAnalog() override {
    return Call<AnalogReading>("ReadAnalog", [](Daq& daq) { return daq.ReadAnalog(); });
  }
  void WriteRelayLines(std::uint32_t levels) override {
    (void)Call<int>("WriteRelayLines", [=](Daq& daq) {
      daq.WriteRelayLines(levels);
      return 0;
    });
  }
  std::uint32_t ReadRelayLines() override {
    return Call<std::uint32_t>("ReadRelayLines", [](Daq& daq) { return daq.ReadRelayLines(); });
  }
  double ReadPulseFrequencyHz() override {
    return Call<double>("ReadPulseFrequencyHz",
                        [](Daq& daq) { return daq.ReadPulseFrequencyHz(); });
  }
  std::uint32_t ReadPulseCount() override {
    return Call<std::uint32_t>("ReadPulseCount", [](Daq& daq) { return daq.ReadPulseCount(); });
  }
  void Prepare() override {
    (void)Call<int>("Prepare", [](Daq& daq) {
      daq.Prepare();
      return 0;
    });
  }
  void FeedWatchdog() override {
    if (!has_watchdog_) return;  // nothing to feed: no need to bother the driver's thread
    (void)Call<int>("FeedWatchdog", [](Daq& daq) {
      daq.FeedWatchdog();
      return 0;
    });
  }
  bool has_watchdog() const override { return has_watchdog_; }

 private:
  template <typename Answer>
  Answer Call(const char* name, std::function<Answer(Daq&)> call) {
    // The answer outlives a caller that has given up.
    const auto answer = std::make_shared<Answer>();
    std::unique_lock lock(slot_->mutex);
    if (slot_->busy) ThrowHang();
    slot_->busy = true;
    slot_->name = name;
    slot_->since = Steady::now();
    slot_->failure = nullptr;
    slot_->call = [answer, call = std::move(call)](Daq& daq) { *answer = call(daq); };
    slot_->changed.notify_all();
    Patience patience(options_.patience);
    while (slot_->busy && !patience.over()) {
      const Steady::time_point from = Steady::now();
      slot_->changed.wait_until(lock, from + patience.slice(), [this] { return !slot_->busy; });
      patience.Waited(Steady::now() - from);
    }
    if (slot_->busy) {
      slot_->given_up = true;
      ThrowHang();
    }
    if (slot_->failure) std::rethrow_exception(std::exchange(slot_->failure, nullptr));
    return *answer;
  }

  [[noreturn]] void ThrowHang() const {
    const std::chrono::duration<double> waited = Steady::now() - slot_->since;
    throw DriverHang(std::string("the driver call ") + slot_->name +
                         " does not return; the board keeps what it put out last",
                     waited.count(),
                     std::chrono::duration<double>(options_.patience).count());
  }

  const GuardedDaqOptions options_;
  const bool has_watchdog_;
  const std::shared_ptr<CallSlot> slot_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Daq> MakeGuardedDaq(std::unique_ptr<Daq> driver, GuardedDaqOptions options) {
  return std::make_unique<GuardedDaq>(std::move(driver), options);
}

}  // namespace faultlab::hardware
