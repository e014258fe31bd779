#include "server/lab/lab_store.h"

#include <sstream>
#include <string>

#include "server/lab/policy_settings.h"
#include "server/storage/rows.h"

namespace faultlab::server::lab {

template <typename Visit>
void Fields(Rig& rig, Visit&& visit) {
  visit("id", rig.id);
  visit("rig_class", rig.rig_class);
  visit("elastic", rig.elastic);
  visit("status", rig.status);
  visit("epoch", rig.epoch);
  visit("cleaning_due_ms", rig.cleaning_due);
  visit("wear_ms", rig.wear);
  visit("reason", rig.reason);
  visit("server", rig.server);
  visit("check_failed", rig.check_failed);
}

template <typename Visit>
void Fields(Outage& outage, Visit&& visit) {
  visit("id", outage.id);
  visit("rig", outage.rig);
  visit("start_ms", outage.during.start);
  visit("end_ms", outage.during.end);
  visit("reason", outage.reason);
  visit("fallen", outage.fallen);
}

namespace {

/// "3 17": whole numbers, as rows keep several.
std::string NumbersText(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (const std::int64_t each : numbers) text += (text.empty() ? "" : " ") + std::to_string(each);
  return text;
}

std::vector<std::int64_t> ReadNumbers(std::string_view text) {
  std::vector<std::int64_t> numbers;
  std::istringstream in{std::string(text)};
  for (std::int64_t each = 0; in >> each;) numbers.push_back(each);
  return numbers;
}

struct CoursesText {
  static std::string Write(const Courses& courses) { return NumbersText(courses); }
  static Courses Read(std::string_view text) { return ReadNumbers(text); }
};

/// Start and length of each, in milliseconds.
struct TimesText {
  static std::string Write(const std::vector<Interval>& times) {
    std::vector<std::int64_t> numbers;
    for (const Interval& each : times) {
      numbers.push_back(ToMilliseconds(each.start));
      numbers.push_back(each.length().count());
    }
    return NumbersText(numbers);
  }
  static std::vector<Interval> Read(std::string_view text) {
    const std::vector<std::int64_t> numbers = ReadNumbers(text);
    std::vector<Interval> times;
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      const WallTime start = FromMilliseconds(numbers[i]);
      times.push_back({start, start + Milliseconds(numbers[i + 1])});
    }
    return times;
  }
};

}  // namespace

template <typename Visit>
void Fields(Window& window, Visit&& visit) {
  visit("id", window.id);
  visit("rig_class", window.rig_class);
  visit("course_id", window.course);
  visit("title", window.title);
  visit("repeat_rule", window.repeat);
  visit("time_zone", window.time_zone);
  visit("times", window.times, TimesText{});
}

template <typename Visit>
void Fields(Ticket& ticket, Visit&& visit) {
  visit("id", ticket.id);
  visit("user_id", ticket.user);
  visit("rig_class", ticket.rig_class);
  visit("kind", ticket.kind);
  visit("job", ticket.job);
  visit("weight", ticket.weight);
  visit("min_ms", ticket.min);
  visit("want_ms", ticket.want);
  visit("created_ms", ticket.created);
  visit("state", ticket.state);
  visit("offered", ticket.offered);
  visit("offers_missed", ticket.offers_missed);
  visit("place", ticket.place);
  visit("expected_ms", ticket.expected);
  visit("first_expected_ms", ticket.first_expected);
  visit("courses", ticket.courses, CoursesText{});
}

template <typename Visit>
void Fields(Booking& booking, Visit&& visit) {
  visit("id", booking.id);
  visit("user_id", booking.user);
  visit("rig_class", booking.rig_class);
  visit("start_ms", booking.during.start);
  visit("end_ms", booking.during.end);
  visit("state", booking.state);
  visit("rig", booking.rig);
  visit("session", booking.session);
  visit("version", booking.version);
  visit("note", booking.note);
  visit("courses", booking.courses, CoursesText{});
}

