// Records of another unit or another rig, diagnosed by a stored calibration.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnose_record.h"
#include "tests/core/diagnosis/real_motors.h"

namespace faultlab::core {
namespace {

constexpr double kRpm = 9.549296585513721;

/// What is said of a record with a heavier rotor from 10 s on, spoilt.
Verdict VerdictOf(const std::function<void(Sample&)>& spoil) {
  const Setting gear = Settings().front();
  const std::vector<Sample> healthy = RecordFor(gear.rig, gear.rig, 1e9, 20.0, 5);
  CalibrationOptions options;
  options.bench = gear.bench;
  options.data_sheet = gear.bench->nominal;
  options.period_s = gear.rig.period_s;
  const Result<Calibration> learnt = Calibrate(healthy, options);
  EXPECT_TRUE(learnt.ok());
  Rig faulty = gear.rig;
  faulty.j *= 2.0;
  std::vector<Sample> record = RecordFor(gear.rig, faulty, 10.0, 16.0, 6);
  for (Sample& sample : record) spoil(sample);
  DiagnosisOptions diagnosis = OptionsOf(*gear.bench);
  diagnosis.calibration = learnt.value();
  const Diagnosis said = DiagnoseRecord(record, diagnosis);
  if (!said.episodes.empty()) {
    EXPECT_EQ(said.episodes.back().verdict.reason, said.verdict.reason);
  }
  return said.verdict;
}

TEST(WrongRecord, IsNamedAsTheRecordAndNotAsAFault) {
  struct Spoilt {
    std::function<void(Sample&)> by;
    const char* said;
  };
  const Spoilt cases[] = {
      {[](Sample& s) { s.n_rpm /= kRpm; }, "it fits when n is multiplied by 9.549"},
      {[](Sample& s) { s.ia_a *= -1.0; }, "it fits with the other sign of ia"},
      {[](Sample& s) { s.uc_v *= 1e-3; }, "it fits when uc is multiplied by 1000"},
  };
  for (const Spoilt& spoilt : cases) {
    const Verdict verdict = VerdictOf(spoilt.by);
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault) << spoilt.said;
    EXPECT_EQ(verdict.reason.find("the record is not of the calibrated rig"), 0U) << verdict.reason;
    EXPECT_NE(verdict.reason.find(spoilt.said), std::string::npos) << verdict.reason;
  }
}

TEST(WrongRecord, IsNeverNominal) {
  // The supply's end hides how far off the input is.
  const Verdict verdict = VerdictOf([](Sample& s) { s.uc_v *= 1e3; });
  EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault) << verdict.reason;
}

TEST(WrongRecord, RightOneIsDiagnosedAsBefore) {
  const Verdict verdict = VerdictOf([](Sample&) {});
  EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
  EXPECT_EQ(verdict.reason.find("the record is not"), std::string::npos);
}

}  // namespace
}  // namespace faultlab::core
