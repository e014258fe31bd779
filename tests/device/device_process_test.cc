// A rig file, a pseudo-terminal, real processes and real time: what happens to the device when the
// host is killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "hardware/config/bench_file.h"
#include "hardware/heartbeat.h"
#include "hardware/supervisor.h"
#include "tests/device/simulated_device.h"
#include "tests/hardware/rig_runs.h"
#include "tests/paper_bench.h"
#include "tests/support/await.h"

namespace faultlab::hardware {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr Epoch kEpoch{1};

double Milliseconds(Nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

BenchFile RigFile(const std::string& port) {
  core::Result<BenchFile> file = ParseBenchFile("driver = \"device\"\n[device]\nport = \"" + port +
                                                    "\"\n"
                                                    "[scaling]\n"
                                                    "um_v_per_v = 0.4\n"
                                                    "ua_v_per_v = 0.4\n"
                                                    "ia_v_per_a = 2.0\n"
                                                    "ia_offset_v = 1.0\n",
                                                "bench.toml");
  file.value().config.description.id = "device-1";
  return file.value();
}

struct Played {
  RunLog log;
  /// The host gave up: "The device makes itself safe .."; or the device did: "the device made ..".
  bool held_up = false;
  bool safe = false;
};

Played PlayThroughATerminal() {
  SimulatedDevice device(SimulatedDevice::Line::kTerminal);
  device.RunInRealTime();
  const std::unique_ptr<Rig> rig = OpenRig(RigFile(device.port()));
  RunPlan plan = SquarePlan(150);
  plan.faults = {{.component = paper::kR9, .value = 33e3, .at_s = 0.7}};
  EXPECT_TRUE(rig->Arm(plan, kEpoch).ok());
  EXPECT_TRUE(rig->Start(kEpoch).ok());
  RunLog log = Drain(*rig);
  const bool held_up = log.last_text().find("itself safe") != std::string::npos;
  // A host that has given up cannot tell the device, whose watchdog follows.
  const bool safe = held_up ? tests::Await([&] { return device.IsSafe(); }) : device.IsSafe();
  return {std::move(log), held_up, safe};
}

// A machine that does not let this program run for a quarter of a second ends the run by the
// device's watchdog, as it should: such a run is played again.
TEST(DeviceInRealTime, PlaysAPlanThroughATerminal) {
  Played played;
  ASSERT_TRUE(tests::Await([&] {
    played = PlayThroughATerminal();
    EXPECT_TRUE(played.safe);
    return !played.held_up;
  }));
  const RunLog& log = played.log;
  EXPECT_EQ(log.samples.size(), 150u) << log.last_text();
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished) << log.last_text();
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed)[0].index, 70);
}

