// A bench other than the paper's, from its template to a diagnosis, with the commands of a user.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

class CliBench : public ChildProgram {
 protected:
  void SetUp() override {
    ASSERT_EQ(Run("bench new --structure motor-driver -o mine.toml").exit_code, 0);
  }
};

bool Holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(CliBench, CheckSaysWhatTheUsualRunDoesAndWhatCanBeDiagnosed) {
  const Finished run = Run("bench check mine.toml");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part : {"a sample every 2 ms, channels ia, n",
                           "output  4 to 8 V                  the supply gives -24 to 24 V",
                           "ia      -1.56",
                           "J = 2.2e-05",
                           "Smallest",
                           "Expected error: one standard deviation, the rig learned from 4.5 ",
                           "after 1 s     after 10 s"}) {
    EXPECT_TRUE(Holds(run.out, part)) << part << "\n" << run.out;
  }
  EXPECT_FALSE(Holds(run.out, "nan")) << run.out;
  EXPECT_FALSE(Holds(run.out, "PROBLEM")) << run.out;
}

/// A description of few words, with one of them replaced.
std::string Small(const std::string& from = "", const std::string& to = "") {
  std::string text = R"([bench]
name = "small"
structure = "motor-driver"
excitation = "prbs:low=1,high=2,clock=0.02"
input_max_v = 5.0
output_max_v = 12.0
[plant]
Ra = 2.32
La = 0.238e-3
Ke = 23.4e-3
KT = 23.4e-3
J = 11e-6
B = 5e-6
k = 4.0
[[component]]
symbol = "J"
offered = [22e-6]
[channel.ia]
noise = 5e-3
[limits]
slew_v_per_s = 2000.0
voltage_max_v = 24.0
current_continuous_a = 2.2
thermal_tau_s = 15.0
current_peak_a = 9.5
stall_current_a = 1.5
stall_speed_rpm = 20.0
stall_s = 0.5
)";
  return from.empty() ? text : text.replace(text.find(from), from.size(), to);
}

TEST_F(CliBench, CheckEndsWithStatus1WhereTheUsualRunCannotBeMade) {
  Write("good.toml", Small());
  const Finished good = Run("bench check good.toml");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  struct Bad {
    std::string from, to, says;
  };
  const Bad cases[] = {
      {"low=1,high=2", "low=1,high=9", "PROBLEM: uc goes from 1 to 9 V, the bench takes 0 to 5 V"},
      {"prbs:low=1,high=2,clock=0.02",
       "step:low=2,high=2,at=1",
       "PROBLEM: from 0.5 to 5 s a healthy rig is not calibrated, check 'excitation' failed"},
      {"low=1,high=2,clock=0.02\"\ninput_max_v = 5.0\noutput_max_v",
       "low=-2,high=2,clock=0.02\"\ninput_max_v = 5.0\ninput_min_v = -5.0\noutput_min_v = -12.0\n"
       "output_max_v",
       "PROBLEM: the interlock over_heat ends the run"},
      {"k = 4.0", "k = 7.0", "PROBLEM: output goes from 7 to 14 V, the supply gives 0 to 12 V"},
  };
  for (const Bad& bad : cases) {
    Write("bad.toml", Small(bad.from, bad.to));
    const Finished run = Run("bench check bad.toml");
    EXPECT_EQ(run.exit_code, 1) << bad.to << run.err;
    EXPECT_TRUE(Holds(run.out, bad.says)) << bad.says << "\n" << run.out;
    EXPECT_TRUE(Holds(run.err, "marked PROBLEM above")) << run.err;
  }
}

TEST_F(CliBench, CheckSaysThatItsRelaysAreTooSlow) {
  Write("relays.toml", Small("offered = [22e-6]", "values = [11e-6, 22e-6]\nlines = [1, 2]\n"));
  const Finished run = Run("bench check relays.toml");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(Holds(run.out, "gap_ms + settle_ms of the rig file must be below delta_s = 5 ms"))
      << run.out;
}

