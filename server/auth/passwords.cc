// Accounts: passwords and the links that set them.
#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/credentials.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;

constexpr auto kLinkLives = std::chrono::hours(24);
constexpr std::size_t kPasswordMin = 10;
constexpr std::size_t kPasswordMax = 1024;

/// one_time_link.made_by of a link for a class.
constexpr std::string_view kOfClass = "class list";

/// Condition of the link table.
const std::string kLiveLink =
    "token_hash = :hash AND used = 0 AND expires_ms > :now AND (made_by <> '" +
    std::string(kOfClass) + "' OR account_id IN (SELECT id FROM account WHERE " +
    account_rows::kUnopened + "))";

std::string InsertLink(Transaction& tx,
                       std::int64_t account,
                       const std::string& made_by,
                       WallTime now,
                       std::chrono::milliseconds lives) {
  std::string secret = NewSecret("fll_");
  InsertInto(tx,
             "one_time_link",
             {{"token_hash", HashSecret(secret)},
              {"account_id", account},
              {"expires_ms", now + lives},
              {"used", 0},
              {"made_by", made_by}});
  return secret;
}

/// Makes a link and removes the account's earlier ones.
std::string PutLink(Transaction& tx,
                    std::int64_t account,
                    const std::string& made_by,
                    WallTime now) {
  DeleteFrom(tx, "one_time_link", {{"account_id", account}});
  return InsertLink(tx, account, made_by, now, kLinkLives);
}

/// Accounts of a course that CreateClassLinks is for.
struct Theirs {
  Theirs(const Principal& who, std::int64_t course, bool but_addresses)
      : condition(account_rows::kUnopened + (but_addresses ? " AND login NOT LIKE '%@%'" : "") +
                  " AND (made_by = :maker OR :maker = 0) AND id IN (SELECT account_id FROM "
                  "enrolment WHERE course_id = :course AND teaches = 0)"),
        values{{"maker", who.role == Role::kAdmin ? 0 : who.user_id}, {"course", course}} {}

  std::string condition;
  Parameters values;
};

std::string AddressOf(Transaction& tx, const Account& account) {
  const bool is_one = account.login.find('@') != std::string::npos;
  return SelectValue<std::string>(
             tx, "SELECT address FROM mail_choice WHERE account_id = :id", {{"id", account.id}})
      .value_or(is_one ? account.login : "");
}

std::vector<Accounts::ClassLink> Unopened(Transaction& tx, const Theirs& theirs) {
  std::vector<Accounts::ClassLink> out;
  for (const account_rows::Row& row : SelectRows<account_rows::Row>(
           tx, "account WHERE " + theirs.condition + " ORDER BY login", theirs.values)) {
    out.push_back({row.ToAccount(), AddressOf(tx, row.account), ""});
  }
  return out;
}

std::int64_t FirstAdmin(Transaction& tx, WallTime now) {
  const std::string login = "admin";
  if (const auto row = account_rows::Find(tx, "login = :value", login)) return row->account.id;
  return account_rows::Add(tx, login, "Administrator", Role::kAdmin, now).id;
}

}  // namespace

core::Status CheckPasswordRules(std::string_view password) {
  if (password.size() < kPasswordMin) {
    return core::Refuse("password_short", "password");
  }
  if (password.size() > kPasswordMax) {
    return core::Refuse("password_long", "password");
  }
  return Done{};
}

core::Status Accounts::ChangePassword(const Principal& who,
                                      const std::string& old_password,
                                      const std::string& new_password,
                                      bool also_keys,
                                      WallTime now) {
  if (const auto rules = CheckPasswordRules(new_password); !rules.ok()) return rules;
  TRY(const auto row, database_.Read([&](Transaction& tx) -> core::Result<account_rows::Row> {
    const auto found = account_rows::Find(tx, "id = :value", who.user_id);
    if (!found) return account_rows::NoAccount();
    return *found;
  }));
  const std::string& attempt = who.session_token_hash;
  if (const auto status = old_passwords_.Try(attempt, now); !status.ok()) return status;
  const auto right = hasher_.Verify(row.password_hash, old_password);
  if (!right.ok()) {
    old_passwords_.Forgive(attempt);
    return right.error();
  }
  const Error wrong = core::Refuse("old_password_wrong", "old");
  if (!right.value()) return wrong;
  old_passwords_.Forget(attempt);
  TRY(const auto hash, hasher_.Hash(new_password));
  const auto changed = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (UpdateWhere(tx,
                    "account",
                    {{"password_hash", hash}},
                    {{"id", who.user_id}, {"password_hash", row.password_hash}}) != 1)
      return wrong;
    credentials::EndSignIns(tx, who.user_id, who.session_token_hash);
    if (also_keys) credentials::EndKeys(tx, who.user_id);
    return Done{};
  });
  if (changed.ok()) {
    if (also_keys) Tell({.what = Revocation::What::kApiKeys, .account_id = who.user_id});
    Tell({.what = Revocation::What::kOtherSignIns,
          .account_id = who.user_id,
          .sign_in = who.session_token_hash});
  }
  return changed;
}

