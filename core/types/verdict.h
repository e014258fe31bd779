#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/component.h"
#include "core/types/speed_response.h"

namespace faultlab::core {

enum class VerdictKind {
  kCalibrating,  ///< the calibration from the healthy stretch is not finished
  kNominal,
  kFault,         ///< one component, or a group that no sensor can separate
  kUnknownFault,  ///< something changed that no single component explains
  kNotExcited,    ///< the input is too poor to answer
};

constexpr std::string_view Name(VerdictKind kind) {
  switch (kind) {
    case VerdictKind::kCalibrating:
      return "calibrating";
    case VerdictKind::kNominal:
      return "nominal";
    case VerdictKind::kFault:
      return "fault";
    case VerdictKind::kUnknownFault:
      return "unknown_fault";
    case VerdictKind::kNotExcited:
      return "not_excited";
  }
  return "?";
}

/// One hypothesis: this component, with this value, and how well it explains the record.
struct Candidate {
  Component component{};
  double value = 0.0;  ///< SI unit of the component
  double sigma = 0.0;  ///< standard error of value, same unit; NaN when only a bound is known
  char bound = 0;      ///< '<' or '>' when value is a bound, 0 when it is an estimate
  double score =
      0.0;  ///< residual sum of squares over its expectation: 1 explains all, more is worse
  double margin =
      0.0;  ///< how much worse than the best candidate, in units of score; 0 for the best
  /// That it is this one, of all candidates and of none of them: their posterior. NaN where nobody
  /// has compared them.
  double probability = std::numeric_limits<double>::quiet_NaN();
};

/// One test on the decision path (paper Fig. 21): the number that decided, its threshold, and the
/// answer.
struct PathStep {
  std::string question;  ///< "b0 outside its band?"
  bool answer = false;
  double value = 0.0;      ///< the number that decided
  double threshold = 0.0;  ///< the number that it was compared with
  std::string leads_to;    ///< the next test, "b0", or its components, "nominal", "no component"
  std::vector<Component> components;  ///< that alone are possible after the answer; empty: unsaid
};

/// One alarm, and the change that raised it.
struct Detection {
  double detected_at_s = 0.0;     ///< time of the sample at which the alarm was raised
  std::optional<double> onset_s;  ///< estimated time of the change
  std::string detector;           ///< which test of the bank raised it
};

/// Whether a detector of the bank (its name) waits for small changes: those of a GLR. The others
/// see what comes at once.
constexpr bool SeesSmallChanges(std::string_view detector) {
  return detector.starts_with("glr");
}

/// A sensor that reads otherwise than before, though the rig has not changed.
struct SensorChange {
  enum class Kind { kZero, kGain, kLost };
  static constexpr std::string_view kKindNames[] = {"zero", "gain", "lost"};
  std::string channel;      ///< "um", "ia", "n"
  Kind kind = Kind::kZero;  ///< lost: what it reads has nothing to do with the rig
  double value = 0.0;       ///< of a zero: V, A, rpm too much; of a gain: times so much; else NaN
  double sigma = 0.0;       ///< standard error of value
};

/// Dry friction of another torque than was learnt, which is no component of the bench.
struct FrictionChange {
  double before_nm = 0.0;
  double after_nm = 0.0;
  double sigma_nm = 0.0;  ///< standard error of after_nm
};

/// What a fault has made of the response of a motor of which voltage and speed alone are known.
struct ResponseChange {
  SpeedResponse before;
  SpeedResponse after;
};

struct Verdict {
  VerdictKind kind = VerdictKind::kCalibrating;
  std::optional<double> detected_at_s;  ///< time of the sample at which the alarm was raised
  std::optional<double> onset_s;        ///< estimated time of the change
  std::string detector;                 ///< which test of the bank raised it
  /// The alarms after that one that belong to the same fault: its value has changed further. The
  /// candidates are what is known since the newest.
  std::vector<Detection> further;
  std::vector<Component> group;       ///< cannot be separated by a sensor; one entry = isolated
  std::vector<Candidate> candidates;  ///< best first
  /// At most one of two, and no component: of kUnknownFault what explains it, of kFault what is not
  /// excluded beside the component.
  std::optional<SensorChange> sensor;
  std::optional<FrictionChange> friction;
  std::optional<ResponseChange> response;  ///< of kFault, where the speed alone is measured
  std::vector<PathStep> path;              ///< the paper's decision algorithm, in the order taken
  bool settled = false;                    ///< false until the window after the fault is full
  std::string reason;                      ///< one sentence for a person
};

/// Whether what is no component explains it.
inline bool IsOutside(const Verdict& verdict) {
  return verdict.kind == VerdictKind::kUnknownFault && (verdict.sensor || verdict.friction);
}

/// That one of those which the verdict names is it; that none of the candidates is, where it is
/// unknown. NaN where one of them has none.
inline double ProbabilityOf(const Verdict& verdict) {
  double named = 0.0;
  double all = 0.0;
  for (const Candidate& each : verdict.candidates) {
    const bool in_group = std::ranges::find(verdict.group, each.component) != verdict.group.end();
    named += in_group ? each.probability : 0.0;
    all += each.probability;
  }
  return verdict.kind == VerdictKind::kFault ? named : 1.0 - all;
}

/// The components of the verdict in the order of the bench: those that no sensor tells apart,
/// otherwise the best one.
inline std::vector<Component> NamedBy(const Verdict& verdict) {
  std::vector<Component> named = verdict.group;
  if (named.empty() && !verdict.candidates.empty()) {
    named.push_back(verdict.candidates.front().component);
  }
  std::sort(named.begin(), named.end(), ByIndex{});
  return named;
}

/// All alarms of the fault, in time order.
inline std::vector<Detection> DetectionsOf(const Verdict& verdict) {
  std::vector<Detection> all;
  if (verdict.detected_at_s) {
    all.push_back({*verdict.detected_at_s, verdict.onset_s, verdict.detector});
  }
  all.insert(all.end(), verdict.further.begin(), verdict.further.end());
  return all;
}

/// Since when the candidates' values hold, as far as it is known.
inline std::optional<double> NewestChange(const Verdict& verdict) {
  if (verdict.further.empty()) {
    return verdict.onset_s ? verdict.onset_s : verdict.detected_at_s;
  }
  const Detection& newest = verdict.further.back();
  return newest.onset_s.value_or(newest.detected_at_s);
}

}  // namespace faultlab::core
