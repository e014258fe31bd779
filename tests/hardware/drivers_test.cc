// The real drivers' code with stand-ins that have the real signatures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "hardware/bench/benches.h"
#include "hardware/config/bench_file.h"
#include "hardware/daq/shared_library.h"
#include "hardware/supervisor.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/stand_in.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"
#include "tests/support/paths.h"

namespace faultlab::hardware {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string NiConfig(const std::string& method) {
  return std::string("driver = \"nidaqmx\"\n[nidaqmx]\nlibrary = \"") +
         tests::InBuild("tests/hardware/libstand_in_nidaqmx.so") + "\"\n[encoder]\nmethod = \"" +
         method + "\"\n";
}

std::string NiWatchdogConfig() {
  return std::string("driver = \"nidaqmx\"\n[nidaqmx]\nwatchdog = \"cRIO1\"\nlibrary = \"") +
         tests::InBuild("tests/hardware/libstand_in_nidaqmx.so") + "\"\n";
}

std::string NiQuadratureConfig() {
  return std::string("driver = \"nidaqmx\"\n[nidaqmx]\ncounts = \"quadrature\"\nlibrary = \"") +
         tests::InBuild("tests/hardware/libstand_in_nidaqmx.so") + "\"\n";
}

std::string ComediConfig(const std::string& more = "") {
  return std::string("driver = \"comedi\"\n[comedi]\nlibrary = \"") +
         tests::InBuild("tests/hardware/libstand_in_comedi.so") +
         "\"\ncounter = 3\nreference = \"diff\"\n" + more;
}

BenchFile Parsed(const std::string& text) {
  core::Result<BenchFile> file = ParseBenchFile(text, "bench.toml");
  EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().message);
  BenchFile bench = std::move(file).value();
  bench.config.description.id = "bench-1";
  return bench;
}

struct Driver {
  const char* name;
  std::string library;
  std::string config;
  bool counts;
  StandInScans scans = StandInScans::kNone;
};

class RealDriver : public testing::TestWithParam<Driver> {
 protected:
  RealDriver() : library_(GetParam().library), bench_(Parsed(GetParam().config)) {
    StandInControlFunction* function = nullptr;
    library_.Find("stand_in_control", function);
    control_ = function();
    Reset();
    bench_.driver_patience = std::chrono::seconds(10);  // a busy machine is not a hanging driver
  }
  ~RealDriver() override {
    EXPECT_EQ(control_->open_handles, 0);
    EXPECT_EQ(control_->misuses, 0) << control_->misuse;
  }

  void Reset() {
    *control_ = StandInControl{};
    control_->begin_run = true;
    control_->scans = GetParam().scans;
  }

  /// Steps a machine through a plan, and the stand-in's time with it.
  RunLog Play(RigMachine& machine, const RunPlan& plan) {
    RunLog log;
    std::vector<RigMessage> messages;
    machine.Prepare(plan);
    std::optional<Nanoseconds> next = Nanoseconds(0);
    while (next) {
      control_->now_ns = next->count();
      next = machine.Step({.planned = *next, .actual = *next}, {}, messages);
    }
    for (RigMessage& message : messages) {
      if (auto* sample = std::get_if<core::Sample>(&message)) {
        log.samples.push_back(*sample);
      } else {
        log.events.push_back(std::get<RigEvent>(message));
      }
    }
    return log;
  }

  SharedLibrary library_;  // keeps the stand-in and its state loaded
  BenchFile bench_;
  StandInControl* control_ = nullptr;
};

TEST_P(RealDriver, ReadsTheSameBenchAsTheSimulatedRig) {
  const auto machine =
      MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
  RunPlan plan = SquarePlan(300);
  plan.faults = {{.component = paper::kR12, .value = 3300.0, .at_s = 1.0}};
  const RunLog log = Play(*machine, plan);
  SimulatedRigOptions options;
  options.speed = 0.0;
  options.gated_speed = GetParam().counts;
  const auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(plan, Epoch{1}).ok());
  ASSERT_TRUE(rig->Start(Epoch{1}).ok());
  const RunLog expected = Drain(*rig);
  ASSERT_EQ(log.samples.size(), expected.samples.size());
  for (std::size_t k = 0; k < 100; ++k) {
    ASSERT_EQ(log.samples[k].um_v, expected.samples[k].um_v) << k;
    ASSERT_EQ(log.samples[k].ia_a, expected.samples[k].ia_a) << k;
    ASSERT_NEAR(log.samples[k].n_rpm, expected.samples[k].n_rpm, 1e-9) << k;
  }
  // After the fault the contacts travel for 3 ms on this bench, and for no time in the other.
  EXPECT_NEAR(log.samples[250].ua_v, expected.samples[250].ua_v, 0.1);
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_EQ(machine->MakeSafe(), "");
  EXPECT_EQ(control_->drive_v, 0.0);
}

