#include "server/lab/rig_use.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>

namespace faultlab::server::lab::rig_use {
namespace {

using soci::into;
using soci::use;

constexpr Milliseconds kDay = std::chrono::hours(24);
constexpr std::array kUses = {Use::kPeople, Use::kJobs, Use::kChecks, Use::kIdle, Use::kOut};

Use UseNamed(std::string_view name) {
  const auto found =
      std::find_if(kUses.begin(), kUses.end(), [&](Use each) { return Name(each) == name; });
  return found == kUses.end() ? Use::kOut : *found;
}

Milliseconds& Part(Hours& hours, Use use) {
  switch (use) {
    case Use::kPeople:
      return hours.people;
    case Use::kJobs:
      return hours.jobs;
    case Use::kChecks:
      return hours.checks;
    case Use::kIdle:
      return hours.idle;
    case Use::kOut:
      break;
  }
  return hours.out;
}

std::string NewestUse(Transaction& tx, const std::string& rig) {
  std::string what;
  tx.sql() << "SELECT what FROM rig_use WHERE rig = :rig ORDER BY at_ms DESC LIMIT 1", into(what),
      use(rig, "rig");
  return what;
}

void PutUse(Transaction& tx, const std::string& rig, WallTime at, Use what) {
  const std::int64_t at_ms = ToMilliseconds(at);
  const std::string name(Name(what));
  tx.sql() << "INSERT INTO rig_use (rig, at_ms, what) VALUES (:rig, :at, :what) "
              "ON CONFLICT (rig, at_ms) DO UPDATE SET what = excluded.what",
      use(rig, "rig"), use(at_ms, "at"), use(name, "what");
}

}  // namespace

std::string_view Name(Use use) {
  switch (use) {
    case Use::kPeople:
      return "people";
    case Use::kJobs:
      return "jobs";
    case Use::kChecks:
      return "checks";
    case Use::kIdle:
      return "idle";
    case Use::kOut:
      return "out";
  }
  return "out";
}

Use UseOf(const LabState& state, const Rig& rig) {
  switch (rig.status) {
    case RigStatus::kReady:
      return Use::kIdle;
    case RigStatus::kCleaning:
      return Use::kChecks;
    case RigStatus::kOffline:
    case RigStatus::kQuarantined:
    case RigStatus::kMaintenance:
      return Use::kOut;
    case RigStatus::kLeased:
      break;
  }
  const bool job = std::any_of(state.sessions.begin(), state.sessions.end(), [&](const auto& each) {
    const Session& session = each.second;
    return session.rig == rig.id && session.state != SessionState::kClosed &&
           session.kind == TicketKind::kJob;
  });
  return job ? Use::kJobs : Use::kPeople;
}

void Note(Transaction& tx, const LabState& state, const std::vector<Rig>& rigs, WallTime now) {
  for (const Rig& rig : rigs) {
    const Use what = UseOf(state, rig);
    if (NewestUse(tx, rig.id) != Name(what)) PutUse(tx, rig.id, now, what);
  }
}

void StoodStill(Transaction& tx, WallTime from) {
  const std::int64_t from_ms = ToMilliseconds(from);
  const std::string out(Name(Use::kOut));
  tx.sql() << "INSERT INTO rig_use (rig, at_ms, what) SELECT rig, :from, :out FROM rig_use "
              "GROUP BY rig HAVING MAX(at_ms) < :same",
      use(from_ms, "from"), use(out, "out"), use(from_ms, "same");
}

void Forget(Transaction& tx, WallTime before) {
  const std::int64_t before_ms = ToMilliseconds(before);
  tx.sql() << "DELETE FROM rig_use WHERE EXISTS (SELECT 1 FROM rig_use u WHERE u.rig = rig_use.rig "
              "AND u.at_ms > rig_use.at_ms AND u.at_ms <= :before)",
      use(before_ms, "before");
}

std::vector<Hours> SumHours(const std::vector<Line>& lines,
                            WallTime until,
                            int days,
                            WallTime now) {
  std::vector<Hours> all(static_cast<std::size_t>(days));
  const WallTime first = until - kDay * days;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const WallTime end = std::min(i + 1 < lines.size() ? lines[i + 1].at : now, now);
    for (int day = 0; day < days; ++day) {
      const WallTime from = std::max(lines[i].at, first + kDay * day);
      const WallTime to = std::min(end, first + kDay * (day + 1));
      if (from < to) Part(all[static_cast<std::size_t>(day)], lines[i].use) += to - from;
    }
  }
  return all;
}

core::Result<std::vector<Hours>> HoursOf(
    Database& database, const std::string& rig, WallTime until, int days, WallTime now) {
  using Lines = std::vector<Line>;
  const core::Result<Lines> lines = database.Read([&](Transaction& tx) {
    const std::int64_t from_ms = ToMilliseconds(until - kDay * days);
    Lines found;
    std::int64_t at_ms = 0;
    std::string what;
    // With the newest line before: the rig was still used for that.
    soci::statement query =
        (tx.sql().prepare << "SELECT at_ms, what FROM rig_use WHERE rig = :rig AND at_ms >= "
                             "COALESCE((SELECT MAX(at_ms) FROM rig_use WHERE rig = :same AND "
                             "at_ms <= :from), 0) ORDER BY at_ms",
         into(at_ms),
         into(what),
         use(rig, "rig"),
         use(rig, "same"),
         use(from_ms, "from"));
    query.execute();
    while (query.fetch()) found.push_back({FromMilliseconds(at_ms), UseNamed(what)});
    return found;
  });
  if (!lines) return lines.error();
  return SumHours(lines.value(), until, days, now);
}

}  // namespace faultlab::server::lab::rig_use
