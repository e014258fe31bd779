#include "server/course/gradebook.h"

#include <boost/json.hpp>
#include <map>

#include "server/course/statistics.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

std::optional<double> PointsShown(const Trial& trial) {
  return trial.released_at ? PointsOf(trial) : std::nullopt;
}

/// Whether `next`, which began later, counts more than `now`.
bool CountsMore(const Trial& next, const Trial& now, bool last_counts) {
  const auto counts = [](const Trial& trial) {
    return trial.state == TrialState::kAnswered || !trial.awarded.empty();
  };
  const bool answered = counts(next);
  if (answered != counts(now)) return answered;
  if (last_counts || !answered) return true;
  return PointsShown(next).value_or(-1.0) > PointsShown(now).value_or(-1.0);
}

void Take(const Trial& trial, bool last_counts, GradebookLine& line) {
  line.voided = line.voided || trial.state == TrialState::kVoid;
  if (trial.state == TrialState::kVoid) return;
  ++line.attempts;
  if (line.counts == nullptr || CountsMore(trial, *line.counts, last_counts)) line.counts = &trial;
}

void Finish(GradebookLine& line) {
  if (line.counts == nullptr) return;
  const Trial& trial = *line.counts;
  line.points = PointsShown(trial);
  line.overridden = line.points.has_value() && !trial.awarded.empty();
  if (!trial.released_at || trial.grade.empty()) return;
  const json::value grade = json::parse(trial.grade);
  const json::value* late = grade.as_object().if_contains("late_percent");
  if (late != nullptr) line.late_percent = late->to_number<double>();
}

}  // namespace

std::vector<GradebookLine> GradebookOf(
    std::span<const Student> students,
    std::span<const Trial> trials,
    bool last_counts,
    const std::function<std::vector<std::int64_t>(const Trial&)>& members) {
  std::vector<GradebookLine> lines;
  std::map<std::int64_t, std::size_t> place;
  for (const Student& each : students) {
    place[each.account] = lines.size();
    GradebookLine& line = lines.emplace_back();
    line.account = each.account;
    line.login = each.login;
    line.name = each.name;
  }
  for (const Trial& trial : trials) {
    if (trial.tried) continue;
    for (const std::int64_t member : members(trial)) {
      const auto at = place.find(member);
      if (at != place.end()) Take(trial, last_counts, lines[at->second]);
    }
  }
  for (GradebookLine& line : lines) Finish(line);
  return lines;
}

}  // namespace faultlab::server::course