TEST_P(RealDriver, ReportsTheDriversOwnWordsAtEachCallThatFails) {
  int calls = 0;
  {
    const auto machine =
        MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
    (void)Play(*machine, SquarePlan(3));
    calls = control_->calls;
  }
  ASSERT_GT(calls, 20);
  int reported = 0;
  for (int n = 0; n < calls; ++n) {
    Reset();
    control_->fail_at = n;
    try {
      const auto machine = MakeBenchMachine(
          bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
      (void)Play(*machine, SquarePlan(3));
    } catch (const IoError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the stand-in was told to fail")) << n;
      ++reported;
    }
    ASSERT_LE(control_->open_handles, 1) << "only a failed clear may leave a task: call " << n;
    control_->open_handles = 0;
  }
  EXPECT_GT(reported, calls / 2);  // safe stops are repeated; clearing has no receiver for a report
}

TEST_P(RealDriver, FeedsTheBoardsOwnWatchdogOnceASample) {
  const auto machine =
      MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
  (void)Play(*machine, SquarePlan(30));
  const bool armed = std::string(GetParam().name) == "NiWatchdog";
  EXPECT_EQ(control_->watchdog_fed, armed ? 30 : 0);
  EXPECT_EQ(control_->watchdog_s, armed ? 0.2 : 0.0);
  EXPECT_EQ(control_->misuses, 0) << control_->misuse;
}

TEST_P(RealDriver, NeedsNoCounter) {
  bench_.nidaqmx.counter = "";
  bench_.comedi.counter = -1;
  bench_.config.description.has_n = false;
  const auto machine =
      MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
  const RunLog log = Play(*machine, SquarePlan(3));
  ASSERT_EQ(log.samples.size(), 3u);
  EXPECT_TRUE(std::isnan(log.samples[2].n_rpm));
}

TEST_P(RealDriver, WalksAllSixteenPositions) {
  const auto machine =
      MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
  const SelfTestReport report = machine->SelfTest();
  EXPECT_TRUE(report.ok);
  EXPECT_EQ(report.positions.size(), 16u);
}

TEST_P(RealDriver, IsMadeSafeByTheSupervisorWhenItsAgentIsKilled) {
  const std::string state = testing::TempDir() + "/stand_in_state_" + GetParam().name;
  ASSERT_EQ(setenv("STAND_IN_STATE", state.c_str(), 1), 0);
  const int status = Supervise(
      [&](const auto&) {
        const std::unique_ptr<Daq> daq = OpenDaq(bench_);
        daq->WriteRelayLines(~((1u << 0) | (1u << 19) | (1u << 21) | (1u << 6)));  // R1 = 100
        daq->WriteDrive(3.0);
        kill(getpid(), SIGKILL);
        return 0;
      },
      [&] {
        // In another process: the state that it leaves shows what it has done.
        double drive_v = 0.0;
        std::ifstream(state) >> drive_v;
        if (std::abs(drive_v - 3.0) > 1e-3) return false;  // the board keeps the last value
        const auto machine = MakeBenchMachine(
            bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
        return machine->MakeSafe().empty();
      });
  unsetenv("STAND_IN_STATE");
  EXPECT_EQ(status, 1);
  double drive_v = -1.0;
  std::uint32_t levels = 0;
  std::ifstream(state) >> drive_v >> levels;
  EXPECT_EQ(drive_v, 0.0);
  EXPECT_EQ(levels, ~((1u << 17) | (1u << 19) | (1u << 21) | (1u << 6)));
  std::filesystem::remove(state);
}

INSTANTIATE_TEST_SUITE_P(
    Boards,
    RealDriver,
    testing::Values(Driver{"NiFrequency",
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
                           NiConfig("frequency"),
                           false},
                    Driver{"NiCount",
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
                           NiConfig("count"),
                           true},
                    Driver{"NiWatchdog",
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
                           NiWatchdogConfig(),
                           false},
                    Driver{"NiQuadrature",
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
                           NiQuadratureConfig(),
                           true},
                    Driver{"Comedi",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig(),
                           true},
                    Driver{"ComediBothWays",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig("counts = \"both\"\n"),
                           true},
                    Driver{"ComediClocked",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig(),
                           true,
                           StandInScans::kAtOnce}),
    [](const testing::TestParamInfo<Driver>& driver) { return std::string(driver.param.name); });

// ---- counters that know the sense ---------------------------------------------------------------

/// The counter of a motor that runs forwards, its encoder's channels swapped or not.
class DirectedCounter : public RealDriver {
 protected:
  RunLog Speeds(bool swapped) {
    Reset();
    control_->swapped = swapped;
    const auto machine =
        MakeBenchMachine(bench_.config, OpenDaq(bench_), nullptr, std::make_shared<ManualClock>());
    return Play(*machine, SquarePlan(300));  // long enough for a counter of 16 bits to wrap
  }
};

TEST_P(DirectedCounter, GivesSpeedWithItsSignAndWrapsBothWays) {
  const RunLog forwards = Speeds(false);
  const RunLog backwards = Speeds(true);
  ASSERT_EQ(backwards.samples.size(), forwards.samples.size());
  EXPECT_GT(forwards.samples.back().n_rpm, 100.0);
  for (std::size_t k = 0; k < forwards.samples.size(); ++k) {
    ASSERT_NEAR(backwards.samples[k].n_rpm, -forwards.samples[k].n_rpm, 1e-9) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Boards,
    DirectedCounter,
    testing::Values(Driver{"NiQuadrature",
                           tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
                           NiQuadratureConfig(),
                           true},
                    Driver{"Comedi",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig("counts = \"both\"\n"),
                           true}),
    [](const testing::TestParamInfo<Driver>& driver) { return std::string(driver.param.name); });

// ---- conversions that the board clocks ----------------------------------------------------------

class ClockedConversions : public RealDriver {
 protected:
  std::unique_ptr<Daq> Opened() {
    std::unique_ptr<Daq> daq = OpenDaq(bench_);
    daq->Prepare();
    return daq;
  }
};

TEST_P(ClockedConversions, TellTheirMiddleAfterTheDrivesEdge) {
  const std::unique_ptr<Daq> daq = Opened();
  const double delta_s = bench_.config.description.delta_s;
  daq->WriteDrive(2.0);
  const AnalogReading reading = daq->ReadAnalog();
  ASSERT_TRUE(reading.middle_after_s.has_value());
  EXPECT_GE(*reading.middle_after_s, delta_s - 1e-6);  // the timer's grain
  EXPECT_LT(*reading.middle_after_s, delta_s + 5.0);   // of a machine that stood still, too
  EXPECT_NEAR(reading.um_v, 0.0, 1.0);                 // the scan before it has 7 V
}

TEST_P(ClockedConversions, AreOfTheEdgeBeforeThem) {
  const std::unique_ptr<Daq> daq = Opened();
  daq->WriteDrive(2.0);
  daq->WriteDrive(3.0);  // the scan of the edge before is broken off
  EXPECT_EQ(control_->cancels, 1);
  EXPECT_TRUE(daq->ReadAnalog().middle_after_s.has_value());
  EXPECT_THROW(daq->ReadAnalog(), IoError);  // one edge, one scan
}

TEST_P(ClockedConversions, AreBrokenOffAtTheEnd) {
  std::unique_ptr<Daq> daq = Opened();
  daq->WriteDrive(2.0);
  daq.reset();
  EXPECT_EQ(control_->cancels, 1);
}

TEST_P(ClockedConversions, ThatDoNotComeAreAnErrorAndTheDriveIsStillWritten) {
  const std::unique_ptr<Daq> daq = Opened();
  control_->scans_silent = true;
  daq->WriteDrive(2.0);
  try {
    daq->ReadAnalog();
    ADD_FAILURE() << "no error";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("does not come: 0 of "));
  }
  daq->WriteDrive(0.0);
  EXPECT_EQ(control_->drive_v, 0.0);
  EXPECT_EQ(control_->cancels, 1);
}

TEST_P(ClockedConversions, AreReadAlsoWhereTheirEndIsSaidBeforeTheirValues) {
  const std::unique_ptr<Daq> daq = Opened();
  daq->WriteDrive(2.0);
  control_->scans_say_end = 1;
  EXPECT_NO_THROW(daq->ReadAnalog()) << "as Linux may say it: no trip of a healthy motor";
  daq->WriteDrive(2.0);
  control_->scans_say_end = 2;
  try {
    daq->ReadAnalog();
    ADD_FAILURE() << "no error";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("ended its scan too early"));
  }
}

TEST_P(ClockedConversions, ThatCannotBeginAreAnErrorOfTheReadingNotOfTheDrive) {
  const std::unique_ptr<Daq> daq = Opened();
  control_->fail_at = control_->calls + 1;  // after the drive's write
  daq->WriteDrive(2.0);
  EXPECT_NEAR(control_->drive_v, 2.0, 1e-3);
  try {
    daq->ReadAnalog();
    ADD_FAILURE() << "no error";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), StartsWith("comedi_command failed: the stand-in was told to fail"));
  }
}

