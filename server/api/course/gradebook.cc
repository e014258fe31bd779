#include "server/api/course/gradebook.h"

#include <boost/json.hpp>
#include <initializer_list>
#include <map>
#include <string_view>

#include "server/api/iso8601.h"
#include "server/course/statistics.h"
#include "server/json/plain_numbers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using course::Trial;
using course::TrialState;

std::optional<double> PointsShown(const Trial& trial) {
  return trial.released_at ? course::PointsOf(trial) : std::nullopt;
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

std::string Row(std::initializer_list<std::string> fields) {
  std::string row;
  for (const std::string& field : fields) row += (row.empty() ? "" : ",") + field;
  return row + "\r\n";
}

std::string PointsText(const GradebookLine& line) {
  return line.points ? NumberText(*line.points) : "";
}

std::string RowOf(const GradebookLine& line) {
  const Trial* trial = line.counts;
  return Row({std::to_string(line.account),
              CsvField(line.login),
              CsvField(line.name),
              PointsText(line),
              line.points ? NumberText(*line.points) + "%" : "",
              std::to_string(line.attempts),
              trial != nullptr ? std::to_string(trial->id) : "",
              trial != nullptr ? std::string(Name(trial->state))
              : line.voided    ? "void"
                               : "not_begun",
              NumberText(line.late_percent),
              line.overridden ? "yes" : "no",
              trial != nullptr && trial->answered_at ? Iso8601(*trial->answered_at) : ""});
}

}  // namespace

std::string NumberText(double value) {
  return WithPlainNumbers(json::serialize(json::value(value)));
}

std::string CsvField(const std::string& text) {
  constexpr std::string_view kBeginsFormula = "=+-@\t\r\n";
  std::string out = "\"";
  if (!text.empty() && kBeginsFormula.find(text.front()) != std::string_view::npos) out += "'";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

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
    for (const std::int64_t member : members(trial)) {
      const auto at = place.find(member);
      if (at != place.end()) Take(trial, last_counts, lines[at->second]);
    }
  }
  for (GradebookLine& line : lines) Finish(line);
  return lines;
}

std::string GradebookText(std::span<const GradebookLine> lines,
                          const std::string& exercise,
                          GradebookFor whose) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::string text;
  switch (whose) {
    case GradebookFor::kMoodle:
      text = Row({"Username", CsvField("Full name"), CsvField(exercise)});
      for (const GradebookLine& line : lines) {
        if (line.points) text += Row({CsvField(line.login), CsvField(line.name), PointsText(line)});
      }
      return text;
    case GradebookFor::kCanvas:
      text = Row({"Student", "ID", "SIS User ID", "SIS Login ID", "Section", CsvField(exercise)}) +
             Row({"    Points Possible", "", "", "", "", "100"});
      for (const GradebookLine& line : lines) {
        if (!line.points) continue;
        text += Row({CsvField(line.name), "", "", CsvField(line.login), "", PointsText(line)});
      }
      return text;
    case GradebookFor::kExcel:
      text = kByteOrderMark;
      break;
    case GradebookFor::kAnybody:
      break;
  }
  text +=
      "id,login,name,points,percent,attempts,trial,state,late_percent,overridden,answered_at\r\n";
  for (const GradebookLine& line : lines) text += RowOf(line);
  return text;
}

}  // namespace faultlab::server
