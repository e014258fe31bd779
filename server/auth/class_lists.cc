// Accounts: class lists.
#include <set>
#include <utility>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/class_list_text.h"
#include "server/auth/course_rows.h"
#include "server/auth/identity_rows.h"
#include "server/storage/owner_key.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;

std::optional<std::int64_t> AccountOf(Transaction& tx, const std::string& login) {
  return SelectValue<std::int64_t>(
      tx, "SELECT id FROM account WHERE login = :login", {{"login", login}});
}

/// Writes lines of every account; a long list needs several lines.
void PutAuditLines(Transaction& tx,
                   const Principal& who,
                   const std::string& verb,
                   std::int64_t course,
                   const std::vector<std::int64_t>& accounts,
                   WallTime now) {
  constexpr std::size_t kDetailBytes = 1000;
  const std::string object = "course:" + std::to_string(course);
  std::string detail;
  for (std::size_t i = 0; i < accounts.size(); ++i) {
    detail += (detail.empty() ? "" : ", ") + OwnerKeyOf(accounts[i]);
    if (detail.size() < kDetailBytes && i + 1 < accounts.size()) continue;
    account_rows::PutAuditLine(tx, who.owner_key(), verb, object, std::exchange(detail, {}), now);
  }
}

core::Status CheckMembers(Transaction& tx, std::int64_t course) {
  const std::int64_t count =
      CountRows(tx, "enrolment WHERE course_id = :course", {{"course", course}}) +
      CountRows(tx, "course_invitation WHERE course_id = :course", {{"course", course}});
  if (count <= Accounts::kMembersMax) return Done{};
  return core::Refuse("course_full", "", {{"most", Accounts::kMembersMax}});
}

core::Status CheckAccountsMade(Transaction& tx, std::int64_t maker) {
  const std::int64_t count = CountRows(tx, "account WHERE made_by = :maker", {{"maker", maker}});
  if (count <= Accounts::kAccountsMadeMax) return Done{};
  return core::Refuse("accounts_full", "", {{"most", Accounts::kAccountsMadeMax}});
}

/// Where the link of an account goes that a list of theirs has made and nobody has opened.
void PutAddress(Transaction& tx,
                std::int64_t account,
                std::int64_t maker,
                const std::string& address,
                WallTime now) {
  const bool unopened =
      CountRows(tx,
                "account WHERE id = :id AND (made_by = :maker OR :maker = 0) AND " +
                    account_rows::kUnopened,
                {{"id", account}, {"maker", maker}}) > 0;
  if (!unopened) return;
  InsertInto(tx,
             "mail_choice",
             {{"account_id", account},
              {"address", address},
              {"language", ""},
              {"kinds", ""},
              {"asked_ms", now},
              {"verified_ms", 0}},
             "ON CONFLICT (account_id) DO UPDATE SET address = excluded.address, verified_ms = 0");
}

/// @returns the teacher whose accounts are counted; 0: an admin's are not
std::int64_t TakeTurns(Transaction& tx, const Principal& who, std::int64_t course) {
  TakeTurn(tx, "members of " + std::to_string(course));
  const std::int64_t maker = who.role == Role::kAdmin ? 0 : who.user_id;
  if (maker != 0) TakeTurn(tx, "accounts made by " + std::to_string(maker));
  return maker;
}

/// What becomes of somebody who has an account: they join by their own consent, or an admin's.
std::string_view BecomesOf(Transaction& tx,
                           const Principal& who,
                           std::int64_t course,
                           std::int64_t account) {
  if (course_rows::IsMember(tx, course, account)) return "member";
  return who.role == Role::kAdmin ? "enrolled" : "invited";
}

void Join(Transaction& tx,
          const Principal& who,
          std::int64_t course,
          std::int64_t account,
          const Enrolment::Person& person,
          WallTime now,
          Enrolment& out) {
  if (person.becomes == "member") {
    ++out.members_already;
  } else if (person.becomes == "invited") {
    if (course_rows::PutInvitation(tx, course, account, who.user_id, now)) {
      out.invited.push_back(account);
    } else {
      ++out.invited_already;
    }
  } else {
    course_rows::PutMember(tx, course, account, /*teaches=*/false);
    course_rows::DropInvitation(tx, course, account);
    out.enrolled.push_back(account);
  }
}

/// Within the bounds, and told.
core::Status Close(Transaction& tx,
                   const Principal& who,
                   std::int64_t course,
                   std::int64_t maker,
                   const Enrolment& out,
                   WallTime now) {
  TRY_DONE(CheckMembers(tx, course));
  if (maker != 0) {
    TRY_DONE(CheckAccountsMade(tx, maker));
  }
  PutAuditLines(tx, who, "enrol", course, out.enrolled, now);
  PutAuditLines(tx, who, "invite", course, out.invited, now);
  return Done{};
}

