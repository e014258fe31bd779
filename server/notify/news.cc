#include "server/notify/news.h"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <map>
#include <set>

#include "server/lab/lab_types.h"
#include "server/notify/outbox.h"
#include "server/notify/webhooks.h"
#include "server/storage/rows.h"

namespace faultlab::server::notify {
namespace {

namespace json = boost::json;
using std::chrono::milliseconds;
using std::chrono::minutes;

constexpr int kEventsOfALook = 500;
/// How often the time of the last look is stored. A booking that is made so shortly after the time
/// of its reminder is still recalled.
constexpr milliseconds kLookStored = minutes(1);

struct Cursor {
  std::int64_t event_seq = 0;
  WallTime reminded{};
};

Cursor LoadCursor(Transaction& tx, bool locked) {
  std::string query = "SELECT event_seq, reminded_ms FROM outbox_cursor WHERE id = 1";
  if (locked && tx.engine() == Engine::kPostgresql) query += " FOR UPDATE";
  const auto [event_seq, reminded] = *SelectTuple<std::int64_t, WallTime>(tx, query);
  return {event_seq, reminded};
}

struct Addressee {
  std::int64_t account = 0;
  std::set<Kind> kinds;
  bool operates = false;  ///< operator or admin
};

/// Who is to be told.
class Readers {
 public:
  Readers(Transaction& tx, bool mail) : tx_(tx), hooks_(LoadWebhooks(tx)) {
    if (mail) LoadAddressees();
  }

  void Tell(Kind kind, std::int64_t account, const json::object& about, WallTime now) {
    const std::string text = json::serialize(about);
    for (const Webhook& hook : hooks_) {
      const bool theirs = hook.account == 0 || hook.account == account;
      if (theirs && hook.kinds.contains(kind)) Add(HookChannel(hook.id), account, kind, text, now);
    }
    for (const Addressee& each : addressees_) {
      const bool theirs = kind == Kind::kRigQuarantined || kind == Kind::kAlarm
                              ? each.operates
                              : each.account == account;
      if (theirs && each.kinds.contains(kind)) {
        Add(std::string(kMailChannel), each.account, kind, text, now);
      }
    }
  }
  void KeepBounds(WallTime now) const {
    for (const std::string& channel : told_) outbox::KeepBound(tx_, channel, now);
  }

 private:
  void Add(const std::string& channel,
           std::int64_t account,
           Kind kind,
           const std::string& about,
           WallTime now) {
    outbox::Add(tx_, channel, account, Name(kind), about, now);
    told_.insert(channel);
  }
  void LoadAddressees() {
    for (const auto& [account, kinds, role] : SelectTuples<std::int64_t, std::string, std::string>(
             tx_,
             "SELECT c.account_id, c.kinds, a.role FROM mail_choice c JOIN account a ON a.id = "
             "c.account_id WHERE c.verified_ms > 0 AND a.disabled = 0")) {
      addressees_.push_back({account, ReadKinds(kinds), role == "operator" || role == "admin"});
    }
  }

