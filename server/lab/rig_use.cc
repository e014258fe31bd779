#include "server/lab/rig_use.h"

#include <algorithm>
#include <array>

#include "server/storage/rows.h"

namespace faultlab::server::lab::rig_use {
namespace {

constexpr Milliseconds kDay = std::chrono::hours(24);
struct UseName {
  Use use;
  std::string_view name;
  Milliseconds Hours::*part;
};
constexpr std::array kUses = {UseName{Use::kPeople, "people", &Hours::people},
                              UseName{Use::kJobs, "jobs", &Hours::jobs},
                              UseName{Use::kChecks, "checks", &Hours::checks},
                              UseName{Use::kIdle, "idle", &Hours::idle},
                              UseName{Use::kOut, "out", &Hours::out}};

Use UseNamed(std::string_view name) {
  const auto* found = std::ranges::find(kUses, name, &UseName::name);
  return found == kUses.end() ? Use::kOut : found->use;
}

const UseName& EntryOf(Use use) {
  return *std::ranges::find(kUses, use, &UseName::use);
}

std::string NewestUse(Transaction& tx, const std::string& rig) {
  return SelectValue<std::string>(tx,
                                  "SELECT what FROM rig_use WHERE rig = :rig ORDER BY at_ms DESC "
                                  "LIMIT 1",
                                  {{"rig", rig}})
      .value_or("");
}

void PutUse(Transaction& tx, const std::string& rig, WallTime at, Use what) {
  InsertInto(tx,
             "rig_use",
             {{"rig", rig}, {"at_ms", at}, {"what", Name(what)}},
             "ON CONFLICT (rig, at_ms) DO UPDATE SET what = excluded.what");
}

}  // namespace

std::string_view Name(Use use) {
  return EntryOf(use).name;
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
  const bool job = std::ranges::any_of(state.sessions, [&](const auto& each) {
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
  Execute(tx,
          "INSERT INTO rig_use (rig, at_ms, what) SELECT rig, :from, :out FROM rig_use "
          "GROUP BY rig HAVING MAX(at_ms) < :from",
          {{"from", from}, {"out", Name(Use::kOut)}});
}

void Forget(Transaction& tx, WallTime before) {
  Execute(tx,
          "DELETE FROM rig_use WHERE EXISTS (SELECT 1 FROM rig_use u WHERE u.rig = rig_use.rig "
          "AND u.at_ms > rig_use.at_ms AND u.at_ms <= :before)",
          {{"before", before}});
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
      if (from < to) all[static_cast<std::size_t>(day)].*EntryOf(lines[i].use).part += to - from;
    }
  }
  return all;
}

core::Result<std::vector<Hours>> HoursOf(
    Database& database, const std::string& rig, WallTime until, int days, WallTime now) {
  TRY(const auto lines, database.Read([&](Transaction& tx) {
    std::vector<Line> found;
    // With the newest line before: the rig was still used for that.
    for (const auto& [at, what] : SelectTuples<WallTime, std::string>(
             tx,
             "SELECT at_ms, what FROM rig_use WHERE rig = :rig AND at_ms >= COALESCE((SELECT "
             "MAX(at_ms) FROM rig_use WHERE rig = :rig AND at_ms <= :from), 0) ORDER BY at_ms",
             {{"rig", rig}, {"from", until - kDay * days}})) {
      found.push_back({at, UseNamed(what)});
    }
    return found;
  }));
  return SumHours(lines, until, days, now);
}

}  // namespace faultlab::server::lab::rig_use
