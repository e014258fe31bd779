#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/component.h"

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
};

/// One test on the decision path (paper Fig. 21): the number that decided, its threshold, and the
/// answer.
struct PathStep {
  std::string question;  ///< "b0 outside its band?"
  bool answer = false;
  double value = 0.0;      ///< the number that decided
  double threshold = 0.0;  ///< the number that it was compared with
  std::string leads_to;    ///< next test or the component named
};

struct Verdict {
  VerdictKind kind = VerdictKind::kCalibrating;
  std::optional<double> detected_at_s;  ///< time of the sample at which the alarm was raised
  std::optional<double> onset_s;        ///< estimated time of the change
  std::string detector;                 ///< which test of the bank raised it
  std::vector<Component> group;         ///< cannot be separated by a sensor; one entry = isolated
  std::vector<Candidate> candidates;    ///< best first
  std::vector<PathStep> path;           ///< the paper's decision algorithm, in the order taken
  bool settled = false;                 ///< false until the window after the fault is full
  std::string reason;                   ///< one sentence for a person
};

}  // namespace faultlab::core
