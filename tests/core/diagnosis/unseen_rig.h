#pragma once

// For benches that are not among the shipped ones, described in a few lines each: what their
// diagnoses are asked.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "hardware/bench/benches.h"
#include "tests/core/diagnosis/motor_rig.h"
#include "tests/core/diagnosis/verdicts.h"

namespace faultlab::core {

inline constexpr double kHealthyS = 8.0;
inline constexpr double kDurationS = 14.0;

// `faulty` from kHealthyS on.
inline std::vector<Sample> Record(const Rig& rig, const Rig& faulty, unsigned seed) {
  return RecordFor(rig, faulty, kHealthyS, kDurationS, seed);
}

inline const Bench& BenchOf(const std::string& text) {
  const Result<const Bench*> bench = hardware::KeepBench(text, "unseen.toml");
  if (!bench.ok()) throw std::runtime_error(bench.error().message);
  return *bench.value();
}

inline Diagnosis Diagnose(const Bench& bench, const std::vector<Sample>& record) {
  DiagnosisOptions options = OptionsOf(bench);
  options.healthy_to_s = kHealthyS - 0.5;
  return DiagnoseRecord(record, options);
}

inline void ExpectNamed(const Bench& bench,
                        const std::vector<Sample>& record,
                        const char* symbol,
                        double value,
                        double allowed) {
  const Diagnosis diagnosis = Diagnose(bench, record);
  ASSERT_FALSE(diagnosis.calibration_refusal.has_value()) << diagnosis.calibration_refusal->message;
  const Verdict& verdict = diagnosis.verdict;
  const Component component = bench.Find(symbol).value();
  ASSERT_EQ(verdict.kind, VerdictKind::kFault) << symbol << ' ' << value << ": " << verdict.reason;
  ASSERT_EQ(verdict.group, std::vector<Component>{component}) << verdict.reason;
  EXPECT_NEAR(ValueOf(verdict, component), value, allowed * value) << verdict.reason;
  EXPECT_GE(*verdict.detected_at_s, kHealthyS - 1e-9);
}

}  // namespace faultlab::core
