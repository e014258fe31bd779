// Real processes that are stopped by SIGSTOP while they drive a board, and the reaction of their
// supervisor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "hardware/config/bench_file.h"
#include "hardware/heartbeat.h"
#include "hardware/supervisor.h"
#include "tests/hardware/rig_runs.h"
#include "tests/support/await.h"
#include "tests/support/paths.h"
#include "tests/support/scale.h"

namespace faultlab::hardware {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::HasSubstr;

/// Of the supervisors here. A busy host can take its cores away from an agent for longer than the
/// 300 ms of a rig, or from the board's driver for longer than its 250 ms, and then the supervisor
/// is right to kill it (so driver_timeout_ms is longer here, too); how soon the motor of a frozen
/// agent stops on a rig is measured in tests/comedi.
constexpr milliseconds kLongSilence(2000);
/// Whoever counts it as silence kills.
constexpr milliseconds kFreeze(3000);
constexpr int kAgentStatus = 7;

void Freeze(milliseconds time) {
  std::this_thread::sleep_for(time);
}

volatile std::sig_atomic_t end_asked = 0;

/// A supervisor, its agent and the stand-in of a board, as started by `faultlab rig`: the agent
/// drives a run as long as it lives, or has driven one. Their results are read from files.
class SupervisedAgent {
 public:
  enum class Does { kDrive, kDriveAndRest };

  explicit SupervisedAgent(Does does, int failing_make_safes = 0)
      : folder_(testing::TempDir() + "/frozen_agent_" + std::to_string(getpid())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    setenv("STAND_IN_STATE", (folder_ + "/terminals").c_str(), 1);
    supervisor_ = fork();
    if (supervisor_ == 0) _exit(RunSupervisor(does, failing_make_safes));
    unsetenv("STAND_IN_STATE");
    EXPECT_TRUE(tests::Await([this] { return Number("agent") > 0; })) << "the agent starts";
    if (does == Does::kDrive) {
      EXPECT_TRUE(tests::Await([this] { return drive_v().value_or(0.0) > 1.0; })) << "it drives";
    }
  }
  ~SupervisedAgent() {
    if (supervisor_ > 0) {
      if (Number("agent") > 0) kill(agent(), SIGKILL);
      kill(supervisor_, SIGKILL);
      waitpid(supervisor_, nullptr, 0);
    }
    std::filesystem::remove_all(folder_);
  }