  Transaction& tx_;
  const std::vector<Webhook> hooks_;
  std::vector<Addressee> addressees_;
  std::set<std::string> told_;
};

/// A message of the lab to one of its users.
struct Event {
  std::int64_t seq = 0;
  std::int64_t account = 0;
  std::string login;
  std::string topic;
  std::string rig;
  std::string reason;
  WallTime at{};
  std::int64_t session = 0;
  WallTime time{};
  WallTime claim_until{};
};

template <typename Visit>
void Fields(Event& event, Visit&& visit) {
  visit("e.seq", event.seq);
  visit("e.user_id", event.account);
  visit("COALESCE(a.login, '')", event.login);
  visit("e.topic", event.topic);
  visit("e.rig", event.rig);
  visit("e.reason", event.reason);
  visit("e.at_ms", event.at);
  visit("e.session", event.session);
  visit("e.time_ms", event.time);
  visit("COALESCE(s.claim_until_ms, 0)", event.claim_until);
}

std::vector<Event> EventsAfter(Transaction& tx, std::int64_t seq) {
  return SelectRows<Event>(tx,
                           "lab_event e LEFT JOIN account a ON a.id = e.user_id LEFT JOIN "
                           "lab_session s ON s.id = e.session WHERE e.seq > :seq ORDER BY e.seq "
                           "LIMIT :count",
                           {{"seq", seq}, {"count", kEventsOfALook}});
}

void Tell(Readers& readers, const Event& event, WallTime now) {
  json::object about{{"login", event.login}, {"rig", event.rig}};
  if (event.topic == "offer" || event.topic == "due") {
    about["cause"] = event.topic == "offer" ? "queue" : "booking";
    about["session"] = event.session;
    about["until"] = Stamp(event.claim_until);
    readers.Tell(Kind::kYourTurn, event.account, about, now);
  } else if (event.topic == "moved" || event.topic == "unfulfilled" || event.topic == "freed" ||
             event.topic == "time_free" || event.topic == "time_not_free") {
    about["change"] = event.topic;
    about["start"] = Stamp(event.time);
    about["reason"] = event.reason;
    readers.Tell(Kind::kBookingChanged, event.account, about, now);
  }
}

struct Quarantine {
  std::int64_t id = 0;
  std::string kind;
  std::string rig;
  std::string text;
  WallTime at{};
};

template <typename Visit>
void Fields(Quarantine& alarm, Visit&& visit) {
  visit("id", alarm.id);
  visit("kind", alarm.kind);
  visit("subject", alarm.rig);
  visit("text", alarm.text);
  visit("at_ms", alarm.at);
}

void TellAlarms(Transaction& tx, Readers& readers, WallTime now) {
  for (const Quarantine& alarm : SelectRows<Quarantine>(tx, "alarm WHERE told = 0 ORDER BY id")) {
    UpdateWhere(tx, "alarm", {{"told", 1}}, {{"id", alarm.id}});
    const json::object about{
        {"rig", alarm.rig}, {"cause", alarm.kind}, {"text", alarm.text}, {"at", Stamp(alarm.at)}};
    if (alarm.kind == "quarantined" || alarm.kind == "check_failed") {
      readers.Tell(Kind::kRigQuarantined, 0, about, now);
    }
    json::object any = about;
    any.erase("rig");
    any["subject"] = alarm.rig;
    readers.Tell(Kind::kAlarm, 0, any, now);
  }
}

/// A run or a job of somebody with a webhook has ended (the triggers of the schema).
struct End {
  std::int64_t id = 0;
  std::string kind;  ///< "run", "job"
  std::string subject;
  std::int64_t account = 0;
};

template <typename Visit>
void Fields(End& end, Visit&& visit) {
  visit("id", end.id);
  visit("kind", end.kind);
  visit("subject", end.subject);
  visit("account_id", end.account);
}

/// Nothing of what a run has shown: it may be sealed.
void TellRun(Transaction& tx, Readers& readers, const End& end, WallTime now) {
  const auto run = SelectTuple<std::string, std::string, std::string>(
      tx, "SELECT name, rig, state FROM recording WHERE id = :id", {{"id", end.subject}});
  if (!run) return;
  const auto& [name, rig, state] = *run;
  readers.Tell(Kind::kRunEnded,
               end.account,
               {{"run", end.subject}, {"name", name}, {"rig", rig}, {"state", state}},
               now);
}

/// @returns its batch; empty if it is gone
std::string TellJob(Transaction& tx, Readers& readers, const End& end, WallTime now) {
  const auto job = SelectTuple<std::string, std::string, std::string, std::string>(
      tx, "SELECT batch, name, state, run_id FROM job WHERE id = :id", {{"id", end.subject}});
  if (!job) return "";
  const auto& [batch, name, state, run] = *job;
  readers.Tell(
      Kind::kJobEnded,
      end.account,
      {{"job", end.subject}, {"batch", batch}, {"name", name}, {"state", state}, {"run", run}},
      now);
  return batch;
}

void TellEnds(Transaction& tx, Readers& readers, WallTime now) {
  std::map<std::string, std::int64_t> batches;  // and whose they are
  for (const End& end :
       SelectRows<End>(tx, "ended ORDER BY id LIMIT :count", {{"count", kEventsOfALook}})) {
    DeleteFrom(tx, "ended", {{"id", end.id}});
    if (end.kind == "run") {
      TellRun(tx, readers, end, now);
      continue;
    }
    const std::string batch = TellJob(tx, readers, end, now);
    if (!batch.empty()) batches[batch] = end.account;
  }
  // Whose last job was among these: those before had one that had not ended, or is told of later.
  for (const auto& [batch, account] : batches) {
    const Parameters of{{"batch", batch}};
    const bool goes_on =
        CountRows(tx, "job WHERE batch = :batch AND state IN ('waiting', 'running')", of) > 0 ||
        CountRows(tx,
                  "ended JOIN job ON job.id = ended.subject WHERE ended.kind = 'job' AND "
                  "job.batch = :batch",
                  of) > 0;
    if (goes_on) continue;
    json::object count;
    for (const auto& [state, jobs] : SelectTuples<std::string, std::int64_t>(
             tx, "SELECT state, COUNT(*) FROM job WHERE batch = :batch GROUP BY state", of)) {
      count[state] = jobs;
    }
    readers.Tell(Kind::kBatchEnded, account, {{"batch", batch}, {"jobs", count}}, now);
  }
}

struct Soon {
  std::int64_t booking = 0;
  std::int64_t account = 0;
  std::string login;
  std::string rig_class;
  std::string rig;
  WallTime start{};
  WallTime end{};
};

template <typename Visit>
void Fields(Soon& soon, Visit&& visit) {
  visit("b.id", soon.booking);
  visit("b.user_id", soon.account);
  visit("COALESCE(a.login, '')", soon.login);
  visit("b.rig_class", soon.rig_class);
  visit("b.rig", soon.rig);
  visit("b.start_ms", soon.start);
  visit("b.end_ms", soon.end);
}

/// Bookings that begin in (from, to].
std::vector<Soon> BookingsBetween(Transaction& tx, WallTime from, WallTime to) {
  return SelectRows<Soon>(
      tx,
      "lab_booking b LEFT JOIN account a ON a.id = b.user_id WHERE b.state = "
      ":booked AND b.start_ms > :from AND b.start_ms <= :to ORDER BY "
      "b.start_ms, b.id",
      {{"booked", static_cast<int>(lab::BookingState::kBooked)}, {"from", from}, {"to", to}});
}

/// Between the last look and now the clock has passed `lead` before the start of these.
std::vector<Soon> Reminded(Transaction& tx, const Cursor& cursor, minutes lead, WallTime now) {
  if (cursor.reminded == WallTime{} || cursor.reminded >= now) return {};
  return BookingsBetween(tx, std::max(cursor.reminded + lead, now), now + lead);
}

/// The clock was set: from here it counts again.
bool IsAhead(const Cursor& cursor, WallTime now) {
  return cursor.reminded > now + kLookStored;
}

struct Look {
  bool news = false;
  bool waits = false;
};

Look LookFor(Transaction& tx, const NewsOptions& options, WallTime now) {
  const Cursor cursor = LoadCursor(tx, /*locked=*/false);
  const bool news =
      SelectValue<int>(
          tx, "SELECT 1 FROM lab_event WHERE seq > :seq LIMIT 1", {{"seq", cursor.event_seq}}) ||
      CountRows(tx, "alarm WHERE told = 0") > 0 ||
      SelectValue<std::int64_t>(tx, "SELECT id FROM ended LIMIT 1").has_value();
  const auto waits =
      SelectValue<int>(tx,
                       "SELECT 1 FROM outbox WHERE state = 'waiting' AND next_ms <= :now LIMIT 1",
                       {{"now", now}});
  const bool stale = now - cursor.reminded > kLookStored || IsAhead(cursor, now);
  const bool soon = std::ranges::any_of(
      options.reminders, [&](minutes lead) { return !Reminded(tx, cursor, lead, now).empty(); });
  return {news || stale || soon, waits.has_value()};
}

}  // namespace

core::Result<bool> Gather(Database& database, const NewsOptions& options, WallTime now) {
  TRY(const auto look, database.Read([&](Transaction& tx) { return LookFor(tx, options, now); }));
  if (!look.news) return look.waits;
  return database.Write(Durability::kPromise, [&](Transaction& tx) {
    Cursor cursor = LoadCursor(tx, /*locked=*/true);
    Readers readers(tx, options.mail);
    for (const Event& event : EventsAfter(tx, cursor.event_seq)) {
      cursor.event_seq = event.seq;
      const bool old = event.at + Outbox::kAgeMax < now;
      if (!old) Tell(readers, event, now);
    }
    TellAlarms(tx, readers, now);
    TellEnds(tx, readers, now);
    std::set<std::int64_t> told;  // after a pause of all servers one booking may be due twice
    for (const minutes lead : options.reminders) {
      for (const Soon& booking : Reminded(tx, cursor, lead, now)) {
        if (!told.insert(booking.booking).second) continue;
        readers.Tell(Kind::kBookingReminder,
                     booking.account,
                     {{"login", booking.login},
                      {"booking", booking.booking},
                      {"rig_class", booking.rig_class},
                      {"rig", booking.rig},
                      {"start", Stamp(booking.start)},
                      {"end", Stamp(booking.end)}},
                     now);
      }
    }
    readers.KeepBounds(now);
    if (cursor.reminded < now || IsAhead(cursor, now)) cursor.reminded = now;
    UpdateWhere(tx,
                "outbox_cursor",
                {{"event_seq", cursor.event_seq}, {"reminded_ms", cursor.reminded}},
                {{"id", 1}});
    return true;
  });
}

}  // namespace faultlab::server::notify