TEST_P(ClockedConversions, LeaveSingleReadsWhereTheTrialGivesNothing) {
  control_->scans_silent = true;
  const std::unique_ptr<Daq> daq = Opened();
  daq->WriteDrive(2.0);
  const int commands = control_->commands;
  (void)daq->ReadAnalog();
  EXPECT_EQ(control_->cancels, commands);
  EXPECT_EQ(control_->commands, commands);
  control_->scans_silent = false;
  daq->Prepare();  // of the next run
  daq->WriteDrive(2.0);
  (void)daq->ReadAnalog();
  EXPECT_GT(control_->commands, commands);
}

TEST_P(ClockedConversions, AreNotUsedWhereTheyAreNotWanted) {
  bench_.comedi.may_scan = false;
  const std::unique_ptr<Daq> daq = Opened();
  daq->WriteDrive(2.0);
  (void)daq->ReadAnalog();
  EXPECT_EQ(control_->commands, 0);
}

TEST_P(ClockedConversions, AreNotUsedWhereAScanTakesTooMuchOfDelta) {
  bench_.config.description.delta_s = 0.4e-3;
  const std::unique_ptr<Daq> daq = Opened();
  EXPECT_EQ(control_->commands, 0);
}

TEST_P(ClockedConversions, AreNotBegunByWhoOnlyMakesTheBenchSafe) {
  const std::unique_ptr<Daq> daq = OpenDaq(bench_);  // the agent that hangs may have the inputs
  daq->WriteDrive(0.0);
  EXPECT_EQ(control_->commands, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Boards,
    ClockedConversions,
    testing::Values(Driver{"AtOnce",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig(),
                           true,
                           StandInScans::kAtOnce},
                    Driver{"AfterAPeriod",
                           tests::InBuild("tests/hardware/libstand_in_comedi.so"),
                           ComediConfig(),
                           true,
                           StandInScans::kAfterAPeriod}),
    [](const testing::TestParamInfo<Driver>& driver) { return std::string(driver.param.name); });

TEST(Supervisor, HandsOnTheStatusOfAnAgentThatEnds) {
  const std::string marker = testing::TempDir() + "/supervisor_made_safe";
  std::filesystem::remove(marker);
  EXPECT_EQ(Supervise([](const auto&) { return 7; },
                      [&] {
                        std::ofstream(marker) << "safe";
                        return true;
                      }),
            7);
  EXPECT_FALSE(std::filesystem::exists(marker));
}

TEST(Supervisor, HelpsAnAgentWhoseDriverHangsAndLetsItLive) {
  const std::string marker = testing::TempDir() + "/supervisor_helped";
  std::filesystem::remove(marker);
  const int status = Supervise(
      [&](const SendWord& send) {
        send(kCallForHelp);
        while (!std::filesystem::exists(marker)) std::this_thread::yield();
        return 5;
      },
      [&] {
        std::ofstream(marker) << "safe";
        return true;
      });
  EXPECT_EQ(status, 5);
  std::filesystem::remove(marker);
}

TEST(Supervisor, KillsAnAgentWhenTheSecondLineHangsToo) {
  std::vector<std::string> said;
  SupervisorOptions options{.patience = std::chrono::milliseconds(50),
                            .say = [&](const char* text) { said.emplace_back(text); }};
  const int status = Supervise(
      [](const SendWord& send) {
        send(kCallForHelp);
        while (true) pause();
        return 0;
      },
      [] {
        while (true) pause();
        return true;
      },
      options);
  EXPECT_EQ(status, 1);
  ASSERT_EQ(said.size(), 3u);
  EXPECT_THAT(said.back(), HasSubstr("NOT safe"));
}

/// The stand-in has analog in, analog out, 24 digital lines and a counter: 0 to 3.
std::string ComediRefusal(const std::string& keys) {
  const BenchFile bench =
      Parsed(std::string("driver = \"comedi\"\n[comedi]\nlibrary = \"") +
             tests::InBuild("tests/hardware/libstand_in_comedi.so") + "\"\n" + keys);
  try {
    OpenDaq(bench);
  } catch (const IoError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ComediBoard, SaysWhatItHasInsteadOfWhatTheConfigurationNames) {
  EXPECT_EQ(ComediRefusal(""), "accepted");
  EXPECT_EQ(ComediRefusal("digital = 4\n"),
            "/dev/comedi0 has the subdevices 0 to 3, comedi.digital is 4");
  EXPECT_EQ(ComediRefusal("digital = 3\n"),
            "subdevice 3 of /dev/comedi0 is a counter, comedi.digital must be digital in and out");
  EXPECT_EQ(ComediRefusal("relay_base = 8\n"),
            "subdevice 2 of /dev/comedi0 has 24 lines, the description's relays use line 16 behind "
            "relay_base 8: name more subdevices in comedi.digital, or lower `lines` in the "
            "description");
  EXPECT_EQ(ComediRefusal("analog_out = 0\n"),
            "subdevice 0 of /dev/comedi0 is analog in, comedi.analog_out must be analog out");
  EXPECT_EQ(ComediRefusal("ia = 3\n"),
            "subdevice 0 of /dev/comedi0 has the channels 0 to 2, comedi.ia is 3");
  EXPECT_EQ(ComediRefusal("counter = 3\ncounter_channel = 1\n"),
            "subdevice 3 of /dev/comedi0 has the channels 0 to 0, comedi.counter_channel is 1");
}

// ---- configuration ------------------------------------------------------------------------------

std::string RefusalOf(const std::string& text, const std::string& bench = "") {
  const core::Result<BenchFile> file = ParseBenchFile(text, "bench.toml", bench);
  return file.ok() ? "accepted" : file.error().message;
}

/// The description of the servo motor (500 Hz) in a file, with keys of J and another range of uc.
std::string FastBench(const std::string& of_j, const std::string& input = "input_min_v = 0.0") {
  std::string text = LoadBench("servo-motor").value()->text;
  text.insert(text.find("offered = [1e-6"), of_j);
  const std::string as_shipped = "input_min_v = 0.0";
  text.replace(text.find(as_shipped), as_shipped.size(), input);
  const std::filesystem::path path = testing::TempDir() + "fast_bench.toml";
  std::ofstream(path) << text;
  return path;
}

TEST(BenchFile, OfNothingIsTheSimulatedPaperBench) {
  const core::Result<BenchFile> file = ParseBenchFile("", "bench.toml");
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(file.value().driver, BenchFile::Driver::kSimulated);
  EXPECT_EQ(file.value().config.wiring.boards.at(0).info().positions.at(0).line, 17);
  EXPECT_EQ(file.value().config.limits.current_continuous_a, 0.629);
}

TEST(BenchFile, TakesEveryKeyOfTheManual) {
  const core::Result<BenchFile> file = ParseBenchFile(R"(
id = "bench-7"
class = "amax"
calibration = "2026-11-20 v3"
driver = "nidaqmx"
[nidaqmx]
drive = "Mod2/ao1"
terminal = "diff"
[scaling]
um_v_per_v = 0.25
ia_v_per_a = 2.0
ia_offset_v = 0.01
[encoder]
pulses_per_revolution = 512
method = "count"
[relays]
inverted = false
gap_ms = 4
settle_ms = 4.5
rest_ms = 200
[limits]
uc_max_v = 4.0
current_continuous_a = 0.5
[amplifier]
mode = "voltage"
quadrants = 2
[loop]
delta_ms = 9.0
fifo_priority = 80
[link]
ride_through_s = 30
)",
                                                      "bench.toml");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file.value().config.wiring.boards.size(), 4U);
}