/// A supervisor and its agent in processes of their own, as `faultlab rig` starts them; the agent
/// drives. The device is in this process.
class DeviceAndHost : public testing::Test {
 protected:
  DeviceAndHost() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::fflush(nullptr);  // or the child says it again
    supervisor_ = fork();
    if (supervisor_ == 0) _exit(RunUntilBegun());
    device_.RunInRealTime();
  }
  /// No test goes on without an agent: kill(0, ..) would stop this program and whoever runs it.
  void SetUp() override {
    ASSERT_TRUE(tests::Await([this] { return agent() > 0 && device_.drive_v() > 1.0; }))
        << "it does not drive: " << said();
    std::ofstream(folder_ + "/begun") << '\n';
  }
  ~DeviceAndHost() override {
    if (supervisor_ > 0) {
      if (agent() > 0) kill(agent(), SIGKILL);
      kill(supervisor_, SIGKILL);
      waitpid(supervisor_, nullptr, 0);
    }
    std::filesystem::remove_all(folder_);
  }

  pid_t agent() const {
    int number = 0;
    std::ifstream(folder_ + "/agent") >> number;
    return number;
  }
  std::string said() const {
    std::ifstream in(folder_ + "/said");
    return {(std::istreambuf_iterator<char>(in)), {}};
  }
  /// The supervisor's exit status.
  int Ended() {
    int status = 0;
    EXPECT_TRUE(tests::Await([&] { return waitpid(supervisor_, &status, WNOHANG) != 0; }));
    supervisor_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  const std::string folder_ = testing::TempDir() + "/device_host_" + std::to_string(getpid());
  SimulatedDevice device_{SimulatedDevice::Line::kTerminal};
  pid_t supervisor_ = 0;

 private:
  /// Where the machine does not let the agent run for long, it is killed for its silence, or the
  /// device's watchdog acts: it is started again, as any agent is.
  int RunUntilBegun() {
    int status = 0;
    do {
      std::filesystem::remove(folder_ + "/agent");
      status = RunSupervisor();
    } while (!std::filesystem::exists(folder_ + "/begun"));
    return status;
  }

  int RunSupervisor() {
    const BenchFile file = RigFile(device_.port());
    SupervisorOptions options;
    options.fifo_priority = file.fifo_priority;
    options.say = [this](const char* text) {
      std::ofstream(folder_ + "/said", std::ios::app) << text << '\n';
    };
    return Supervise([&](const SendWord& send) { return RunAgent(file, send); },
                     [&] { return OpenMachine(file, MakeSteadyClock())->MakeSafe().empty(); },
                     options);
  }

  int RunAgent(const BenchFile& file, const SendWord& send) {
    const auto heartbeat = std::make_shared<Heartbeat>(send, MakeSteadyClock());
    const std::unique_ptr<Rig> rig = OpenRig(file, heartbeat);
    RunPlan plan = SquarePlan(100'000);
    plan.faults = {{.component = paper::kR12, .value = 5600.0, .at_s = 0.1}};
    if (!rig->Arm(plan, kEpoch).ok() || !rig->Start(kEpoch).ok()) return 2;
    std::vector<RigMessage> messages;
    while (rig->Read(messages, milliseconds(2)) == ReadStatus::kMore) {
      heartbeat->MainLoopTurn();
      // Known once it has driven for a while, with a relay away from nominal.
      if (messages.size() > 20 && !std::filesystem::exists(folder_ + "/agent")) {
        std::ofstream(folder_ + "/agent.new") << getpid() << '\n';
        std::filesystem::rename(folder_ + "/agent.new", folder_ + "/agent");
      }
    }
    return 3;
  }
};

TEST_F(DeviceAndHost, TheSupervisorMakesTheDeviceSafeWhenTheAgentIsKilled) {
  EXPECT_FALSE(device_.IsSafe());
  const Nanoseconds killed_at = device_.now();
  kill(agent(), SIGKILL);
  ASSERT_TRUE(tests::Await([this] { return device_.IsSafe(); }));
  EXPECT_EQ(Ended(), 1);
  EXPECT_THAT(said(), HasSubstr("drive 0, relays nominal"));
  std::printf("agent killed: drive 0 after %.0f ms\n",
              Milliseconds(device_.drive_zero_at() - killed_at));
}

TEST_F(DeviceAndHost, TheDeviceMakesItselfSafeWhenAgentAndSupervisorAreKilled) {
  const pid_t agent_pid = agent();
  kill(supervisor_, SIGSTOP);
  const Nanoseconds killed_at = device_.now();
  kill(agent_pid, SIGKILL);
  kill(supervisor_, SIGKILL);
  ASSERT_TRUE(tests::Await([this] { return device_.IsSafe(); }));
  const double zero_ms = Milliseconds(device_.drive_zero_at() - killed_at);
  std::printf("both killed: drive 0 after %.0f ms\n", zero_ms);
  EXPECT_EQ(Ended(), -1);
  EXPECT_GT(zero_ms, 100.0) << "by the watchdog of the device";
  EXPECT_LT(zero_ms, 300.0);
}

TEST_F(DeviceAndHost, TheDeviceIsSafeWhenTheAgentStandsStill) {
  const Nanoseconds stopped_at = device_.now();
  kill(agent(), SIGSTOP);
  ASSERT_TRUE(tests::Await([this] { return device_.IsSafe(); }));
  std::printf("agent stopped: drive 0 after %.0f ms\n",
              Milliseconds(device_.drive_zero_at() - stopped_at));
  EXPECT_EQ(Ended(), 1);
  EXPECT_THAT(said(), HasSubstr("fallen silent"));
  EXPECT_THAT(said(), HasSubstr("drive 0, relays nominal"));
}

}  // namespace
}  // namespace faultlab::hardware
