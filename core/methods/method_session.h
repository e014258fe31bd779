#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/methods/method_list.h"
#include "core/types/result.h"

namespace faultlab::core {

/// What all methods are given for a record of this bench.
struct MethodOptions {
  const Bench* bench = nullptr;  ///< never null
  double period_s = 0.01;
  double healthy_from_s = 0.5;
  double healthy_to_s = 5.0;
  /// Readings beside the fitted channel, for the methods that use them.
  Channels channels = Channels::kUmOnly;
  std::uint64_t seed = 1;
};

/// The usual ones for a bench and a period.
MethodOptions MethodOptionsOf(const Bench& bench, double period_s);

/// Calibrates on [healthy_from_s, healthy_to_s) of the record. Refuses as core/calibration does.
Result<MethodTask> PrepareMethods(std::span<const Sample> samples, const MethodOptions& options);

/// One method over one record, from the end of the healthy stretch on.
class MethodSession {
 public:
  /// `tuning` and `level` of the method in place of info's.
  MethodSession(const MethodInfo& info, MethodTask task, double tuning, double level);
  MethodSession(const MethodInfo& info, const MethodTask& task)
      : MethodSession(info, task, info.tuning, info.LevelFor(task.channels)) {}

  /// True when this sample raises the alarm.
  bool Push(const Sample& sample);
  double statistic() const { return method_->statistic(); }
  bool alarmed() const { return alarmed_at_s_.has_value(); }
  std::optional<double> alarmed_at_s() const { return alarmed_at_s_; }
  MethodFinding Diagnose() { return method_->Diagnose(); }
  std::size_t bytes() const { return method_->bytes(); }

 private:
  ObservationBuilder builder_;
  std::unique_ptr<Method> method_;
  double level_;
  std::optional<double> alarmed_at_s_;
};

/// What a method says of a record at given times after its alarm.
struct MethodLook {
  double after_s = 0.0;  ///< after the alarm; the last look is at the end of the record
  MethodFinding finding;
};
struct MethodRun {
  std::string_view method;
  std::optional<double> alarmed_at_s;
  std::vector<MethodLook> looks;  ///< empty without an alarm
};

/// When a diagnosis after the alarm is asked, seconds.
inline constexpr std::array<double, 4> kLookAfterS = {0.2, 0.5, 1.0, 5.0};

/// The method over the whole record. `task` from PrepareMethods.
MethodRun RunMethod(const MethodInfo& info,
                    const MethodTask& task,
                    std::span<const Sample> samples,
                    double from_s);

}  // namespace faultlab::core
