#pragma once

#include <boost/json/object.hpp>
#include <span>
#include <string_view>

#include "core/diagnosis/diagnosis.h"
#include "core/types/fault.h"
#include "server/course/answer.h"

namespace faultlab::server::course {

inline constexpr int kLateHoursMax = 24 * 60;

/// How an answer becomes points. The four weights count relative to their sum.
struct Rubric {
  double detection = 20.0;          ///< healthy or not
  double isolation = 40.0;          ///< which component
  double value = 30.0;              ///< how far its value is off
  double confidence = 10.0;         ///< how well the stated confidence fits
  double full_within = 0.05;        ///< relative error that is as good as none
  double none_beyond = 0.5;         ///< relative error that is as good as no value
  double late_h = 0.0;              ///< so long after it was due an answer is taken still
  double late_percent_a_day = 0.0;  ///< of its points, lost for each day that has begun
  double time_limit_min = 0.0;      ///< an answer is taken so long after its trial began; 0: always
  double hint_percent = 0.0;        ///< of its points, lost for each hint; 0: there are none
  bool last_counts = false;         ///< of several attempts; else the best
  bool uploads_wait = false;        ///< as long as it is open, the lab takes no uploads of members
};
core::Result<Rubric> ParseRubric(const boost::json::object& body);
core::Result<Rubric> ParseRubric(std::string_view document);
boost::json::object ToJson(const Rubric& rubric);
/// Whether an answer loses points when it is late.
bool LosesByLateness(std::string_view rubric_document);
/// Whether an answer gets the same points by both documents.
bool GradesAlike(std::string_view one, std::string_view other);
/// Whether the same of several attempts counts by both documents.
bool CountsAlike(std::string_view one, std::string_view other);

/// Each share is in [0, 1].
struct Grade {
  double points = 0.0;  ///< 0 .. 100, to a tenth
  double detection = 0.0;
  double isolation = 0.0;
  double value = 0.0;
  double confidence = 0.0;
  bool right = false;         ///< the component, or a healthy rig
  double bound = 0.0;         ///< relative standard error of the value that this record allows
  double tolerance = 0.0;     ///< relative error that got all of `value`
  double late_percent = 0.0;  ///< taken off `points`
  double hint_percent = 0.0;  ///< taken off what is left then
  bool cut = false;  ///< the run ended before its fault: nothing was to be found, no points
};

/// A function of its arguments to the bit: graded again, an answer gets the same.
/// - Isolation: the true component, or one that the lab's own diagnosis of the record cannot tell
///   from it; then the value is compared with the one that this component would have.
/// - Value: all within the greater of `full_within` and three times the Cramer-Rao bound of this
///   record, which the diagnosis gives as the standard error of its candidate; nothing beyond
///   `none_beyond`; linear in the logarithm between.
/// - Confidence: 1 - (confidence - right)^2, which is greatest for who says what they believe.
///   Source: G. W. Brier, Monthly Weather Review 78 (1950).
/// @param truth      none, or one fault
/// @param diagnosis  the lab's own, of the whole record
/// @param late_h     hours after it was due; 0: in time
/// @param length_s   of the run; its student has ended it before its planned end, if at all
/// @param hint_percent  taken off for hints
Grade GradeAnswer(const Answer& answer,
                  std::span<const core::Fault> truth,
                  const core::Diagnosis& diagnosis,
                  const Rubric& rubric,
                  double late_h,
                  double length_s,
                  double hint_percent = 0.0);
boost::json::object ToJson(const Grade& grade);

}  // namespace faultlab::server::course
