#include "server/lab/usage_report.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "server/storage/rows.h"

namespace faultlab::server::lab::usage_report {
namespace {

constexpr std::array<std::string_view, 5> kNames = {"rig", "class", "course", "person", "month"};

/// What a session or a booking may be counted by.
struct Facts {
  std::int64_t user = 0;
  std::string rig;
  std::string rig_class;
  std::string courses;  ///< "3 17"
  WallTime start{};
};

struct Past : Facts {
  int kind = 0;
  std::uint64_t epoch = 0;
  WallTime hard_end{};
  WallTime ended{};
  WallTime asked{};
};

struct Promise : Facts {
  int state = 0;
};

template <typename Visit>
void Fields(Past& past, Visit&& visit) {
  visit("s.user_id", past.user);
  visit("s.rig", past.rig);
  visit("s.rig_class", past.rig_class);
  visit("s.courses", past.courses);
  visit("s.start_ms", past.start);
  visit("s.kind", past.kind);
  visit("s.epoch", past.epoch);
  visit("s.hard_end_ms", past.hard_end);
  visit("s.ended_ms", past.ended);
  visit("COALESCE(t.created_ms, 0)", past.asked);
}

template <typename Visit>
void Fields(Promise& promise, Visit&& visit) {
  visit("user_id", promise.user);
  visit("rig", promise.rig);
  visit("rig_class", promise.rig_class);
  visit("courses", promise.courses);
  visit("start_ms", promise.start);
  visit("state", promise.state);
}

std::string MonthOf(WallTime time) {
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(time)};
  const int year = int{day.year()};
  const unsigned month = unsigned{day.month()};
  return std::to_string(year) + (month < 10 ? "-0" : "-") + std::to_string(month);
}

WallTime NextMonth(WallTime time) {
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(time)};
  const auto next = std::chrono::year_month{day.year(), day.month()} + std::chrono::months{1};
  return std::chrono::sys_days{next / 1};
}

Milliseconds Share(std::vector<Milliseconds>& waits, double share) {
  if (waits.empty()) return {};
  std::ranges::sort(waits);
  const auto last = static_cast<double>(waits.size() - 1);
  return waits[static_cast<std::size_t>(std::lround(share * last))];
}

class Sums {
 public:
  explicit Sums(const Asked& asked) : asked_(asked) {}

  void Add(const Past& past) {
    const bool person = past.kind == static_cast<int>(TicketKind::kPerson);
    if (past.epoch == 0 || past.kind == static_cast<int>(TicketKind::kPractice)) return;
    const WallTime end = past.ended == WallTime{} ? past.hard_end : past.ended;
    const Milliseconds use = std::max(Milliseconds{0}, end - past.start);
    for (const std::string& key : KeysOf(past)) {
      Line& line = lines_[key];
      (person ? line.used : line.jobs) += use;
      if (!person) continue;
      ++line.sessions;
      people_[key].insert(past.user);
      if (past.asked != WallTime{}) waits_[key].push_back(past.start - past.asked);
    }
  }
  void Add(const Promise& promise) {
    const auto state = static_cast<BookingState>(promise.state);
    if (state == BookingState::kBooked || state == BookingState::kCancelled ||
        state == BookingState::kWaiting) {
      return;
    }
    for (const std::string& key : KeysOf(promise)) {
      Line& line = lines_[key];
      ++line.bookings;
      line.no_shows += state == BookingState::kNoShow ? 1 : 0;
      line.fell += state == BookingState::kUnfulfilled ? 1 : 0;
    }
  }
  /// The rig was out of service.
  void AddOut(const std::string& rig, const std::string& rig_class, Interval out) {
    out.start = std::max(out.start, asked_.during.start);
    out.end = std::min(out.end, asked_.during.end);
    if (out.end <= out.start) return;
    if (asked_.by == By::kRig) Out(rig) += out.length();
    if (asked_.by == By::kClass) Out(rig_class) += out.length();
    while (asked_.by == By::kMonth && out.start < out.end) {
      const WallTime until = std::min(out.end, NextMonth(out.start));
      Out(MonthOf(out.start)) += until - out.start;
      out.start = until;
    }
  }

