// What people are told.
#include "server/lab/lab_store.h"
#include "server/storage/rows.h"

namespace faultlab::server::lab {

template <typename Visit>
void Fields(LabEvent& event, Visit&& visit) {
  visit("user_id", event.user);
  visit("at_ms", event.at);
  visit("topic", event.topic);
  visit("text", event.text);
  visit("session", event.session);
  visit("rig", event.rig);
  visit("other_id", event.other);
  visit("why", event.why);
  visit("reason", event.reason);
  visit("time_ms", event.time);
}

namespace lab_store {
namespace {

/// As it was told, with what it was about.
struct ToldEvent {
  LabEvent event;
};

template <typename Visit>
void Fields(ToldEvent& told, Visit&& visit) {
  lab::Fields(told.event, visit);
  visit("seq", told.event.seq);
  visit("COALESCE((SELECT s.start_ms FROM lab_session s WHERE s.id = session), at_ms)",
        told.event.session_start);
}

}  // namespace

void AddEvents(Transaction& tx, const std::vector<LabEvent>& events) {
  for (const LabEvent& event : events) InsertRow(tx, "lab_event", event);
}

std::vector<LabEvent> EventsSince(Transaction& tx, UserId user, std::int64_t since, int limit) {
  std::vector<LabEvent> out;
  ForEachRow<ToldEvent>(
      tx,
      "lab_event WHERE user_id = :user AND seq > :since ORDER BY seq LIMIT :count",
      [&out](const ToldEvent& told) { out.push_back(told.event); },
      {{"user", Number(user)}, {"since", since}, {"count", limit}});
  return out;
}

std::int64_t NewestEvent(Transaction& tx, UserId user) {
  return *SelectValue<std::int64_t>(
      tx,
      "SELECT COALESCE(MAX(seq), 0) FROM lab_event WHERE user_id = :user",
      {{"user", Number(user)}});
}

}  // namespace lab_store
}  // namespace faultlab::server::lab
