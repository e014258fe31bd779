#include "server/lab/alarms.h"

#include <array>

#include "server/storage/rows.h"

namespace faultlab::server::lab {
namespace {

/// By AlarmKind.
constexpr std::array<std::string_view, 10> kKinds = {"quarantined",
                                                     "check_failed",
                                                     "interlock",
                                                     "delta_strays",
                                                     "silent",
                                                     "relay_worn",
                                                     "storage_small",
                                                     "restarted",
                                                     "job_failed",
                                                     "hours_end"};

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
  return kind != AlarmKind::kDeltaStrays && kind != AlarmKind::kRestarted &&
         kind != AlarmKind::kJobFailed;
}

core::Status Alarms::Raise(AlarmKind kind,
                           const std::string& subject,
                           const std::string& text,
                           WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertInto(
        tx,
        "alarm",
        {{"kind", Name(kind)},
         {"subject", subject},
         {"text", text},
         {"at_ms", now},
         {"last_ms", now},
         {"times", 1},
         {"ended_ms", 0},
         {"acked_ms", 0},
         {"acked_by", 0}},
        "ON CONFLICT (kind, subject) WHERE ended_ms = 0 DO UPDATE SET text = excluded.text, "
        "last_ms = excluded.last_ms, times = alarm.times + 1, told = CASE WHEN excluded.kind "
        "= 'restarted' THEN 0 ELSE alarm.told END");
    Execute(tx,
            "DELETE FROM alarm WHERE ended_ms > 0 AND id <= COALESCE((SELECT id FROM alarm "
            "WHERE ended_ms > 0 ORDER BY id DESC LIMIT 1 OFFSET " +
                std::to_string(kKept) + "), 0)");
  });
}

core::Status Alarms::End(AlarmKind kind, const std::string& subject, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    UpdateWhere(tx,
                "alarm",
                {{"ended_ms", now}},
                {{"kind", Name(kind)}, {"subject", subject}, {"ended_ms", 0}});
  });
}

core::Result<Alarms::Acknowledged> Alarms::Acknowledge(std::int64_t id,
                                                       std::int64_t account,
                                                       WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Acknowledged> {
    const std::string one = "alarm WHERE id = " + std::to_string(id);
    const std::vector<Alarm> before = SelectRows<Alarm>(tx, one);
    const bool first = !before.empty() && !before.front().acked;
    UpdateWhere(
        tx, "alarm", {{"acked_ms", now}, {"acked_by", account}}, {{"id", id}, {"acked_ms", 0}});
    std::vector<Alarm> found = SelectRows<Alarm>(tx, one);
    if (found.empty()) {
      return core::Refuse("nothing_here");
    }
    if (Lasts(found.front().kind) || found.front().ended) {
      return Acknowledged{found.front(), first};
    }
    UpdateWhere(tx, "alarm", {{"ended_ms", now}}, {{"id", id}});
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
