#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/isolability/isolability_options.h"
#include "core/methods/method_session.h"
#include "core/numerics/statistics.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// A record that the methods are tried on.
struct MethodRecord {
  std::string name;
  std::vector<core::Sample> samples;
  double period_s = 0.01;
  std::vector<core::Fault> faults;         ///< empty: healthy
  std::vector<core::Component> same_kind;  ///< of one fault: itself, and what no sensor separates
};

/// What one method did with one record.
struct MethodOutcome {
  std::string_view method;
  std::string record;                  ///< MethodRecord::name
  std::optional<core::Fault> fault{};  ///< of the record
  std::optional<double> alarmed_at_s;  ///< the first alarm, false or not
  core::MethodFinding finding;         ///< of the end; empty without a true alarm

  std::string refused{};     ///< why there is no calibration; empty: there is one
  bool false_alarm = false;  ///< before the fault, or without one
  bool detected = false;
  double delay_samples = 0.0;
  std::vector<bool> isolated;  ///< at each of core::kLookAfterS after the alarm, then at the end
  double error = 0.0;          ///< relative, at the end; NaN where the method names another or none
  double watched_s = 0.0;      ///< healthy time that it watched
  double sample_us = 0.0;      ///< mean time of a sample
  double diagnosis_ms = 0.0;   ///< of the last diagnosis
  std::size_t bytes = 0;
};

/// How thoroughly: the counts are of seeds.
struct MethodStudyOptions {
  const core::Bench* bench = nullptr;        ///< never null
  std::optional<core::Channels> channels{};  ///< nullopt: those that the bench's estimators use
  std::vector<std::string> methods;          ///< names; empty: all
  int trials = 10;                           ///< records of each fault
  double healthy_hours = 6.0;                ///< of each method, for its false alarms
  std::uint64_t seed = 1000;                 ///< of the first; not of tests/bench/method_tunings
};

/// What the figures say of one method.
struct MethodRow {
  const core::MethodInfo* info = nullptr;
  bool fits = true;  ///< false: made for another bench, not run
  int faulty = 0;    ///< records with a fault
  int detected = 0;
  int refused = 0;
  int false_alarms = 0;
  double watched_days = 0.0;
  std::vector<double> delays;        ///< samples, of detected faults
  std::vector<int> isolated;         ///< at each look
  std::vector<double> errors;        ///< relative
  std::vector<double> sample_us;     ///< mean of each record with a fault
  std::vector<double> diagnosis_ms;  ///< of each record
  std::size_t bytes = 0;
  std::vector<int> isolated_of;  ///< by fault, at the end
  std::vector<double> error_of;  ///< by fault, median, NaN: none
  std::vector<double> delay_of;  ///< by fault, median of the detected, NaN: none
  std::vector<int> detected_of;  ///< by fault

  /// A sample's work, and a diagnosis once after the alarm, take less than the period.
  bool in_time(double period_s) const {
    return info->pace != core::MethodPace::kAfterwards &&
           core::Quantile(sample_us, 0.5) * 1e-6 < period_s;
  }
};

struct MethodStudy {
  MethodStudyOptions options;
  std::vector<core::FaultSize> faults;
  std::vector<int> records_of;  ///< by fault
  int recordings = 0;           ///< given ones; 0: simulated
  double period_s = 0.01;
  std::vector<MethodOutcome>
      outcomes;  ///< of each record and method, without healthy simulated ones
  std::vector<MethodRow> rows;
};

/// What the methods of a study are given for a record of this period.
core::MethodOptions TaskOptions(const MethodStudyOptions& options, double period_s);

/// Hears of work done, 0..1; false stops the study.
using Progress = std::function<bool(double)>;

/// The record of a fault: the bench's first simulator under its usual excitation, 20 s at 100 Hz,
/// the fault near the middle. No fault: healthy.
MethodRecord SimulateMethodRecord(const core::Bench& bench,
                                  const core::FaultSize* fault,
                                  std::uint64_t seed,
                                  std::size_t samples);

/// One method over one record; the period of `options` is that of the record.
MethodOutcome TryMethod(const core::MethodInfo& info,
                        const core::MethodOptions& options,
                        const MethodRecord& record,
                        double tuning,
                        double level);

/// On simulated runs of every fault of the bench, and on healthy ones.
MethodStudy StudyMethods(const MethodStudyOptions& options, const Progress& progress);
/// On given records.
MethodStudy StudyRecordings(const MethodStudyOptions& options,
                            const std::vector<MethodRecord>& records,
                            const Progress& progress);

}  // namespace faultlab::server
