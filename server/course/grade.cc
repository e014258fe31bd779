#include "server/course/grade.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

#include "server/json/json_reader.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

constexpr double kWeightMax = 1000.0;
constexpr double kLimitMinutesMax = 24.0 * 60.0;
constexpr double kHoursADay = 24.0;
constexpr double kBounds = 3.0;  // three standard errors

const core::Candidate* CandidateOf(const core::Diagnosis& diagnosis, core::Component component) {
  for (const core::Candidate& each : diagnosis.verdict.candidates) {
    if (each.component == component) return &each;
  }
  return nullptr;
}

bool InOneGroup(const core::Diagnosis& diagnosis, core::Component a, core::Component b) {
  const std::vector<core::Component>& group = diagnosis.verdict.group;
  return std::ranges::find(group, a) != group.end() && std::ranges::find(group, b) != group.end();
}

double BoundOf(const core::Candidate* candidate) {
  if (candidate == nullptr || !(candidate->sigma > 0.0) || candidate->value <= 0.0) return 0.0;
  return candidate->sigma / candidate->value;
}

double ValueShare(double answered, double right, double full, double none) {
  const double off = std::abs(std::log(answered / right));
  const double full_log = std::log1p(full);
  const double none_log = std::max(std::log1p(none), 2.0 * full_log);
  return std::clamp((none_log - off) / (none_log - full_log), 0.0, 1.0);
}

}  // namespace

core::Result<Rubric> ParseRubric(const json::object& body) {
  ObjectReader in(body, "/rubric");
  Rubric rubric;
  rubric.detection = in.NumberOr("detection", rubric.detection, 0.0, kWeightMax);
  rubric.isolation = in.NumberOr("isolation", rubric.isolation, 0.0, kWeightMax);
  rubric.value = in.NumberOr("value", rubric.value, 0.0, kWeightMax);
  rubric.confidence = in.NumberOr("confidence", rubric.confidence, 0.0, kWeightMax);
  rubric.full_within = in.NumberOr("full_within", rubric.full_within, 0.0, 1.0);
  rubric.none_beyond = in.NumberOr("none_beyond", rubric.none_beyond, 0.01, 10.0);
  rubric.late_h = in.NumberOr("late_h", rubric.late_h, 0.0, kLateHoursMax);
  rubric.late_percent_a_day =
      in.NumberOr("late_percent_a_day", rubric.late_percent_a_day, 0.0, 100.0);
  rubric.hint_percent = in.NumberOr("hint_percent", rubric.hint_percent, 0.0, 100.0);
  rubric.time_limit_min =
      in.NumberOr("time_limit_min", rubric.time_limit_min, 0.0, kLimitMinutesMax);
  rubric.last_counts = in.WordOr("counts", "best", {"best", "last"}) == "last";
  rubric.uploads_wait = in.BooleanOr("uploads_wait", rubric.uploads_wait);
  if (rubric.none_beyond <= rubric.full_within) {
    in.Refuse("none_beyond", "pool_range_backwards");
  }
  if (rubric.detection + rubric.isolation + rubric.value + rubric.confidence <= 0.0) {
    in.Refuse("detection", "rubric_empty");
  }
  if (auto error = in.Finish()) return *error;
  return rubric;
}

core::Result<Rubric> ParseRubric(std::string_view document) {
  TRY(auto body, ParseJsonObject(document));
  return ParseRubric(body);
}

bool LosesByLateness(std::string_view rubric_document) {
  const auto rubric = ParseRubric(rubric_document);
  return rubric && rubric.value().late_percent_a_day > 0.0;
}

bool GradesAlike(std::string_view one, std::string_view other) {
  auto a = ParseRubric(one);
  auto b = ParseRubric(other);
  if (!a || !b) return one == other;
  a.value().uploads_wait = b.value().uploads_wait = false;
  a.value().last_counts = b.value().last_counts = false;
  return ToJson(a.value()) == ToJson(b.value());
}

bool CountsAlike(std::string_view one, std::string_view other) {
  const auto a = ParseRubric(one);
  const auto b = ParseRubric(other);
  return a && b && a.value().last_counts == b.value().last_counts;
}

json::object ToJson(const Rubric& rubric) {
  return {{"detection", rubric.detection},
          {"isolation", rubric.isolation},
          {"value", rubric.value},
          {"confidence", rubric.confidence},
          {"full_within", rubric.full_within},
          {"none_beyond", rubric.none_beyond},
          {"late_h", rubric.late_h},
          {"late_percent_a_day", rubric.late_percent_a_day},
          {"time_limit_min", rubric.time_limit_min},
          {"hint_percent", rubric.hint_percent},
          {"counts", rubric.last_counts ? "last" : "best"},
          {"uploads_wait", rubric.uploads_wait}};
}

Grade GradeAnswer(const Answer& answer,
                  std::span<const core::Fault> truth,
                  const core::Diagnosis& diagnosis,
                  const Rubric& rubric,
                  double late_h,
                  double length_s,
                  double hint_percent) {
  Grade grade;
  grade.tolerance = rubric.full_within;
  if (!truth.empty() && truth.front().at_s >= length_s) {
    grade.cut = true;
    return grade;
  }
  if (truth.empty()) {
    grade.right = !answer.component;
    grade.detection = grade.isolation = grade.value = grade.right ? 1.0 : 0.0;
  } else if (answer.component) {
    grade.detection = 1.0;
    const core::Fault& fault = truth.front();
    const core::Candidate* candidate = CandidateOf(diagnosis, *answer.component);
    const bool exact = *answer.component == fault.component;
    // Another component has a value only as a candidate.
    const bool alike =
        !exact && candidate != nullptr && InOneGroup(diagnosis, *answer.component, fault.component);
    grade.right = exact || alike;
    if (grade.right) {
      grade.isolation = 1.0;
      grade.bound = BoundOf(candidate);
      grade.tolerance = std::max(rubric.full_within, kBounds * grade.bound);
      grade.value = ValueShare(answer.value,
                               exact ? fault.value : candidate->value,
                               grade.tolerance,
                               rubric.none_beyond);
    }
  }
  const double off = answer.confidence - (grade.right ? 1.0 : 0.0);
  grade.confidence = 1.0 - off * off;
  const double weights = rubric.detection + rubric.isolation + rubric.value + rubric.confidence;
  const double sum = rubric.detection * grade.detection + rubric.isolation * grade.isolation +
                     rubric.value * grade.value + rubric.confidence * grade.confidence;
  const double days = std::ceil(std::max(0.0, late_h) / kHoursADay);
  grade.late_percent = std::min(100.0, days * rubric.late_percent_a_day);
  grade.hint_percent = std::min(100.0, hint_percent);
  const double kept = (1.0 - grade.late_percent / 100.0) * (1.0 - grade.hint_percent / 100.0);
  grade.points = std::round(1000.0 * kept * sum / weights) / 10.0;
  return grade;
}

json::object ToJson(const Grade& grade) {
  return {{"points", grade.points},
          {"detection", grade.detection},
          {"isolation", grade.isolation},
          {"value", grade.value},
          {"confidence", grade.confidence},
          {"right", grade.right},
          {"bound", grade.bound},
          {"tolerance", grade.tolerance},
          {"late_percent", grade.late_percent},
          {"hint_percent", grade.hint_percent},
          {"cut", grade.cut}};
}

}  // namespace faultlab::server::course