TEST(BenchFile, GivesRelaysTheTimeBeforeTheReading) {
  const std::string what = "gap_ms 3 + settle_ms 3 must be below delta_ms 5";
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[loop]\ndelta_ms = 5\n"),
            "bench.toml:3: loop.delta_ms is too short: relays." + what +
                ": the sample would be read while relays move");
  EXPECT_THAT(
      RefusalOf("driver = \"nidaqmx\"\n\n[relays]\nsettle_ms = 7\n"),
      StartsWith("bench.toml:4: relays.settle_ms is too long: gap_ms 3 + settle_ms 7 must be "
                 "below delta_ms 9.5"));
  const std::string fast = FastBench("values = [11e-6, 22e-6]\nlines = [1, 2]\n");
  EXPECT_THAT(RefusalOf("driver = \"nidaqmx\"\n", fast),
              StartsWith("bench.toml: relays.gap_ms is missing and then 3: gap_ms 3 + settle_ms 3 "
                         "must be below delta_ms 1.5"));
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[relays]\ngap_ms = 0.6\nsettle_ms = 0.6\n", fast),
            "accepted");
}

TEST(BenchFile, AsksNoRelayTimeOfABenchWithoutRelays) {
  const core::Result<BenchFile> file =
      ParseBenchFile(NiConfig("frequency"), "bench.toml", "servo-motor");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_DOUBLE_EQ(OpenRig(file.value())->description().delta_s, 1.5e-3);
}