template <typename Visit>
void Fields(Session& session, Visit&& visit) {
  visit("id", session.id);
  visit("user_id", session.user);
  visit("rig", session.rig);
  visit("rig_class", session.rig_class);
  visit("epoch", session.epoch);
  visit("booking", session.booking);
  visit("ticket", session.ticket);
  visit("kind", session.kind);
  visit("job", session.job);
  visit("state", session.state);
  visit("start_ms", session.start);
  visit("hard_end_ms", session.hard_end);
  visit("claim_until_ms", session.claim_until);
  visit("last_control_ms", session.last_control);
  visit("charged_from_ms", session.charged_from);
  visit("run_in_progress", session.run_in_progress);
  visit("extended_ms", session.extended);
  visit("warning_stage", session.warning_stage);
  visit("idle_answer_ms", session.idle_answer_until);
  visit("offered_to", session.offered_to);
  visit("end_reason", session.end_reason);
  visit("end_text", session.end_text);
  visit("ended_ms", session.ended);
  visit("courses", session.courses, CoursesText{});
}

template <typename Visit>
void Fields(Usage& usage, Visit&& visit) {
  visit("user_id", usage.user);
  visit("seconds", usage.seconds);
  visit("at_ms", usage.at);
  visit("week", usage.week);
  visit("this_week_ms", usage.this_week);
}

