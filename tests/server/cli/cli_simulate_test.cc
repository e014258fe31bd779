#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

using CliSimulate = ChildProgram;

TEST_F(CliSimulate, WritesTheSameBytesForTheSameSeed) {
  ASSERT_EQ(Run("simulate --fault R1=100@10 --seed 3 -o a.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --fault R1=100@10 --seed 3 -o b.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --fault R1=100@10 --seed 4 -o c.csv").exit_code, 0);
  EXPECT_EQ(Read("a.csv"), Read("b.csv"));
  EXPECT_NE(Read("a.csv"), Read("c.csv"));
  EXPECT_NE(Read("a.csv").find("# fault R1=100@10\n"), std::string::npos);
  EXPECT_NE(Read("a.csv").find("\nt_s,uc_v,um_v,ua_v,ia_a,n_rpm\n"), std::string::npos);
}

TEST_F(CliSimulate, CompressesByNameAndWritesToTheStandardOutput) {
  ASSERT_EQ(Run("simulate --duration 2 -o a.csv.gz").exit_code, 0);
  EXPECT_EQ(Read("a.csv.gz").substr(0, 2), "\x1F\x8B");
  const Finished printed = Run("simulate --duration 2 -o -");
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_EQ(printed.out.substr(0, 11), "# faultlab ");
}

TEST_F(CliSimulate, TakesEveryExcitation) {
  ASSERT_EQ(Run("simulate --duration 3 -o base.csv").exit_code, 0);
  for (const std::string excitation : {"prbs:low=1,high=4,clock=0.02,order=8,seed=9",
                                       "step:low=1,high=2,at=0.5",
                                       "multisine:offset=2.5,amplitude=1,lines=10,base=1",
                                       "chirp:offset=2.5,amplitude=1,from=1,to=10",
                                       "file:base.csv"}) {
    const Finished run = Run("simulate --duration 3 --excitation " + excitation + " -o x.csv");
    EXPECT_EQ(run.exit_code, 0) << excitation << ": " << run.err;
  }
}

TEST_F(CliSimulate, RefusesBadOptionsByNameAndWritesNothing) {
  const std::pair<std::string, std::string> cases[] = {
      {"--fault R13=100@10",
       "faultlab: fault 'R13=100@10': unknown component 'R13', expected one of R1, R9, R12, C8, "
       "Ra, J, B, La\n"},
      {"--fault R1=0@10", "faultlab: fault 'R1=0@10': value '0' must be a number above 0 in ohm\n"},
      {"--fault R1=100@25",
       "faultlab: fault 'R1=100@25': it comes after the end of the run at 20.000000 s\n"},
      {"--excitation prbs:high=11",
       "faultlab: excitation: 11.000000 V is beyond the converter's range of -10 V to 10 V\n"},
      {"--excitation prbs:hihg=3",
       "faultlab: excitation: 'hihg=3' is not NAME=NUMBER with one of low, high, clock, order, "
       "seed\n"},
      {"--excitation prbs:order=2.5",
       "faultlab: excitation: order must be a whole number, found '2.5'\n"},
      {"--excitation prbs:low=1,low=2", "faultlab: excitation: low is given twice\n"},
      {"--excitation noise",
       "faultlab: excitation 'noise' is not known, expected prbs, step, multisine or chirp\n"},
      {"--duration 1e9",
       "faultlab: the run would have more than 4000000 samples; use a shorter --duration\n"},
      {"--period 0",
       "faultlab: --period must be above the profile's delay of 9.500000 ms and at most 1 s\n"}};
  for (const auto& [arguments, message] : cases) {
    const Finished run = Run("simulate -o never.csv " + arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_EQ(run.err, message);
  }
  for (const std::string arguments : {"simulate",
                                      "simulate -o x.csv --duration 0",
                                      "simulate -o x.csv --profile nobench",
                                      "simulate -o x.csv --duration minus",
                                      "nonsense",
                                      "",
                                      "simulate -o x.csv --what"}) {
    const Finished run = Run(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_FALSE(run.err.empty()) << arguments;
  }
  EXPECT_EQ(Listing(), "");
}

TEST_F(CliSimulate, LeavesNothingHalfWrittenWhenTheDiskIsFull) {
  const Finished device = Run("simulate -o /dev/full");
  EXPECT_EQ(device.exit_code, 1);
  EXPECT_EQ(device.err, "faultlab: cannot write /dev/full: No space left on device\n");
  // A limit on the size of files replaces a disk that becomes full during the write.
  const Finished limited = Run("simulate -o run.csv", "ulimit -f 8; trap '' XFSZ;");
  EXPECT_EQ(limited.exit_code, 1);
  EXPECT_EQ(limited.err, "faultlab: cannot write run.csv: File too large\n");
  EXPECT_EQ(Run("simulate -o no/such/run.csv").exit_code, 1);
  EXPECT_EQ(Listing(), "");
}

TEST_F(CliSimulate, TeachesItselfByHelp) {
  const Finished version = Run("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out.substr(0, 9), "faultlab ");
  for (const std::string command :
       {"serve", "simulate", "diagnose", "plot", "reproduce", "rig", "admin"}) {
    const Finished help = Run(command + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_NE(help.out.find("Examples:"), std::string::npos) << command;
    EXPECT_NE(Run("--help").out.find(command), std::string::npos);
  }
}

}  // namespace
}  // namespace faultlab::server