TEST_F(CliBench, CheckSaysWhatAnInputThatReversesNeeds) {
  std::string text = Small("prbs:low=1,high=2,clock=0.02", "prbs:low=-1,high=1,clock=0.1");
  const std::string to = "input_max_v = 5.0";
  text.replace(text.find(to), to.size(), to + "\ninput_min_v = -5.0\noutput_min_v = -12.0");
  text.replace(text.find("ia]\nnoise = 5e-3"), 16, "ia]\nnoise = 5e-3\n[channel.n]\nnoise = 1.0");
  Write("both-ways.toml", text);
  const Finished run = Run("bench check both-ways.toml");
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
  EXPECT_TRUE(Holds(run.out, "the drivers of real rigs count pulses without it")) << run.out;
  const Finished one_way = Run("bench check mine.toml");
  EXPECT_FALSE(Holds(one_way.out, "count pulses without it")) << one_way.out;
}

TEST_F(CliBench, IsSimulatedCalibratedAndDiagnosed) {
  ASSERT_EQ(Run("simulate --bench mine.toml --fault J=22e-6@10 --duration 14 -o run.csv").err, "");
  EXPECT_TRUE(Holds(Read("run.csv"), "\nt_s,uc_v,ia_a,n_rpm\n")) << "it has no um";
  const Finished learnt = Run("diagnose --bench mine.toml run.csv");
  EXPECT_TRUE(Holds(learnt.out, "component   J\n")) << learnt.out << learnt.err;
  ASSERT_EQ(Run("calibrate --bench mine.toml --healthy 0.5:9 run.csv -o rig.json").err, "");
  const Finished stored =
      Run("diagnose --bench mine.toml --calibration rig.json --healthy 0.2:5 run.csv");
  EXPECT_TRUE(Holds(stored.out, "component   J\n")) << stored.out << stored.err;
  EXPECT_EQ(Run("study --bench mine.toml run.csv").exit_code, 0);
  EXPECT_EQ(Run("plot --bench mine.toml run.csv --figure signals -o run.png").exit_code, 0);
}

TEST_F(CliBench, ACalibrationIsOfTheBenchAsItWasDescribed) {
  Write("small.toml", Small());
  ASSERT_EQ(Run("simulate --bench small.toml --duration 8 -o run.csv").err, "");
  ASSERT_EQ(Run("calibrate --bench small.toml run.csv -o rig.json").err, "");
  Write("small.toml", "# of the second cupboard\n" + Small());
  EXPECT_EQ(Run("diagnose --bench small.toml --calibration rig.json run.csv").exit_code, 0);
  Write("small.toml", Small("k = 4.0", "k = 4.1"));
  const Finished changed = Run("diagnose --bench small.toml --calibration rig.json run.csv");
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_TRUE(
      Holds(changed.err, "the bench 'small' was described otherwise when this was measured"))
      << changed.err;
}

TEST_F(CliBench, ADriversVoltageIsNoChannelToDiagnoseBy) {
  Write("um.toml", Small() + "[channel.um]\nnoise = 0.02\n");
  const Finished run = Run("isolability --bench um.toml --channels um");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(Holds(run.err, "has a driver, whose voltage says little of the motor")) << run.err;
}

TEST_F(CliBench, SimulateNotesAnInputThatARigRefuses) {
  const Finished run =
      Run("simulate --bench mine.toml --excitation prbs:low=-1,high=2 --duration 2 -o run.csv");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(Holds(run.err, "note: the excitation goes from -1 V to 2 V")) << run.err;
}

TEST_F(CliBench, RefusalsSayWhatWasExpected) {
  Write("bad.toml", "[bench]\nname = \"x\"\nstructure = \"motor-driver\"\nperiod_s = 1\n");
  const std::pair<std::string, std::string> cases[] = {
      {"bench check bad.toml", "bad.toml:4: bench.period_s must be a number from 0.001 to 0.1"},
      {"bench check none.toml", "none.toml"},
      {"bench new --structure x", "expected one of inverting-amplifier, motor-driver"},
      {"simulate --bench mine.toml --fault R1=3@5 -o x.csv", "expected one of Ra, Ke, J, B, k"},
      {"simulate --bench mine.toml --profile multisim -o x.csv",
       "no profile multisim. Known: \"bench\""},
      {"isolability --bench mine.toml --channels um", "does not measure um"},
      {"reproduce --bench mine.toml", "has not a published fault of R1"}};
  for (const auto& [arguments, message] : cases) {
    const Finished run = Run(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_TRUE(Holds(run.err, message)) << arguments << "\n" << run.err;
  }
}

}  // namespace
}  // namespace faultlab::server
