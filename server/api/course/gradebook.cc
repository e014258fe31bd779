#include "server/api/course/gradebook.h"

#include <algorithm>
#include <boost/json.hpp>
#include <initializer_list>
#include <string_view>

#include "server/api/iso8601.h"
#include "server/json/plain_numbers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using course::GradebookLine;
using course::Trial;

std::string Row(std::initializer_list<std::string> fields, char separator = ',') {
  std::string row;
  for (const std::string& field : fields) {
    if (&field != fields.begin()) row += separator;
    row += field;
  }
  return row + "\r\n";
}

std::string PointsText(const GradebookLine& line) {
  return line.points ? NumberText(*line.points) : "";
}

std::string RowOf(const GradebookLine& line, bool comma) {
  const Trial* trial = line.counts;
  const auto number = [comma](std::string text) {
    if (comma) std::ranges::replace(text, '.', ',');
    return text;
  };
  return Row({std::to_string(line.account),
              CsvField(line.login),
              CsvField(line.name),
              number(PointsText(line)),
              line.points ? number(NumberText(*line.points)) + "%" : "",
              std::to_string(line.attempts),
              trial != nullptr ? std::to_string(trial->id) : "",
              trial != nullptr ? std::string(Name(trial->state))
              : line.voided    ? "void"
                               : "not_begun",
              number(NumberText(line.late_percent)),
              line.overridden ? "yes" : "no",
              trial != nullptr && trial->answered_at ? Iso8601(*trial->answered_at) : ""},
             comma ? ';' : ',');
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
    case GradebookFor::kExcelComma:
      text = kByteOrderMark;
      break;
    case GradebookFor::kAnybody:
      break;
  }
  const bool comma = whose == GradebookFor::kExcelComma;
  text += Row({"id",
               "login",
               "name",
               "points",
               "percent",
               "attempts",
               "trial",
               "state",
               "late_percent",
               "overridden",
               "answered_at"},
              comma ? ';' : ',');
  for (const GradebookLine& line : lines) text += RowOf(line, comma);
  return text;
}

}  // namespace faultlab::server