TEST(BenchFile, SaysWhatMakesAnAmplifierNeedFourQuadrants) {
  EXPECT_EQ(RefusalOf("[limits]\nuc_min_v = -1\n[amplifier]\nquadrants = 2\n"),
            "bench.toml:4: amplifier.quadrants is 2, but uc may be -1 V by limits.uc_min_v: write "
            "quadrants = 4, or limits.uc_min_v = 0");
  const std::string both = FastBench("", "input_min_v = -5.0");
  EXPECT_EQ(RefusalOf("id = \"a\"\n", both),
            "bench.toml: amplifier.quadrants is missing and then 2, but uc may be -5 V by the "
            "description of the bench servo-motor: write quadrants = 4, or limits.uc_min_v = 0");
  EXPECT_EQ(RefusalOf("[amplifier]\nquadrants = 4\n", both), "accepted");
  EXPECT_EQ(RefusalOf("[limits]\nuc_min_v = 0\n", both), "accepted");
}

TEST(BenchFile, RefusesAnAmplifierThatNobodyCanDiagnose) {
  EXPECT_THAT(RefusalOf("[amplifier]\nmode = \"current\"\n"),
              StartsWith("bench.toml:2: amplifier.mode is \"current\", which cannot be diagnosed"));
}

TEST(BenchFile, RefusesACounterWithoutDirectionForAMotorThatReverses) {
  const std::string reverses = "[limits]\nuc_min_v = -5\n[amplifier]\nquadrants = 4\n";
  const std::string comedi = "driver = \"comedi\"\n[comedi]\ncounter = 3\n";
  EXPECT_THAT(
      RefusalOf(comedi + reverses),
      StartsWith("bench.toml:2: comedi.counts is \"up\": such a counter knows no direction, "
                 "but uc may be -5 V"));
  EXPECT_EQ(RefusalOf(comedi + "counts = \"both\"\n" + reverses), "accepted");
  EXPECT_EQ(RefusalOf("driver = \"comedi\"\n" + reverses), "accepted");
  EXPECT_THAT(RefusalOf("driver = \"nidaqmx\"\n[nidaqmx]\ncounter = \"Mod3/ctr0\"\n" + reverses),
              StartsWith("bench.toml:3: nidaqmx.counter counts edges: it knows no direction"));
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[nidaqmx]\ncounter = \"\"\n" + reverses), "accepted");
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[nidaqmx]\ncounts = \"quadrature\"\n" + reverses),
            "accepted");
}