namespace lab_store {
namespace {

/// A setting of the policy by name: one that is added later needs no column. Of a rig class:
/// "offer_s bench".
struct StoredSetting {
  std::string name;
  std::int64_t value = 0;
};

template <typename Visit>
void Fields(StoredSetting& setting, Visit&& visit) {
  visit("name", setting.name);
  visit("value", setting.value);
}

constexpr const char* kVersionSetting = "version";

}  // namespace

std::int64_t LockVersion(Transaction& tx) {
  std::string query = "SELECT version FROM lab_meta WHERE id = 1";
  if (tx.engine() == Engine::kPostgresql) {
    // A server that stops inside the transaction (a frozen process) must not block the others: the
    // database ends its transaction.
    Execute(tx, "SET LOCAL idle_in_transaction_session_timeout = '750ms'");
    query += " FOR UPDATE";
  }
  return *SelectValue<std::int64_t>(tx, query);
}

std::vector<std::string> RunsOfPastLeases(Transaction& tx,
                                          const std::string& server_id,
                                          WallTime now) {
  return SelectColumn<std::string>(
      tx,
      "SELECT r.id FROM recording r JOIN lab_rig l ON l.id = r.rig WHERE r.created_ms >= :since "
      "AND r.state = 'running' AND r.server_id = :server AND r.epoch < l.epoch",
      {{"since", now - std::chrono::hours(24)}, {"server", server_id}});
}

LabState Load(Transaction& tx) {
  LabState state;
  state.next_id = *SelectValue<std::int64_t>(tx, "SELECT next_id FROM lab_meta WHERE id = 1");
  ForEachRow<Rig>(tx, "lab_rig", [&](const Rig& rig) { state.rigs[rig.id] = rig; });
  ForEachRow<Outage>(tx, "lab_outage", [&](const Outage& o) { state.outages[o.id] = o; });
  ForEachRow<Window>(tx, "lab_window", [&](const Window& w) { state.windows[w.id] = w; });
  ForEachRow<Ticket>(
      tx, "lab_ticket WHERE state < 2", [&](const Ticket& t) { state.tickets[t.id] = t; });
  ForEachRow<Booking>(tx, "lab_booking WHERE state < 3 OR state = 7", [&](const Booking& b) {
    state.bookings[b.id] = b;
  });
  ForEachRow<Session>(
      tx, "lab_session WHERE state < 2", [&](const Session& s) { state.sessions[s.id] = s; });
  ForEachRow<Usage>(tx, "lab_usage", [&](const Usage& u) { state.usage[u.user] = u; });
  ForEachRow<StoredSetting>(tx, "lab_policy", [&](const StoredSetting& stored) {
    const std::size_t space = stored.name.find(' ');
    const std::string name = stored.name.substr(0, space);
    PolicySettings& settings =
        state.settings[space == std::string::npos ? "" : stored.name.substr(space + 1)];
    if (name == kVersionSetting) settings.version = stored.value;
    for (const PolicySetting& each : kPolicySettings) {
      if (each.name == name) SetValue(settings, each, stored.value);
    }
  });
  return state;
}

void Save(Transaction& tx, const Changes& changes, std::int64_t version) {
  for (const Rig& rig : changes.rigs) PutRow(tx, "lab_rig", rig);
  for (const Outage& outage : changes.outages) PutRow(tx, "lab_outage", outage);
  for (const OutageId id : changes.ended_outages) {
    DeleteFrom(tx, "lab_outage", {{"id", Number(id)}});
  }
  for (const Window& window : changes.windows) PutRow(tx, "lab_window", window);
  for (const WindowId id : changes.ended_windows) {
    DeleteFrom(tx, "lab_window", {{"id", Number(id)}});
  }
  // Ended tickets and sessions are written first, because the unique indexes allow only one live
  // row of each.
  for (const bool ended : {true, false}) {
    for (const Ticket& ticket : changes.tickets) {
      const bool is_live =
          ticket.state == TicketState::kWaiting || ticket.state == TicketState::kOffered;
      if (is_live != ended) PutRow(tx, "lab_ticket", ticket);
    }
    for (const Session& session : changes.sessions) {
      if ((session.state == SessionState::kClosed) == ended) PutRow(tx, "lab_session", session);
    }
  }
  // Bookings that swap rigs would overlap half-way, so all leave their rigs before any takes a new
  // one.
  for (Booking booking : changes.bookings) {
    booking.rig.clear();
    PutRow(tx, "lab_booking", booking);
  }
  for (const Booking& booking : changes.bookings) PutRow(tx, "lab_booking", booking);
  for (const Usage& usage : changes.usage) PutRow(tx, "lab_usage", usage);
  for (const auto& changed : changes.settings) {
    const std::optional<PolicySettings>& settings = changed.second;
    const std::string of = changed.first.empty() ? "" : " " + changed.first;
    const auto put = [&](std::string_view name, std::int64_t value) {
      const std::string key = std::string(name) + of;
      if (settings) PutRow(tx, "lab_policy", StoredSetting{key, value});
      if (!settings) DeleteFrom(tx, "lab_policy", {{"name", key}});
    };
    put(kVersionSetting, settings ? settings->version : 0);
    for (const PolicySetting& each : kPolicySettings) {
      put(each.name, settings ? ValueOf(*settings, each) : 0);
    }
  }
  UpdateWhere(tx, "lab_meta", {{"version", version}, {"next_id", changes.next_id}}, {{"id", 1}});
}

std::vector<Session> PastSessions(Transaction& tx, UserId user, SessionId before, int limit) {
  return SelectRows<Session>(
      tx,
      "lab_session WHERE user_id = :user AND id < :before AND state = :closed AND kind = :person "
      "ORDER BY id DESC LIMIT :limit",
      {{"user", Number(user)},
       {"before", Number(before)},
       {"closed", static_cast<int>(SessionState::kClosed)},
       {"person", static_cast<int>(TicketKind::kPerson)},
       {"limit", limit}});
}

EndReason EndReasonOf(Transaction& tx, SessionId session) {
  const auto reason = SelectValue<int>(
      tx, "SELECT end_reason FROM lab_session WHERE id = :id", {{"id", Number(session)}});
  return static_cast<EndReason>(reason.value_or(0));
}

bool WasShortened(Transaction& tx, SessionId session) {
  return CountRows(tx,
                   "lab_event WHERE topic = 'shortened' AND session = :id AND "
                   "user_id = (SELECT user_id FROM lab_session WHERE id = :id)",
                   {{"id", Number(session)}}) > 0;
}

}  // namespace lab_store
}  // namespace faultlab::server::lab
