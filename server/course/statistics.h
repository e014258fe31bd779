#pragma once

#include <boost/json/object.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/course/trials.h"

namespace faultlab::server::course {

/// One fault of an assignment, over all released trials that had it. "" stands for a healthy rig.
struct FaultStatistics {
  std::string fault;  ///< symbol of its component
  int trials = 0;     ///< answered or not
  int answered = 0;
  double right = 0.0;   ///< share of the answered: how easy it is
  double points = 0.0;  ///< mean of the answered
  /// Correlation of being right here with a person's mean points elsewhere in the assignment:
  /// whether those who know more find it. None with fewer than three such persons, or where all
  /// were alike. Source: point-biserial item discrimination, F. M. Lord, M. R. Novick, Statistical
  /// Theories of Mental Test Scores (1968), section 15.2.
  std::optional<double> discrimination;
  std::vector<std::pair<std::string, int>> answers;  ///< what was said of it, most frequent first
};

struct Statistics {
  int students = 0;                     ///< who have a released trial
  int answered = 0;                     ///< trials
  std::optional<double> points;         ///< mean of the answered
  std::vector<FaultStatistics> faults;  ///< in the order of their symbols, the healthy rig first
};

/// Of what is released; nothing else is looked at. A teacher's points count in place of the grade.
Statistics StatisticsOf(std::span<const Trial> trials);
boost::json::object ToJson(const Statistics& statistics);

/// The points that count: a teacher's, else those of the grade; none without an answer.
std::optional<double> PointsOf(const Trial& trial);

}  // namespace faultlab::server::course
