// reports/use, as JSON and as a table: how rigs were used, by rig, class, course, person or month.
#include <boost/json.hpp>

#include "server/api/course/gradebook.h"
#include "server/api/operate/handlers.h"
#include "server/lab/usage_report.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::usage_report::By;
using lab::usage_report::Line;

constexpr auto kReportOf = std::chrono::hours(24 * 30);
constexpr auto kReportMax = std::chrono::hours(24 * 400);

/// An operator sees all, a teacher what their courses did.
core::Result<std::optional<lab::Courses>> CoursesOfReport(Api& api, const ApiRequest& request) {
  const core::Status all = Authorize(request.who, Operation::kReadAudit, Ownership::kNone);
  if (all.ok()) return std::optional<lab::Courses>{};
  if (!Authorize(request.who, Operation::kSpectate, Ownership::kCourse).ok()) return all.error();
  TRY(const auto courses, api.accounts.CoursesOf(request.who.user_id));
  lab::Courses taught;
  for (const std::int64_t course : courses) {
    TRY(const auto teaches, api.accounts.Teaches(request.who.user_id, course));
    if (teaches) taught.push_back(course);
  }
  return std::optional(std::move(taught));
}

/// What people call it.
core::Result<std::string> LabelOf(Api& api, By by, const std::string& key) {
  if (key.empty()) return std::string();
  if (by == By::kPerson) {
    const auto account = api.accounts.Get(std::stoll(key));
    if (!account.ok()) return std::string();  // a guest, or somebody who was deleted
    const Account& person = account.value();
    return person.name.empty() ? person.login : person.name + " (" + person.login + ")";
  }
  if (by != By::kCourse) return key;
  TRY(const auto found, api.accounts.FindCourse(std::stoll(key)));
  return found ? found->name : std::string();
}

struct UseAnswer {
  By by = By::kMonth;
  lab::Interval during;
  std::vector<std::pair<std::string, Line>> lines;  ///< each with its label
};

core::Result<UseAnswer> MakeReport(Api& api, const ApiRequest& request) {
  TRY(const auto of_courses, CoursesOfReport(api, request));
  const WallTime now = api.clock.Wall();
  TRY(const auto to, QueryTime(request.http, "to"));
  TRY(const auto from, QueryTime(request.http, "from"));
  UseAnswer out;
  out.during.end = to.value_or(now);
  out.during.start = from.value_or(out.during.end - kReportOf);
  if (out.during.end <= out.during.start || out.during.length() > kReportMax) {
    return core::Refuse("range_too_long", "to");
  }
  TRY(const auto by, QueryWord(request.http, "by", {"rig", "class", "course", "person", "month"}));
  for (const By each : {By::kRig, By::kClass, By::kCourse, By::kPerson, By::kMonth}) {
    if (by == Name(each)) out.by = each;
  }
  TRY(auto lines, lab::usage_report::Report(api.database, {out.by, out.during, of_courses}, now));
  for (Line& line : lines) {
    TRY(auto label, LabelOf(api, out.by, line.key));
    out.lines.emplace_back(std::move(label), std::move(line));
  }
  return out;
}

/// The columns after key and label, in this order.
std::vector<std::pair<std::string_view, json::value>> ColumnsOf(const Line& line) {
  const auto seconds = [](lab::Milliseconds time) { return json::value(time.count() / 1000); };
  const bool waited = line.waits > 0;
  return {{"sessions", line.sessions},
          {"people", line.people},
          {"used_s", seconds(line.used)},
          {"jobs_s", seconds(line.jobs)},
          {"bookings", line.bookings},
          {"no_shows", line.no_shows},
          {"fell", line.fell},
          {"waits", line.waits},
          {"wait_median_s", waited ? seconds(line.wait_median) : json::value()},
          {"wait_p95_s", waited ? seconds(line.wait_p95) : json::value()},
          {"out_s", line.out ? seconds(*line.out) : json::value()}};
}

core::Result<HttpResponse> GetUseReport(Api& api, const ApiRequest& request) {
  TRY(const auto answer, MakeReport(api, request));
  json::array items;
  for (const auto& [label, line] : answer.lines) {
    json::object item{{"key", line.key}, {"label", label}};
    for (const auto& [name, value] : ColumnsOf(line)) item[name] = value;
    items.push_back(std::move(item));
  }
  return JsonResponse(json::object{{"by", Name(answer.by)},
                                   {"from", Iso8601(answer.during.start)},
                                   {"to", Iso8601(answer.during.end)},
                                   {"items", std::move(items)}});
}

core::Result<HttpResponse> GetUseReportTable(Api& api, const ApiRequest& request) {
  TRY(const auto answer, MakeReport(api, request));
  const std::string by(Name(answer.by));
  std::string text = by + ",label";
  for (const auto& [name, value] : ColumnsOf(Line{})) text += "," + std::string(name);
  text += "\r\n";
  for (const auto& [label, line] : answer.lines) {
    text += CsvField(line.key) + "," + CsvField(label);
    for (const auto& [name, value] : ColumnsOf(line)) {
      text += "," + (value.is_null() ? "" : json::serialize(value));
    }
    text += "\r\n";
  }
  HttpResponse response;
  response.content_type = "text/csv; charset=utf-8";
  response.body = std::move(text);
  response.headers.emplace_back("Content-Disposition",
                                ContentDisposition("attachment", "use by " + by + ".csv"));
  return response;
}

}  // namespace

std::span<const ApiRoute> ReportsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "reports/use", kListRigs, kRole, GetUseReport, kNoBody, kHeavy}.Takes(
          "by from to"),
      ApiRoute{kGet, "reports/use.csv", kListRigs, kRole, GetUseReportTable, kNoBody, kHeavy}.Takes(
          "by from to"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