  std::vector<Line> Lines() {
    std::vector<Line> lines;
    for (auto& [key, line] : lines_) {
      line.key = key;
      line.people = static_cast<int>(people_[key].size());
      std::vector<Milliseconds>& waits = waits_[key];
      line.waits = static_cast<int>(waits.size());
      line.wait_median = Share(waits, 0.5);
      line.wait_p95 = Share(waits, 0.95);
      const bool known = asked_.by != By::kCourse && asked_.by != By::kPerson;
      if (known && !asked_.of_courses && !line.out) line.out = Milliseconds{0};
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  Milliseconds& Out(const std::string& key) {
    std::optional<Milliseconds>& out = lines_[key].out;
    if (!out) out = Milliseconds{0};
    return *out;
  }
  std::vector<std::string> KeysOf(const Facts& facts) const {
    std::vector<std::string> courses;
    std::istringstream in(facts.courses);
    for (std::int64_t each = 0; in >> each;) {
      const bool theirs = !asked_.of_courses || std::ranges::count(*asked_.of_courses, each) > 0;
      if (theirs) courses.push_back(std::to_string(each));
    }
    if (asked_.of_courses && courses.empty()) return {};
    switch (asked_.by) {
      case By::kRig:
        return {facts.rig};
      case By::kClass:
        return {facts.rig_class};
      case By::kPerson:
        return {std::to_string(facts.user)};
      case By::kMonth:
        return {MonthOf(facts.start)};
      case By::kCourse:
        break;
    }
    if (courses.empty()) courses.emplace_back();
    return courses;
  }

  const Asked& asked_;
  std::map<std::string, Line> lines_;
  std::map<std::string, std::set<std::int64_t>> people_;
  std::map<std::string, std::vector<Milliseconds>> waits_;
};

}  // namespace

std::string_view Name(By by) {
  return kNames[static_cast<std::size_t>(by)];
}

core::Result<std::vector<Line>> Report(Database& database, const Asked& asked, WallTime now) {
  return database.Read([&](Transaction& tx) {
    Sums sums(asked);
    const Parameters during{{"from", asked.during.start}, {"to", asked.during.end}};
    const std::string real = "IN (SELECT id FROM lab_rig WHERE elastic = 0)";
    for (const Past& past : SelectRows<Past>(
             tx,
             "lab_session s LEFT JOIN lab_ticket t ON t.id = s.ticket WHERE s.start_ms >= :from "
             "AND s.start_ms < :to AND s.state = 2 AND s.rig " +
                 real,
             during)) {
      sums.Add(past);
    }
    for (const Promise& promise : SelectRows<Promise>(
             tx, "lab_booking WHERE start_ms >= :from AND start_ms < :to", during)) {
      sums.Add(promise);
    }
    if (asked.of_courses) return sums.Lines();
    for (const auto& [rig, rig_class, from, until] :
         SelectTuples<std::string, std::string, WallTime, WallTime>(
             tx,
             "SELECT u.rig, r.rig_class, u.at_ms, COALESCE(u.next_ms, :now) FROM (SELECT rig, "
             "what, at_ms, LEAD(at_ms) OVER (PARTITION BY rig ORDER BY at_ms) AS next_ms FROM "
             "rig_use) u JOIN lab_rig r ON r.id = u.rig WHERE r.elastic = 0 AND u.what = 'out' AND "
             "u.at_ms < :to AND COALESCE(u.next_ms, :now) > :from",
             {{"now", now}, {"from", asked.during.start}, {"to", asked.during.end}})) {
      sums.AddOut(rig, rig_class, {from, until});
    }
    return sums.Lines();
  });
}

}  // namespace faultlab::server::lab::usage_report
