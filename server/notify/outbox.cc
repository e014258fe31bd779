#include "server/notify/outbox.h"

#include <soci/soci.h>

#include "server/storage/ids.h"

namespace faultlab::server::notify {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr const char* kUnclaimed =
    "(o.member = '' OR NOT EXISTS (SELECT 1 FROM lab_member m "
    "WHERE m.id = o.member AND m.boot = o.boot))";

/// On PostgreSQL the membership cannot end before the transaction does: whoever ends it sees the
/// claim.
bool LockMembership(Transaction& tx, const Outbox::Claimant& who) {
  int found = 0;
  std::string query = "SELECT 1 FROM lab_member WHERE id = :id AND boot = :boot";
  if (tx.engine() == Engine::kPostgresql) query += " FOR SHARE";
  tx.sql() << query, into(found), use(who.member, "id"), use(who.boot, "boot");
  return tx.sql().got_data();
}

/// The names are made by this program: "hook:3", "mail".
std::string InList(const std::set<std::string>& channels) {
  std::string list;
  for (const std::string& each : channels) list += (list.empty() ? "'" : ", '") + each + "'";
  return list;
}

}  // namespace

core::Result<std::optional<Message>> Outbox::Claim(const Claimant& who,
                                                   const std::set<std::string>& not_these,
                                                   WallTime now) {
  using Found = std::optional<Message>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Found> {
    if (!LockMembership(tx, who)) return Found{};
    Message message;
    std::int64_t created_ms = 0;
    const std::int64_t now_ms = ToMilliseconds(now);
    std::string query =
        "SELECT o.id, o.delivery, o.channel, o.account_id, o.kind, o.about, o.created_ms, "
        "o.attempts FROM outbox o WHERE o.state = 'waiting' AND o.next_ms <= :now AND ";
    query += kUnclaimed;
    if (!not_these.empty()) query += " AND o.channel NOT IN (" + InList(not_these) + ")";
    query += " ORDER BY o.next_ms, o.id LIMIT 1";
    if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE OF o SKIP LOCKED";
    tx.sql() << query, into(message.id), into(message.delivery), into(message.channel),
        into(message.account), into(message.kind), into(message.about), into(created_ms),
        into(message.attempts), use(now_ms, "now");
    if (!tx.sql().got_data()) return Found{};
    message.created = FromMilliseconds(created_ms);
    ++message.attempts;
    message.member = who.member;
    message.boot = who.boot;
    tx.sql() << "UPDATE outbox SET member = :member, boot = :boot, attempts = :attempts "
                "WHERE id = :id",
        use(message.member, "member"), use(message.boot, "boot"), use(message.attempts, "attempts"),
        use(message.id, "id");
    return Found{std::move(message)};
  });
}

template <typename Bind>
core::Status Outbox::End(const Message& claimed, const std::string& columns, const Bind& bind) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    soci::statement statement(tx.sql());
    bind(statement);
    statement.exchange(use(claimed.id, "id"));
    statement.exchange(use(claimed.member, "member"));
    statement.exchange(use(claimed.boot, "boot"));
    statement.exchange(use(claimed.attempts, "attempt"));
    statement.alloc();
    statement.prepare("UPDATE outbox SET " + columns +
                      ", member = '', boot = '' WHERE id = :id AND member = :member AND "
                      "boot = :boot AND attempts = :attempt AND state = 'waiting'");
    statement.define_and_bind();
    statement.execute(true);
    if (statement.get_affected_rows() == 1) return Done{};
    return Error{ErrorCode::kStale, "this claim of the message is over", "", "internal"};
  });
}

core::Status Outbox::Delivered(const Message& claimed, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  return End(claimed, "state = 'delivered', error = '', ended_ms = :now", [&](auto& statement) {
    statement.exchange(use(now_ms, "now"));
  });
}

core::Status Outbox::Retry(const Message& claimed, const std::string& error, WallTime at) {
  const std::int64_t at_ms = ToMilliseconds(at);
  return End(claimed, "error = :error, next_ms = :at", [&](auto& statement) {
    statement.exchange(use(error, "error"));
    statement.exchange(use(at_ms, "at"));
  });
}

core::Status Outbox::GiveUp(const Message& claimed, const std::string& error, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  return End(claimed, "state = 'given_up', error = :error, ended_ms = :now", [&](auto& statement) {
    statement.exchange(use(error, "error"));
    statement.exchange(use(now_ms, "now"));
  });
}

core::Status Outbox::Tidy(WallTime now) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) {
    const std::int64_t now_ms = ToMilliseconds(now);
    const std::int64_t old_ms = ToMilliseconds(now - kAgeMax);
    const std::int64_t past_ms = ToMilliseconds(now - kEndedAge);
    tx.sql() << "UPDATE outbox SET state = 'given_up', ended_ms = :now WHERE state = 'waiting' "
                "AND created_ms < :old",
        use(now_ms, "now"), use(old_ms, "old");
    tx.sql() << "DELETE FROM outbox WHERE state <> 'waiting' AND ended_ms < :past",
        use(past_ms, "past");
    tx.sql() << "DELETE FROM outbox WHERE state <> 'waiting' AND id <= (SELECT id FROM outbox "
                "WHERE state <> 'waiting' ORDER BY id DESC LIMIT 1 OFFSET " +
                    std::to_string(kEndedKept) + ")";
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
  const std::string word(kind);
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "INSERT INTO outbox (delivery, channel, account_id, kind, about, created_ms, state, "
              "attempts, next_ms, ended_ms, error, member, boot) VALUES (:delivery, :channel, "
              ":account, :kind, :about, :created, 'waiting', 0, :next, 0, '', '', '')",
      use(delivery, "delivery"), use(channel, "channel"), use(account, "account"),
      use(word, "kind"), use(about, "about"), use(now_ms, "created"), use(now_ms, "next");
}

void KeepBound(Transaction& tx, const std::string& channel, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "UPDATE outbox SET state = 'given_up', ended_ms = :now, "
              "error = 'too many messages wait' WHERE channel = :channel AND state = 'waiting' "
              "AND id <= (SELECT id FROM outbox WHERE channel = :again AND state = 'waiting' "
              "ORDER BY id DESC LIMIT 1 OFFSET " +
                  std::to_string(Outbox::kWaitingMax) + ")",
      use(now_ms, "now"), use(channel, "channel"), use(channel, "again");
}

}  // namespace outbox
}  // namespace faultlab::server::notify
