#include "server/lab/alarms.h"

#include <array>

#include "server/storage/rows.h"

namespace faultlab::server::lab {
namespace {

using soci::use;

/// By AlarmKind.
constexpr std::array<std::string_view, 7> kKinds = {"quarantined",
                                                    "check_failed",
                                                    "interlock",
                                                    "delta_strays",
                                                    "silent",
                                                    "relay_worn",
                                                    "storage_small"};

}  // namespace

template <typename Visit>
void Fields(Alarm& alarm, Visit&& visit) {
  visit("id", alarm.id);
  visit("kind", alarm.kind, kKinds);
  visit("subject", alarm.subject);
  visit("text", alarm.text);
  visit("at_ms", alarm.at);
  visit("last_ms", alarm.last);
  visit("times", alarm.times);
  visit("ended_ms", alarm.ended);
  visit("acked_ms", alarm.acked);
  visit("acked_by", alarm.acked_by);
}

std::string_view Name(AlarmKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

bool Lasts(AlarmKind kind) {
  return kind != AlarmKind::kDeltaStrays;
}

core::Status Alarms::Raise(AlarmKind kind,
                           const std::string& subject,
                           const std::string& text,
                           WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
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
  });
}

core::Status Alarms::End(AlarmKind kind, const std::string& subject, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::string name(Name(kind));
    const std::int64_t now_ms = ToMilliseconds(now);
    tx.sql() << "UPDATE alarm SET ended_ms = :now WHERE kind = :kind AND subject = :subject "
                "AND ended_ms = 0",
        use(now_ms, "now"), use(name, "kind"), use(subject, "subject");
  });
}

core::Result<Alarms::Acknowledged> Alarms::Acknowledge(std::int64_t id,
                                                       std::int64_t account,
                                                       WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Acknowledged> {
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::string one = "alarm WHERE id = " + std::to_string(id);
    const std::vector<Alarm> before = SelectRows<Alarm>(tx, one);
    const bool first = !before.empty() && !before.front().acked;
    tx.sql() << "UPDATE alarm SET acked_ms = :now, acked_by = :who WHERE id = :id AND acked_ms = 0",
        use(now_ms, "now"), use(account, "who"), use(id, "id");
    std::vector<Alarm> found = SelectRows<Alarm>(tx, one);
    if (found.empty()) {
      return core::Refuse("nothing_here");
    }
    if (Lasts(found.front().kind) || found.front().ended) {
      return Acknowledged{found.front(), first};
    }
    tx.sql() << "UPDATE alarm SET ended_ms = :now WHERE id = :id", use(now_ms, "now"),
        use(id, "id");
    return Acknowledged{SelectRows<Alarm>(tx, one).front(), first};
  });
}

core::Result<std::vector<Alarm>> Alarms::List(bool all, std::int64_t before, int limit) {
  return database_.Read([&](Transaction& tx) {
    std::string rest = "alarm WHERE 1 = 1";
    if (!all) rest += " AND (ended_ms = 0 OR acked_ms = 0)";
    if (before > 0) rest += " AND id < " + std::to_string(before);
    return SelectRows<Alarm>(tx, rest + " ORDER BY id DESC LIMIT " + std::to_string(limit));
  });
}

core::Result<std::vector<Alarm>> Alarms::Open() {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<Alarm>(tx, "alarm WHERE ended_ms = 0 ORDER BY id");
  });
}

}  // namespace faultlab::server::lab