TEST(BenchFile, CountsFourEdgesAPulseInQuadrature) {
  const BenchFile bench = Parsed(NiQuadratureConfig() + "[encoder]\npulses_per_revolution = 500\n");
  EXPECT_EQ(bench.config.scaling.pulses_per_revolution, 2000);
  EXPECT_EQ(bench.config.scaling.speed, SpeedMethod::kGatedCount);
  EXPECT_EQ(Parsed(NiConfig("count")).config.scaling.pulses_per_revolution, 1000);
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[nidaqmx]\ncounts = \"quadrature\"\n[encoder]\n"
                      "method = \"frequency\"\n"),
            "bench.toml:5: encoder.method must be \"count\": nidaqmx.counts is \"quadrature\"");
}

TEST(BenchFile, TakesOneDigitalSubdeviceOrAList) {
  EXPECT_EQ(Parsed("[comedi]\ndigital = 3\n").comedi.digital, std::vector<int>{3});
  EXPECT_EQ(Parsed("[comedi]\ndigital = [4, 2]\n").comedi.digital, (std::vector<int>{4, 2}));
  EXPECT_EQ(
      RefusalOf("[comedi]\ndigital = []\n"),
      "bench.toml:2: comedi.digital must be a whole number, or a list of them, from 0 to 255");
}

