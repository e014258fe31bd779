#include "server/lab/alarms.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>

namespace faultlab::server::lab {
namespace {

using soci::into;
using soci::use;

constexpr std::array kKinds = {AlarmKind::kQuarantined,
                               AlarmKind::kCheckFailed,
                               AlarmKind::kInterlock,
                               AlarmKind::kDeltaStrays,
                               AlarmKind::kSilent,
                               AlarmKind::kRelayWorn,
                               AlarmKind::kStorageSmall};

AlarmKind KindNamed(std::string_view name) {
  const auto found = std::find_if(
      kKinds.begin(), kKinds.end(), [&](AlarmKind each) { return Name(each) == name; });
  return found == kKinds.end() ? AlarmKind::kQuarantined : *found;
}

std::optional<WallTime> TimeOf(std::int64_t ms) {
  return ms == 0 ? std::nullopt : std::optional(FromMilliseconds(ms));
}

/// @param rest  what stands behind FROM alarm; built from numbers alone
std::vector<Alarm> Read(Transaction& tx, const std::string& rest) {
  Alarm alarm;
  std::string kind;
  std::int64_t at_ms = 0;
  std::int64_t last_ms = 0;
  std::int64_t ended_ms = 0;
  std::int64_t acked_ms = 0;
  soci::statement query =
      (tx.sql().prepare << "SELECT id, kind, subject, text, at_ms, last_ms, times, ended_ms, "
                           "acked_ms, acked_by FROM alarm " +
                               rest,
       into(alarm.id),
       into(kind),
       into(alarm.subject),
       into(alarm.text),
       into(at_ms),
       into(last_ms),
       into(alarm.times),
       into(ended_ms),
       into(acked_ms),
       into(alarm.acked_by));
  query.execute();
  std::vector<Alarm> alarms;
  while (query.fetch()) {
    alarm.kind = KindNamed(kind);
    alarm.at = FromMilliseconds(at_ms);
    alarm.last = FromMilliseconds(last_ms);
    alarm.ended = TimeOf(ended_ms);
    alarm.acked = TimeOf(acked_ms);
    alarms.push_back(alarm);
  }
  return alarms;
}

}  // namespace

std::string_view Name(AlarmKind kind) {
  switch (kind) {
    case AlarmKind::kQuarantined:
      return "quarantined";
    case AlarmKind::kCheckFailed:
      return "check_failed";
    case AlarmKind::kInterlock:
      return "interlock";
    case AlarmKind::kDeltaStrays:
      return "delta_strays";
    case AlarmKind::kSilent:
      return "silent";
    case AlarmKind::kRelayWorn:
      return "relay_worn";
    case AlarmKind::kStorageSmall:
      return "storage_small";
  }
  return "quarantined";
}

bool Lasts(AlarmKind kind) {
  return kind != AlarmKind::kDeltaStrays;
}

core::Status Alarms::Raise(AlarmKind kind,
                           const std::string& subject,
                           const std::string& text,
                           WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::string name(Name(kind));
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "INSERT INTO alarm (kind, subject, text, at_ms, last_ms, times, ended_ms, "
                "acked_ms, acked_by) VALUES (:kind, :subject, :text, :now, :same, 1, 0, 0, 0) "
                "ON CONFLICT (kind, subject) WHERE ended_ms = 0 DO UPDATE SET "
                "text = excluded.text, last_ms = excluded.last_ms, times = alarm.times + 1",
        use(name, "kind"), use(subject, "subject"), use(text, "text"), use(now_ms, "now"),
        use(now_ms, "same");
    tx.sql() << "DELETE FROM alarm WHERE ended_ms > 0 AND id <= COALESCE((SELECT id FROM alarm "
                "WHERE ended_ms > 0 ORDER BY id DESC LIMIT 1 OFFSET " +
                    std::to_string(kKept) + "), 0)";
    return core::Done{};
  });
}

core::Status Alarms::End(AlarmKind kind, const std::string& subject, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::string name(Name(kind));
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "UPDATE alarm SET ended_ms = :now WHERE kind = :kind AND subject = :subject "
                "AND ended_ms = 0",
        use(now_ms, "now"), use(name, "kind"), use(subject, "subject");
    return core::Done{};
  });
}

core::Result<Alarms::Acknowledged> Alarms::Acknowledge(std::int64_t id,
                                                       std::int64_t account,
                                                       WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Acknowledged> {
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::string one = "WHERE id = " + std::to_string(id);
    const std::vector<Alarm> before = Read(tx, one);
    const bool first = !before.empty() && !before.front().acked;
    tx.sql() << "UPDATE alarm SET acked_ms = :now, acked_by = :who WHERE id = :id AND acked_ms = 0",
        use(now_ms, "now"), use(account, "who"), use(id, "id");
    std::vector<Alarm> found = Read(tx, one);
    if (found.empty()) {
      return core::Error{core::ErrorCode::kNotFound, "There is no such alarm.", "", "nothing_here"};
    }
    if (Lasts(found.front().kind) || found.front().ended) {
      return Acknowledged{found.front(), first};
    }
    tx.sql() << "UPDATE alarm SET ended_ms = :now WHERE id = :id", use(now_ms, "now"),
        use(id, "id");
    return Acknowledged{Read(tx, one).front(), first};
  });
}

core::Result<std::vector<Alarm>> Alarms::List(bool all, std::int64_t before, int limit) {
  using Found = std::vector<Alarm>;
  return database_.Read([&](Transaction& tx) -> core::Result<Found> {
    std::string rest = "WHERE 1 = 1";
    if (!all) rest += " AND (ended_ms = 0 OR acked_ms = 0)";
    if (before > 0) rest += " AND id < " + std::to_string(before);
    return Read(tx, rest + " ORDER BY id DESC LIMIT " + std::to_string(limit));
  });
}

core::Result<std::vector<Alarm>> Alarms::Open() {
  using Found = std::vector<Alarm>;
  return database_.Read([&](Transaction& tx) -> core::Result<Found> {
    return Read(tx, "WHERE ended_ms = 0 ORDER BY id");
  });
}

}  // namespace faultlab::server::lab
