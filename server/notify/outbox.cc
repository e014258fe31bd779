#include "server/notify/outbox.h"

#include "server/storage/ids.h"
#include "server/storage/rows.h"

namespace faultlab::server::notify {

template <typename Visit>
void Fields(Message& message, Visit&& visit) {
  visit("o.id", message.id);
  visit("o.delivery", message.delivery);
  visit("o.channel", message.channel);
  visit("o.account_id", message.account);
  visit("o.kind", message.kind);
  visit("o.about", message.about);
  visit("o.created_ms", message.created);
  visit("o.attempts", message.attempts);
}

namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

constexpr const char* kUnclaimed =
    "(o.member = '' OR NOT EXISTS (SELECT 1 FROM lab_member m "
    "WHERE m.id = o.member AND m.boot = o.boot))";

/// The names are made by this program: "hook:3", "mail".
std::string InList(const std::set<std::string>& channels) {
  std::string list;
  for (const std::string& each : channels) list += (list.empty() ? "'" : ", '") + each + "'";
  return list;
}

}  // namespace

core::Result<std::optional<Message>> Outbox::Claim(const Claimant& who,
                                                   const std::set<std::string>& not_these,
                                                   bool of_people,
                                                   WallTime now) {
  using Found = std::optional<Message>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Found> {
    if (!LockMembership(tx, who)) return Found{};
    std::string from = "outbox o WHERE o.state = 'waiting' AND o.next_ms <= :now AND ";
    from += kUnclaimed;
    if (!not_these.empty()) from += " AND o.channel NOT IN (" + InList(not_these) + ")";
    if (!of_people) {
      from += " AND o.channel NOT IN (SELECT 'hook:' || id FROM webhook WHERE account_id > 0)";
    }
    from += " ORDER BY o.next_ms, o.id LIMIT 1";
    if (tx.engine() == Engine::kPostgresql) from += " FOR UPDATE OF o SKIP LOCKED";
    auto message = SelectRow<Message>(tx, from, {{"now", now}});
    if (!message) return message;
    ++message->attempts;
    message->member = who.server_id;
    message->boot = who.boot;
    UpdateWhere(
        tx,
        "outbox",
        {{"member", message->member}, {"boot", message->boot}, {"attempts", message->attempts}},
        {{"id", message->id}});
    return message;
  });
}

core::Status Outbox::End(const Message& claimed, Parameters columns) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    for (const char* name : {"member", "boot"}) columns.emplace_back(name, "");
    if (UpdateWhere(tx,
                    "outbox",
                    columns,
                    {{"id", claimed.id},
                     {"member", claimed.member},
                     {"boot", claimed.boot},
                     {"attempts", claimed.attempts},
                     {"state", "waiting"}}) == 1) {
      return Done{};
    }
    return Error{ErrorCode::kStale, "this claim of the message is over", "", "internal"};
  });
}

core::Status Outbox::Delivered(const Message& claimed, WallTime now) {
  return End(claimed, {{"state", "delivered"}, {"error", ""}, {"ended_ms", now}});
}

core::Status Outbox::Retry(const Message& claimed, const std::string& error, WallTime at) {
  return End(claimed, {{"error", error}, {"next_ms", at}});
}

core::Status Outbox::GiveUp(const Message& claimed, const std::string& error, WallTime now) {
  return End(claimed, {{"state", "given_up"}, {"error", error}, {"ended_ms", now}});
}

core::Status Outbox::Tidy(WallTime now) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    Execute(tx,
            "UPDATE outbox SET state = 'given_up', ended_ms = :now WHERE state = 'waiting' "
            "AND created_ms < CASE WHEN channel LIKE 'hook:%' THEN :old ELSE :older END",
            {{"now", now}, {"old", now - kAgeMax}, {"older", now - kPatientAge}});
    Execute(tx,
            "DELETE FROM outbox WHERE state <> 'waiting' AND ended_ms < :past",
            {{"past", now - kEndedAge}});
    Execute(tx,
            "DELETE FROM outbox WHERE state <> 'waiting' AND channel LIKE 'hook:%' AND id <= "
            "(SELECT id FROM outbox WHERE state <> 'waiting' AND channel LIKE 'hook:%' ORDER BY id "
            "DESC LIMIT 1 OFFSET " +
                std::to_string(kEndedKept) + ")");
  });
}

namespace outbox {

void Add(Transaction& tx,
         const std::string& channel,
         std::int64_t account,
         std::string_view kind,
         const std::string& about,
         WallTime now) {
  const std::string delivery = NewId("msg");
  InsertInto(tx,
             "outbox",
             {{"delivery", delivery},
              {"channel", channel},
              {"account_id", account},
              {"kind", kind},
              {"about", about},
              {"created_ms", now},
              {"state", "waiting"},
              {"attempts", 0},
              {"next_ms", now},
              {"ended_ms", 0},
              {"error", ""},
              {"member", ""},
              {"boot", ""}});
}

void KeepBound(Transaction& tx, const std::string& channel, WallTime now) {
  Execute(tx,
          "UPDATE outbox SET state = 'given_up', ended_ms = :now, "
          "error = 'too many messages wait' WHERE channel = :channel AND state = 'waiting' "
          "AND id <= (SELECT id FROM outbox WHERE channel = :channel AND state = 'waiting' "
          "ORDER BY id DESC LIMIT 1 OFFSET " +
              std::to_string(Outbox::kWaitingMax) + ")",
          {{"now", now}, {"channel", channel}});
}

}  // namespace outbox
}  // namespace faultlab::server::notify