TEST(BenchFile, RefusesWithLineAndKey) {
  EXPECT_EQ(RefusalOf("a = \n").rfind("bench.toml:1: ", 0), 0u);
  EXPECT_EQ(RefusalOf("\n\n[limits]\nuc_max_v = \"5\"\n"),
            "bench.toml:4: limits.uc_max_v must be a number from 0.1 to 100");
  EXPECT_THAT(RefusalOf("driver = \"comedi\"\n[limits]\ncurrent_peak_a = 50\n"),
              HasSubstr("current_peak_a is 50, which ia cannot read"));
  EXPECT_THAT(RefusalOf("driver = \"comedi\"\n[limits]\nvoltage_max_v = 25\n"),
              HasSubstr("voltage_max_v is 25, which um cannot read"));
  EXPECT_THAT(RefusalOf("driver = \"comedi\"\n[limits]\nstall_current_a = 5\n"),
              HasSubstr("stall_current_a is 5, which ia cannot read"));
  EXPECT_EQ(RefusalOf("driver = \"nidaqmx\"\n[loop]\ndelta_ms = 20\n"),
            "bench.toml:3: loop.delta_ms must lie inside the period of 10 ms");
  EXPECT_EQ(RefusalOf("[limits]\ncurrent_peak_a = -1\n"),
            "bench.toml:2: limits.current_peak_a must be a number from 0.01 to 100");
  EXPECT_EQ(RefusalOf("[loop]\n\nspeed = 3\n"),
            "bench.toml:3: loop.speed is not a key of this table");
  EXPECT_EQ(RefusalOf("driver = \"usb\"\n"),
            "bench.toml:1: driver must be one of simulated, nidaqmx, comedi, device");
  EXPECT_EQ(RefusalOf("[relays]\nR1 = [17, 16, 1, 0]\n"),
            "bench.toml:2: relays.R1 belongs into the bench's description now: `lines` of its "
            "[[component]]");
  EXPECT_EQ(RefusalOf("[scaling]\num_v_per_v = 0\n"),
            "bench.toml:2: scaling.um_v_per_v must not be 0");
  EXPECT_THAT(RefusalOf("driver = \"comedi\"\n[encoder]\nmethod = \"frequency\"\n"),
              HasSubstr("must be \"count\""));
  EXPECT_THAT(RefusalOf("driver = \"nidaqmx\"\n[loop]\ndelta_ms = 5\n"), HasSubstr("relays move"));
  EXPECT_THAT(RefusalOf("driver = \"device\"\n"), HasSubstr("port must be a serial line"));
  EXPECT_EQ(RefusalOf("driver = \"device\"\n[device]\nport = \"tcp:crio\"\n"),
            "bench.toml:3: device.port must be tcp:HOST:PORT");
  EXPECT_THAT(RefusalOf("driver = \"device\"\n[device]\nport = \"/dev/ttyUSB0\"\n"
                        "[relays]\ninverted = true\n"),
              HasSubstr("relays.inverted belongs into the device"));
  EXPECT_THAT(RefusalOf("[amplifier]\nquadrants = 3\n"), HasSubstr("2 or 4"));
  EXPECT_THAT(RefusalOf("limits = 3\n"), HasSubstr("[limits]"));
}

TEST(BenchFile, ThatIsMissingOrADriverThatIsMissingSaysSo) {
  EXPECT_EQ(LoadBenchFile("/nowhere/bench.toml").error().code, core::ErrorCode::kNotFound);
  BenchFile bench = Parsed("driver = \"nidaqmx\"\n[nidaqmx]\nlibrary = \"/nowhere/libni.so\"\n");
  EXPECT_THROW(OpenDaq(bench), IoError);
}

}  // namespace
}  // namespace faultlab::hardware
