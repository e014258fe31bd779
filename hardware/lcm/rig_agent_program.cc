#include "hardware/lcm/rig_agent_program.h"

#include <linux/capability.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <utility>

#include "hardware/bench/benches.h"
#include "hardware/config/bench_file.h"
#include "hardware/contact_check.h"
#include "hardware/heartbeat.h"
#include "hardware/lcm/board_lock.h"
#include "hardware/lcm/epoch_file.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/rig_agent.h"
#include "hardware/lcm/rig_key.h"
#include "hardware/lcm/rig_name.h"
#include "hardware/lcm/self_test_text.h"
#include "hardware/supervisor.h"

namespace faultlab::hardware {
namespace {

constexpr int kFine = 0;
constexpr int kUnsafe = 1;
constexpr int kBadOptions = 2;
constexpr int kNoBus = 3;

volatile std::sig_atomic_t end_asked = 0;

void AskEnd(int) {
  end_asked = 1;
}

/// 2026-11-20T08:15:02.123Z faultlab rig: TEXT
void Say(const std::string& text) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  tm utc{};
  gmtime_r(&now.tv_sec, &utc);
  std::array<char, 32> stamp{};
  std::strftime(stamp.data(), stamp.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  std::fprintf(
      stderr, "%s.%03ldZ faultlab rig: %s\n", stamp.data(), now.tv_nsec / 1'000'000, text.c_str());
}

/// A page that was swapped out would hold up the loop that drives, or the one that watches it.
bool LockMemory() {
  // With a limit the call may succeed and a later allocation fail.
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  const bool privileged = geteuid() == 0 && prctl(PR_CAPBSET_READ, CAP_IPC_LOCK) == 1;
  return (unlimited || privileged) && mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
}

/// `options.id` is filled in from the file when it is empty.
core::Result<BenchFile> FileOf(RigAgentOptions& options) {
  BenchFile file;
  if (!options.config_file.empty()) {
    TRY(file, LoadBenchFile(options.config_file, options.bench));
    const std::string& id = file.config.description.id;
    if (options.id.empty()) options.id = id;
    if (!id.empty() && id != options.id) {
      return core::Error{
          .code = core::ErrorCode::kInvalid,
          .message = options.config_file + " is of rig " + id + ", not of " + options.id,
          .field = "id"};
    }
  } else {
    TRY(const auto bench, LoadBench(options.bench));
    TRY_DONE(FindProfile(*bench, options.profile));
    file.config.description.bench = bench;
    file.simulated.bench = bench;
    file.simulated.profile = options.profile;
    file.simulated.speed = options.speed;
    file.config.description.rig_class = bench->rig_class + kFarSimulators;
    file.simulated.rig_class = file.config.description.rig_class;
  }
  if (options.id.empty() && options.self_test) options.id = "bench";  // nobody else sees it
  if (!IsRigName(options.id)) {
    return core::Error{.code = core::ErrorCode::kInvalid,
                       .message = "--id needs a name of 1 to 40 letters, digits, - and _",
                       .field = "id"};
  }
  file.config.description.id = options.id;
  // A slow poll must not end a run: samples wait in this queue, not on the bus.
  file.simulated.queue_messages = 1u << 16;
  if (options.ride_through_s > 0.0) file.ride_through_s = options.ride_through_s;
  return file;
}

Heartbeat::Options BeatsOf(const BenchFile& file) {
  Heartbeat::Options beats;
  beats.driver_slack = std::max(Nanoseconds(0), file.driver_patience - BenchFile().driver_patience);
  return beats;
}

void EndOnSignals() {
  struct sigaction end = {};
  end.sa_handler = AskEnd;
  sigaction(SIGTERM, &end, nullptr);
  sigaction(SIGINT, &end, nullptr);
}

/// The motor turns meanwhile: a signal stops it, and this thread's turns say that the process
/// lives.
core::Result<ContactReport> ContactsOf(Rig& rig, Heartbeat& heartbeat) {
  auto report = std::async(std::launch::async, [&rig] { return CheckContacts(rig, Epoch{1}); });
  while (report.wait_for(std::chrono::milliseconds(2)) != std::future_status::ready) {
    heartbeat.MainLoopTurn();
    // Again and again: the run may begin after the signal.
    if (end_asked != 0) rig.SafeStop("the self-test was asked to end");
  }
  return report.get();
}

int SelfTest(const RigAgentOptions& options, const BenchFile& file, const SendWord& send) {
  EndOnSignals();
  const core::Result<BoardLock> lock = BoardLock::Take(file, options.state_directory);
  if (!lock) {
    Say(lock.error().message);
    return kUnsafe;
  }
  const auto heartbeat = std::make_shared<Heartbeat>(send, MakeSteadyClock(), BeatsOf(file));
  const std::unique_ptr<Rig> rig = OpenRig(file, heartbeat);
  const SelfTestReport report = rig->SelfTest(Epoch{1}).value();  // it was made just now: idle
  std::optional<ContactReport> contacts;
  if (options.contacts && report.ok && end_asked != 0) {
    Say("the self-test was asked to end: the contacts were not checked");
    return kUnsafe;
  }
  if (options.contacts && report.ok) {
    core::Result<ContactReport> checked = ContactsOf(*rig, *heartbeat);
    if (!checked) {
      Say("the contacts could not be checked: " + checked.error().message);
      return kUnsafe;
    }
    contacts = std::move(checked).value();
  }
  const ContactReport* const shown = contacts ? &*contacts : nullptr;
  std::fputs((options.json ? JsonOf(report, shown) : TableOf(report, shown)).c_str(), stdout);
  return report.ok && (!contacts || contacts->ok) ? kFine : kUnsafe;
}

/// Every trip reaches the log; one of a driver that hangs reaches the second line, too.
class TripWatch {
 public:
  explicit TripWatch(const SendWord& send) : send_(send) {}