core::Result<std::string> Accounts::CreateLink(std::int64_t account_id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<std::string> {
    if (!account_rows::Find(tx, "id = :value", account_id)) return account_rows::NoAccount();
    return PutLink(tx, account_id, "", now);
  });
}

core::Result<std::vector<Accounts::ClassLink>> Accounts::ListUnopened(const Principal& who,
                                                                      std::int64_t course_id,
                                                                      bool but_addresses) {
  return database_.Read(
      [&](Transaction& tx) { return Unopened(tx, Theirs(who, course_id, but_addresses)); });
}

core::Result<std::vector<Accounts::ClassLink>> Accounts::CreateClassLinks(const Principal& who,
                                                                          std::int64_t course_id,
                                                                          bool but_addresses,
                                                                          WallTime now) {
  return database_.Write(
      Durability::kPromise, [&](Transaction& tx) -> core::Result<std::vector<ClassLink>> {
        const Theirs theirs(who, course_id, but_addresses);
        std::vector<ClassLink> links = Unopened(tx, theirs);
        Execute(tx,
                "DELETE FROM one_time_link WHERE account_id IN (SELECT id FROM account WHERE " +
                    theirs.condition + ")",
                theirs.values);
        for (ClassLink& link : links) {
          link.secret =
              InsertLink(tx, link.account.id, std::string(kOfClass), now, kClassLinkLives);
        }
        return links;
      });
}

core::Result<std::optional<Accounts::ClassLink>> Accounts::CreateFurtherLink(
    std::int64_t account_id, std::int64_t course_id, WallTime now) {
  return database_.Write(
      Durability::kPromise, [&](Transaction& tx) -> core::Result<std::optional<ClassLink>> {
        const auto row = SelectRow<account_rows::Row>(
            tx,
            "account WHERE id = :id AND id IN (SELECT account_id FROM enrolment WHERE course_id = "
            ":course) AND " +
                account_rows::kUnopened,
            {{"id", account_id}, {"course", course_id}});
        if (!row) return std::optional<ClassLink>();
        return std::optional(
            ClassLink{row->ToAccount(),
                      AddressOf(tx, row->account),
                      InsertLink(tx, account_id, std::string(kOfClass), now, kClassLinkLives)});
      });
}

core::Result<Account> Accounts::OwnerOfLink(const std::string& secret, WallTime now) {
  return database_.Read([&](Transaction& tx) -> core::Result<Account> {
    const auto row = SelectRow<account_rows::Row>(
        tx,
        "account WHERE id IN (SELECT account_id FROM one_time_link WHERE " + kLiveLink + ")",
        {{"hash", HashSecret(secret)}, {"now", now}});
    if (!row) return core::Refuse("link_over", "token");
    return row->ToAccount();
  });
}

core::Result<std::int64_t> Accounts::UseLink(const std::string& secret,
                                             const std::string& new_password,
                                             WallTime now) {
  if (const auto rules = CheckPasswordRules(new_password); !rules.ok()) return rules.error();
  const std::string hash = HashSecret(secret);
  const Error refused = core::Refuse("link_over", "token");
  TRY_DONE(OwnerOfLink(secret, now));  // no argon2id for a made-up link
  TRY(const auto password_hash, hasher_.Hash(new_password));
  std::int64_t account_id = 0;
  TRY_DONE(database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (Execute(tx,
                "UPDATE one_time_link SET used = 1 WHERE " + kLiveLink,
                {{"hash", hash}, {"now", now}}) != 1)
      return refused;
    account_id = *SelectValue<std::int64_t>(
        tx, "SELECT account_id FROM one_time_link WHERE token_hash = :hash", {{"hash", hash}});
    UpdateWhere(tx, "account", {{"password_hash", password_hash}}, {{"id", account_id}});
    credentials::EndAll(tx, account_id);
    // An address of a class list has brought the link: that was all it was for.
    DeleteFrom(tx, "mail_choice", {{"account_id", account_id}, {"verified_ms", 0}});
    return Done{};
  }));
  Tell({.account_id = account_id});
  return account_id;
}

core::Result<std::optional<Accounts::FirstLink>> Accounts::FirstStartLink(const std::string& server,
                                                                          WallTime now) {
  using MaybeLink = std::optional<FirstLink>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeLink> {
    TakeTurn(tx, "the first admin");
    const std::int64_t admins = CountRows(tx,
                                          "account WHERE role = 'admin' AND password_hash <> '' "
                                          "AND disabled = 0");
    if (admins > 0) return MaybeLink{};
    const std::int64_t id = FirstAdmin(tx, now);
    const auto made_by = SelectValue<std::string>(
        tx,
        "SELECT made_by FROM one_time_link WHERE account_id = :id AND used = 0 AND "
        "expires_ms > :now",
        {{"id", id}, {"now", now}});
    if (made_by && *made_by != server) return MaybeLink{{"", *made_by}};
    return MaybeLink{{PutLink(tx, id, server, now), server}};
  });
}

}  // namespace faultlab::server