  pid_t supervisor() const { return supervisor_; }
  /// Throws when there is none: kill(0, ..) would stop this program and whoever runs it.
  pid_t agent() const {
    const auto pid = static_cast<pid_t>(Number("agent"));
    if (pid <= 0) throw std::runtime_error("there is no agent: " + said());
    return pid;
  }
  /// The board's output; nothing while it is being written.
  std::optional<double> drive_v() const {
    double volt = 0.0;
    std::uint32_t levels = 0;
    std::ifstream in(folder_ + "/terminals");
    if (!(in >> volt >> levels)) return std::nullopt;
    return volt;
  }
  bool Lives(pid_t pid) const { return kill(pid, 0) == 0; }
  /// The supervisor's exit status; -1 for a death by a signal, -2 when it does not end.
  int Ended() {
    int status = 0;
    if (!tests::Await([&] { return waitpid(supervisor_, &status, WNOHANG) != 0; })) return -2;
    supervisor_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string said() const {
    std::ifstream in(folder_ + "/said");
    return {(std::istreambuf_iterator<char>(in)), {}};
  }

 private:
  long Number(const std::string& file) const {
    long number = 0;
    std::ifstream(folder_ + "/" + file) >> number;
    return number;
  }

  int RunSupervisor(Does does, int failing_make_safes) {
    SupervisorOptions options;
    options.fifo_priority = Bench().fifo_priority;
    options.silence_max = kLongSilence;
    options.say = [this](const char* text) {
      std::ofstream(folder_ + "/said", std::ios::app) << text << '\n';
    };
    const std::string failures = folder_ + "/failures";
    return Supervise([&](const SendWord& send) { return RunAgent(does, send); },
                     [&] {
                       // Each call is a process of its own, so the calls are counted in a file.
                       const long failed = Number("failures");
                       if (failed < failing_make_safes) {
                         std::ofstream(failures) << failed + 1;
                         return false;
                       }
                       const BenchFile bench = Bench();
                       return MakeBenchMachine(
                                  bench.config, OpenDaq(bench), nullptr, MakeSteadyClock())
                           ->MakeSafe()
                           .empty();
                     },
                     options);
  }

  int RunAgent(Does does, const SendWord& send) {
    struct sigaction end = {};
    end.sa_handler = [](int) { end_asked = 1; };
    sigaction(SIGTERM, &end, nullptr);
    const auto heartbeat = std::make_shared<Heartbeat>(send, MakeSteadyClock());
    const std::unique_ptr<Rig> rig = OpenRig(Bench(), heartbeat);
    const int samples = does == Does::kDrive ? 100'000 : 10;
    if (!rig->Arm(SquarePlan(samples), Epoch{1}).ok()) return 1;
    if (!rig->Start(Epoch{1}).ok()) return 1;
    if (does == Does::kDriveAndRest) (void)Drain(*rig);
    std::ofstream(folder_ + "/agent.new") << getpid() << '\n';
    std::filesystem::rename(folder_ + "/agent.new", folder_ + "/agent");
    std::vector<RigMessage> messages;
    while (end_asked == 0) {
      heartbeat->MainLoopTurn();
      messages.clear();
      (void)rig->Read(messages, milliseconds(2));
    }
    rig->SafeStop("asked to end");
    return kAgentStatus;
  }

  static BenchFile Bench() {
    BenchFile bench =
        ParseBenchFile(std::string("driver = \"nidaqmx\"\n[nidaqmx]\nlibrary = \"") +
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so") +
                           "\"\n[loop]\nlate_ticks_max = 1000\ndriver_timeout_ms = 10000\n",
                       "bench.toml")
            .value();
    bench.config.description.id = "bench-1";
    return bench;
  }

  const std::string folder_;
  pid_t supervisor_ = 0;
};

using Does = SupervisedAgent::Does;

TEST(FrozenAgent, IsKilledAndDriveIsZero) {
  SupervisedAgent bench(Does::kDrive);
  const pid_t agent = bench.agent();
  const Steady::time_point frozen_at = Steady::now();
  ASSERT_EQ(kill(agent, SIGSTOP), 0);
  ASSERT_TRUE(tests::Await([&] { return bench.drive_v() == 0.0; }))
      << "the motor is driven for ever";
  const std::chrono::duration<double, std::milli> took = Steady::now() - frozen_at;
  std::printf("drive 0 %.0f ms after SIGSTOP\n", took.count());
  EXPECT_EQ(bench.Ended(), 1);
  EXPECT_FALSE(bench.Lives(agent));
  EXPECT_THAT(bench.said(), HasSubstr("fallen silent: it is killed"));
  EXPECT_THAT(bench.said(), HasSubstr("drive 0, relays nominal"));
  if (tests::Proving()) {
    EXPECT_LT(took.count(), 10'000.0);  // kLongSilence on an idle machine
  }
}

TEST(FrozenAgent, IsCleanedUpAfterUntilTheBoardAnswers) {
  SupervisedAgent bench(Does::kDrive, 2);
  ASSERT_EQ(kill(bench.agent(), SIGSTOP), 0);
  EXPECT_EQ(bench.Ended(), 1);
  EXPECT_EQ(bench.drive_v(), 0.0);
  EXPECT_THAT(bench.said(), HasSubstr("drive 0, relays nominal"));
}

TEST(FrozenAgent, WhoseBoardDoesNotAnswerIsReported) {
  SupervisedAgent bench(Does::kDrive, 1000);
  ASSERT_EQ(kill(bench.agent(), SIGSTOP), 0);
  EXPECT_EQ(bench.Ended(), 1);
  EXPECT_THAT(bench.said(), HasSubstr("NOT safe: emergency stop"));
}

TEST(FrozenAgent, ThatDrivesNothingIsLeftAlone) {
  SupervisedAgent bench(Does::kDriveAndRest);
  const pid_t agent = bench.agent();
  kill(agent, SIGSTOP);
  Freeze(kFreeze);
  kill(agent, SIGCONT);
  kill(agent, SIGTERM);
  EXPECT_EQ(bench.Ended(), kAgentStatus);
  EXPECT_EQ(bench.said(), "");
}

TEST(FrozenSupervisor, HoldsNobodyAndKillsNobodyWhenItWakes) {
  SupervisedAgent bench(Does::kDrive);
  kill(bench.supervisor(), SIGSTOP);
  Freeze(kFreeze);
  kill(bench.supervisor(), SIGCONT);
  Freeze(kFreeze);
  EXPECT_TRUE(bench.Lives(bench.agent()));
  kill(bench.supervisor(), SIGTERM);
  EXPECT_EQ(bench.Ended(), kAgentStatus);
  EXPECT_EQ(bench.drive_v(), 0.0);
  EXPECT_EQ(bench.said(), "");
}

TEST(FrozenSupervisor, IsNotWaitedForWhenItsPipeIsFull) {
  const pid_t supervisor = fork();
  if (supervisor == 0) {
    _exit(Supervise(
        [](const SendWord& send) {
          kill(getppid(), SIGSTOP);
          for (int i = 0; i < 200'000; ++i) send(NextTickIn(Nanoseconds(0)));
          send(kMotorOff);
          kill(getppid(), SIGCONT);
          return kAgentStatus;
        },
        [] { return true; }));
  }
  int status = 0;
  pid_t ended = 0;
  EXPECT_TRUE(tests::Await([&] { return (ended = waitpid(supervisor, &status, WNOHANG)) != 0; }));
  if (ended == 0) kill(supervisor, SIGKILL);
  EXPECT_EQ(WEXITSTATUS(status), kAgentStatus);
}

TEST(FrozenSupervisor, WithItsAgentGivesTheAgentTimeToSpeak) {
  SupervisedAgent bench(Does::kDrive);
  kill(bench.agent(), SIGSTOP);
  kill(bench.supervisor(), SIGSTOP);
  Freeze(kFreeze);
  kill(bench.supervisor(), SIGCONT);
  Freeze(milliseconds(30));  // it checks first, and finds no heartbeat
  kill(bench.agent(), SIGCONT);
  Freeze(kFreeze);
  EXPECT_TRUE(bench.Lives(bench.agent()));
  kill(bench.supervisor(), SIGTERM);
  EXPECT_EQ(bench.Ended(), kAgentStatus);
  EXPECT_EQ(bench.said(), "");
}

TEST(KilledSupervisor, LeavesAnAgentThatStopsTheMotorItself) {
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);  // the agent becomes a child of this process
  SupervisedAgent bench(Does::kDrive);
  const pid_t agent = bench.agent();
  kill(bench.supervisor(), SIGKILL);
  EXPECT_EQ(bench.Ended(), -1);
  int status = 0;
  ASSERT_EQ(waitpid(agent, &status, 0), agent);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kAgentStatus);
  EXPECT_EQ(bench.drive_v(), 0.0);
}

}  // namespace
}  // namespace faultlab::hardware
