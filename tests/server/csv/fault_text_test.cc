#include "server/csv/fault_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

using ::testing::HasSubstr;

TEST(FaultText, ReadsAbruptDriftingAndIntermittentFaults) {
  const core::Fault abrupt = ParseFault("R1=100@10", paper::Bench()).value();
  EXPECT_EQ(abrupt.component, paper::kR1);
  EXPECT_EQ(abrupt.value, 100.0);
  EXPECT_EQ(abrupt.at_s, 10.0);
  EXPECT_EQ(abrupt.kind, core::FaultKind::kAbrupt);

  const core::Fault drift = ParseFault("R9=18k@5..17.5", paper::Bench()).value();
  EXPECT_EQ(drift.value, 18000.0);
  EXPECT_EQ(drift.at_s, 5.0);
  EXPECT_EQ(drift.until_s, 17.5);
  EXPECT_EQ(drift.kind, core::FaultKind::kDrift);

  const core::Fault passing = ParseFault("C8=10u@5to8", paper::Bench()).value();
  EXPECT_DOUBLE_EQ(passing.value, 10e-6);
  EXPECT_EQ(passing.until_s, 8.0);
  EXPECT_EQ(passing.kind, core::FaultKind::kIntermittent);
}

TEST(FaultText, WritesWhatItReads) {
  for (const char* text : {"R1=100@10", "J=1.43e-08@0", "R9=18000@5..17.5", "C8=1e-05@5to8"}) {
    EXPECT_EQ(FormatFault(ParseFault(text, paper::Bench()).value()), text);
    EXPECT_EQ(
        FormatFault(FaultsInComments(
            {"other", FaultComment(ParseFault(text, paper::Bench()).value())}, paper::Bench())[0]),
        text);
  }
}

TEST(FaultText, SaysWhichPartOfAFaultIsWrong) {
  const auto error = [](const char* text) {
    const core::Result<core::Fault> fault = ParseFault(text, paper::Bench());
    return fault ? std::string("accepted") : fault.error().message;
  };
  EXPECT_EQ(error("R13=100@10"),
            "fault 'R13=100@10': unknown component 'R13', expected one of R1, R9, R12, C8, Ra, J, "
            "B, La");
  EXPECT_THAT(error("R1=100"), HasSubstr("expected COMPONENT=VALUE@SECONDS"));
  EXPECT_THAT(error("R1=0@10"), HasSubstr("value '0' must be a number above 0 in ohm"));
  EXPECT_THAT(error("C8=-1@10"), HasSubstr("value '-1' must be a number above 0 in farad"));
  EXPECT_THAT(error("R1=@10"), HasSubstr("value '' must be a number"));
  EXPECT_THAT(error("R1=nan@10"), HasSubstr("value 'nan' must be a number"));
  EXPECT_THAT(error("R1=5@ten"), HasSubstr("time 'ten' must be a number of seconds"));
  EXPECT_THAT(error("R1=5@-1"), HasSubstr("0 or more"));
  EXPECT_THAT(error("R1=5@5..x"), HasSubstr("time after '..' must be a number"));
  EXPECT_THAT(error("R1=5@8..5"), HasSubstr("the end must come after the start"));
}

}  // namespace
}  // namespace faultlab::server