  void Look(const Rig& rig) {
    const std::optional<Trip> trip = rig.trip();
    const std::string name = trip ? trip->name : "";
    if (name == seen_) return;
    seen_ = name;
    if (!trip) {
      Say("the interlock was cleared");
      return;
    }
    Say("interlock " + trip->name + " at sample " + std::to_string(trip->index) + ": " +
        trip->text);
    if (trip->name == kDriverHang) send_(kCallForHelp);
  }

 private:
  const SendWord& send_;
  std::string seen_;
};

int Serve(const RigAgentOptions& options,
          const BenchFile& file,
          const RigKey& key,
          EpochFile epochs,
          const SendWord& send) {
  EndOnSignals();
  core::Result<std::unique_ptr<MessageBus>> bus = OpenLcmBus(options.lcm_url);
  if (!bus) {
    Say(bus.error().message);
    return kNoBus;
  }
  const auto heartbeat = std::make_shared<Heartbeat>(send, MakeSteadyClock(), BeatsOf(file));
  if (file.driver != BenchFile::Driver::kSimulated) (void)LockMemory();  // RunRigAgent tells
  const core::Result<BoardLock> lock = BoardLock::Take(file, options.state_directory);
  if (!lock) {
    Say(lock.error().message);
    return kUnsafe;
  }
  const std::unique_ptr<Rig> rig = OpenRig(file, heartbeat);
  rig->SafeStop("the agent begins");  // in whatever state the bench was found
  RigAgentSettings settings;
  settings.key = key;
  settings.calibration = file.calibration;
  settings.say = Say;
  const auto ride_through = Nanoseconds(static_cast<std::int64_t>(file.ride_through_s * 1e9));
  settings.watchdog = std::max(settings.watchdog, ride_through);
  settings.lease += ride_through;
  const std::shared_ptr<Clock> clock = MakeSteadyClock();
  RigAgent agent(
      *rig,
      *bus.value(),
      settings,
      std::move(epochs),
      [clock] { return clock->Now(); },
      [] {
        return std::chrono::duration_cast<std::chrono::nanoseconds>(
                   std::chrono::system_clock::now().time_since_epoch())
            .count();
      });
  Say(options.id + " is on " + options.lcm_url);
  TripWatch trips(send);
  while (end_asked == 0) {
    heartbeat->MainLoopTurn();
    bus.value()->Handle(std::chrono::milliseconds(2));
    agent.Poll();  // before the call for help: everybody hears of a trip first
    trips.Look(*rig);
  }
  rig->SafeStop("the agent was asked to end");
  agent.Poll();  // its last words
  trips.Look(*rig);
  const bool unsafe = rig->state() == RigState::kTripped;
  Say(unsafe ? "ends, but not safely: " + rig->trip()->text : "ends, bench safe");
  return unsafe ? kUnsafe : kFine;
}

/// What the file allows and this bench will not do well.
void SayWhatWillNotWork(const BenchFile& file) {
  const RigDescription& rig = file.config.description;
  if (file.driver == BenchFile::Driver::kSimulated) return;
  if (rig.has_n && file.config.scaling.speed == SpeedMethod::kGatedCount &&
      rig.bench->estimates_use_n()) {
    Say("its speed is counted, which is the mean of a period and not the speed at the sample: "
        "write counted = true under [channel.n] of the description, or calibration refuses it");
  }
}

/// The second line: the board is opened anew, in a process of its own.
bool MakeBenchSafe(const BenchFile& file) {
  if (file.driver == BenchFile::Driver::kSimulated) return true;  // it died with the agent
  try {
    const std::string unsafe = OpenMachine(file, MakeSteadyClock())->MakeSafe();
    if (!unsafe.empty()) Say("second line: " + unsafe);
    return unsafe.empty();
  } catch (const std::exception& error) {
    Say(std::string("second line: ") + error.what());
    return false;
  }
}

/// Does the work in a process that a second one guards.
int Guard(const RigAgentOptions& options,
          const BenchFile& file,
          const std::function<int(const SendWord&)>& work) {
  if (!options.supervise) return work([](Word) {});
  // Ctrl-Z would stop both processes with the motor on.
  (void)std::signal(SIGTSTP, SIG_IGN);
  SupervisorOptions second_line;
  if (file.driver != BenchFile::Driver::kSimulated) second_line.fifo_priority = file.fifo_priority;
  second_line.say = [](const char* text) { Say(text); };
  return Supervise(
      work, [&] { return MakeBenchSafe(file); }, second_line);
}

}  // namespace

int RunRigAgent(const RigAgentOptions& given) {
  RigAgentOptions options = given;
  const core::Result<BenchFile> file = FileOf(options);
  if (!file) {
    Say(file.error().message);
    return kBadOptions;
  }
  if (!options.self_test && options.lcm_url.empty()) {
    Say("--lcm URL is needed, for example udpm://239.255.76.67:7667?ttl=1");
    return kBadOptions;
  }
  const auto guarded = [](const std::function<int()>& work) {
    try {
      return work();
    } catch (const std::exception& error) {
      Say(error.what());
      return kUnsafe;
    }
  };
  if (file.value().driver != BenchFile::Driver::kSimulated && !LockMemory()) {
    Say("its memory is not locked and may be swapped out: give it LimitMEMLOCK=infinity");
  }
  SayWhatWillNotWork(file.value());
  if (options.self_test) {
    const auto test = [&](const SendWord& send) {
      return guarded([&] { return SelfTest(options, file.value(), send); });
    };
    return options.contacts ? Guard(options, file.value(), test) : test([](Word) {});
  }
  const core::Result<RigKey> key = LoadOrMakeRigKey(options.key_directory, options.id);
  if (!key) {
    Say(key.error().message);
    return kBadOptions;
  }
  const core::Result<EpochFile> epochs = EpochFile::Open(options.state_directory, options.id);
  if (!epochs) {
    Say(epochs.error().message);
    return kBadOptions;
  }
  return Guard(options, file.value(), [&](const SendWord& send) {
    return guarded([&] { return Serve(options, file.value(), key.value(), epochs.value(), send); });
  });
}

}  // namespace faultlab::hardware
