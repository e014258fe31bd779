// What people are told.
#include <soci/soci.h>

#include "server/lab/lab_store.h"

namespace faultlab::server::lab::lab_store {
namespace {

using soci::into;
using soci::use;

}  // namespace

void AddEvents(Transaction& tx, const std::vector<LabEvent>& events) {
  for (const LabEvent& event : events) {
    const std::int64_t user = Number(event.user);
    const std::int64_t at_ms = ToMilliseconds(event.at);
    const std::int64_t session = Number(event.session);
    const std::int64_t other = Number(event.other);
    const std::int64_t time_ms = event.time ? ToMilliseconds(*event.time) : 0;
    tx.sql() << "INSERT INTO lab_event (user_id, at_ms, topic, text, session, rig, other_id, why, "
                "reason, time_ms) VALUES (:user, :at, :topic, :text, :session, :rig, :other, :why, "
                ":reason, :time)",
        use(user, "user"), use(at_ms, "at"), use(event.topic, "topic"), use(event.text, "text"),
        use(session, "session"), use(event.rig, "rig"), use(other, "other"), use(event.why, "why"),
        use(event.reason, "reason"), use(time_ms, "time");
  }
}

std::vector<LabEvent> EventsSince(Transaction& tx, UserId user, std::int64_t since, int limit) {
  LabEvent event;
  std::int64_t at_ms = 0;
  std::int64_t session = 0;
  std::int64_t other = 0;
  std::int64_t time_ms = 0;
  std::int64_t start_ms = 0;
  const std::int64_t user_id = Number(user);
  soci::statement statement =
      (tx.sql().prepare
           << "SELECT e.seq, e.at_ms, e.topic, e.text, e.session, e.rig, e.other_id, "
              "e.why, e.reason, e.time_ms, COALESCE(s.start_ms, e.at_ms) FROM lab_event e "
              "LEFT JOIN lab_session s ON s.id = e.session "
              "WHERE e.user_id = :user AND e.seq > :since ORDER BY e.seq LIMIT :count",
       into(event.seq),
       into(at_ms),
       into(event.topic),
       into(event.text),
       into(session),
       into(event.rig),
       into(other),
       into(event.why),
       into(event.reason),
       into(time_ms),
       into(start_ms),
       use(user_id, "user"),
       use(since, "since"),
       use(limit, "count"));
  statement.execute(false);
  std::vector<LabEvent> out;
  while (statement.fetch()) {
    event.user = user;
    event.at = FromMilliseconds(at_ms);
    event.session = SessionId{session};
    event.other = UserId{other};
    event.time = time_ms == 0 ? std::nullopt : std::optional(FromMilliseconds(time_ms));
    event.session_start = FromMilliseconds(start_ms);
    out.push_back(event);
  }
  return out;
}

std::int64_t NewestEvent(Transaction& tx, UserId user) {
  std::int64_t newest = 0;
  const std::int64_t user_id = Number(user);
  tx.sql() << "SELECT COALESCE(MAX(seq), 0) FROM lab_event WHERE user_id = :user", into(newest),
      use(user_id, "user");
  return newest;
}

}  // namespace faultlab::server::lab::lab_store