/// What becomes of one person of a list that is taken back: Enrolment::Person::becomes.
std::string_view TakeBack(Transaction& tx,
                          const Principal& who,
                          std::int64_t course,
                          const account_rows::Row& row,
                          WallTime now) {
  const std::int64_t id = row.account.id;
  const WallTime since = now - Accounts::kTakesBack;
  const bool invited =
      Execute(tx,
              "DELETE FROM course_invitation WHERE course_id = :course AND account_id = :id AND "
              "invited_by = :who AND created_ms >= :since",
              {{"course", course}, {"id", id}, {"who", who.user_id}, {"since", since}}) > 0;
  const bool recent = CountRows(tx,
                                "enrolment WHERE course_id = :course AND account_id = :id AND "
                                "since_ms >= :since",
                                {{"course", course}, {"id", id}, {"since", since}}) > 0;
  const bool unused = row.account.role == Role::kStudent && row.password_hash.empty() &&
                      row.made_by == who.user_id &&
                      CountRows(tx, "external_identity WHERE account_id = :id", {{"id", id}}) == 0;
  if (!recent || !unused) return invited ? "left" : "stays";
  DeleteFrom(tx, "enrolment", {{"course_id", course}, {"account_id", id}});
  const bool elsewhere =
      CountRows(tx, "enrolment WHERE account_id = :id", {{"id", id}}) > 0 ||
      CountRows(tx, "course_invitation WHERE account_id = :id", {{"id", id}}) > 0;
  if (elsewhere || row.account.created_at < since) return "left";
  for (const char* table : {"one_time_link",
                            "calendar_link",
                            "api_key",
                            "known_device",
                            "mail_choice",
                            "webhook",
                            "ended",
                            "outbox"}) {
    DeleteFrom(tx, table, {{"account_id", id}});
  }
  // A link of it may be used at this moment.
  const std::int64_t gone =
      Execute(tx, "DELETE FROM account WHERE id = :id AND password_hash = ''", {{"id", id}});
  return gone == 1 ? "gone" : "left";
}

}  // namespace

core::Result<Enrolment> Accounts::EnrolCsv(const Principal& who,
                                           std::int64_t course_id,
                                           std::string_view csv,
                                           WallTime now,
                                           bool only_look) {
  TRY(const auto list, ParseClassList(csv));
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Enrolment> {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    const std::int64_t maker = TakeTurns(tx, who, course_id);
    Enrolment out;
    out.login_from = list.login_from;
    out.name_from = list.name_from;
    out.mail_from = list.mail_from;
    for (const ClassListLine& line : list.lines) {
      std::optional<std::int64_t> known = AccountOf(tx, line.login);
      const std::string_view becomes = known ? BecomesOf(tx, who, course_id, *known) : "account";
      out.people.push_back({line.login, line.name, becomes});
      if (only_look) continue;
      if (!known)
        known = account_rows::Add(tx, line.login, line.name, Role::kStudent, now, who.user_id).id;
      Join(tx, who, course_id, *known, out.people.back(), now, out);
      if (known && line.mail.find('@') != std::string::npos)
        PutAddress(tx, *known, maker, line.mail, now);
    }
    if (only_look) return out;
    TRY_DONE(Close(tx, who, course_id, maker, out, now));
    return out;
  });
}

core::Result<Enrolment> Accounts::EnrolRoster(const Principal& who,
                                              std::int64_t course_id,
                                              std::span<const RosterPerson> people,
                                              WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Enrolment> {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    const std::int64_t maker = TakeTurns(tx, who, course_id);
    TakeTurn(tx, identity_rows::kTurn);
    Enrolment out;
    std::set<std::pair<std::string, std::string>> seen;
    for (const RosterPerson& each : people) {
      if (!seen.emplace(each.person.issuer, each.person.subject).second) continue;
      const auto known = identity_rows::AccountOf(tx, each.person);
      const auto row = known ? account_rows::Find(tx, "id = :value", *known) : std::nullopt;
      core::Result<Account> account =
          row ? row->ToAccount()
              : identity_rows::First(tx, each.person, each.rules, now, who.user_id);
      if (!account || account.value().disabled || account.value().role != Role::kStudent) {
        ++out.refused;
        continue;
      }
      const Account& student = account.value();
      out.people.push_back({student.login,
                            student.name,
                            row ? BecomesOf(tx, who, course_id, student.id) : "account"});
      Join(tx, who, course_id, student.id, out.people.back(), now, out);
    }
    TRY_DONE(Close(tx, who, course_id, maker, out, now));
    return out;
  });
}

core::Result<Enrolment> Accounts::TakeBackCsv(const Principal& who,
                                              std::int64_t course_id,
                                              std::string_view csv,
                                              WallTime now) {
  TRY(const auto list, ParseClassList(csv));
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Enrolment> {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    TakeTurn(tx, "members of " + std::to_string(course_id));
    Enrolment out;
    out.login_from = list.login_from;
    out.name_from = list.name_from;
    std::vector<std::int64_t> ended;
    for (const ClassListLine& line : list.lines) {
      const auto row = account_rows::Find(tx, "login = :value", line.login);
      const std::string_view becomes = row ? TakeBack(tx, who, course_id, *row, now) : "stays";
      out.people.push_back({line.login, line.name, becomes});
      if (becomes == "stays") {
        ++out.members_already;
      } else {
        ended.push_back(row->account.id);
      }
    }
    PutAuditLines(tx, who, "take_back", course_id, ended, now);
    return out;
  });
}

}  // namespace faultlab::server
