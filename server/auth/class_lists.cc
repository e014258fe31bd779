// Accounts: class lists.
#include <utility>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/class_list_text.h"
#include "server/auth/course_rows.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;

std::optional<std::int64_t> AccountOf(Transaction& tx, const std::string& login) {
  return SelectValue<std::int64_t>(
      tx, "SELECT id FROM account WHERE login = :login", {{"login", login}});
}

/// Writes lines that name every login; a long list needs several lines.
void PutAuditLines(Transaction& tx,
                   const Principal& who,
                   const std::string& verb,
                   std::int64_t course,
                   const std::vector<std::string>& logins,
                   WallTime now) {
  constexpr std::size_t kDetailBytes = 1000;
  const std::string object = "course:" + std::to_string(course);
  std::string detail;
  for (std::size_t i = 0; i < logins.size(); ++i) {
    detail += (detail.empty() ? "" : ", ") + logins[i];
    if (detail.size() < kDetailBytes && i + 1 < logins.size()) continue;
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

/// What becomes of one person of a list that is taken back: Enrolment::Person::becomes.
std::string_view TakeBack(Transaction& tx,
                          const Principal& who,
                          std::int64_t course,
                          const std::string& login,
                          WallTime now) {
  const auto row = account_rows::Find(tx, "login = :value", login);
  if (!row) return "stays";
  const std::int64_t id = row->account.id;
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
  const bool unused = row->account.role == Role::kStudent && row->password_hash.empty() &&
                      row->made_by == who.user_id &&
                      CountRows(tx, "external_identity WHERE account_id = :id", {{"id", id}}) == 0;
  if (!recent || !unused) return invited ? "left" : "stays";
  DeleteFrom(tx, "enrolment", {{"course_id", course}, {"account_id", id}});
  const bool elsewhere =
      CountRows(tx, "enrolment WHERE account_id = :id", {{"id", id}}) > 0 ||
      CountRows(tx, "course_invitation WHERE account_id = :id", {{"id", id}}) > 0;
  if (elsewhere || row->account.created_at < since) return "left";
  for (const char* table :
       {"one_time_link", "calendar_link", "api_key", "known_device", "mail_choice", "outbox"}) {
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
    TakeTurn(tx, "members of " + std::to_string(course_id));
    const std::int64_t maker = who.role == Role::kAdmin ? 0 : who.user_id;
    if (maker != 0) TakeTurn(tx, "accounts made by " + std::to_string(maker));
    Enrolment out;
    out.login_from = list.login_from;
    out.name_from = list.name_from;
    out.mail_from = list.mail_from;
    for (const ClassListLine& line : list.lines) {
      std::optional<std::int64_t> known = AccountOf(tx, line.login);
      const bool member = known && course_rows::IsMember(tx, course_id, *known);
      const bool invites = known && !member && who.role != Role::kAdmin;
      out.people.push_back({line.login,
                            line.name,
                            member    ? "member"
                            : invites ? "invited"
                            : known   ? "enrolled"
                                      : "account"});
      if (only_look) continue;
      if (member) {
        ++out.members_already;
      } else if (invites) {
        if (course_rows::PutInvitation(tx, course_id, *known, who.user_id, now)) {
          out.invited.push_back(line.login);
        } else {
          ++out.invited_already;
        }
      } else {
        if (!known)
          known = account_rows::Add(tx, line.login, line.name, Role::kStudent, now, who.user_id).id;
        course_rows::PutMember(tx, course_id, *known, /*teaches=*/false);
        course_rows::DropInvitation(tx, course_id, *known);
        out.enrolled.push_back(line.login);
      }
      if (known && line.mail.find('@') != std::string::npos)
        PutAddress(tx, *known, maker, line.mail, now);
    }
    if (only_look) return out;
    if (const auto room = CheckMembers(tx, course_id); !room.ok()) return room.error();
    if (maker != 0) {
      if (const auto room = CheckAccountsMade(tx, maker); !room.ok()) return room.error();
    }
    PutAuditLines(tx, who, "enrol", course_id, out.enrolled, now);
    PutAuditLines(tx, who, "invite", course_id, out.invited, now);
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
    std::vector<std::string> ended;
    for (const ClassListLine& line : list.lines) {
      const std::string_view becomes = TakeBack(tx, who, course_id, line.login, now);
      out.people.push_back({line.login, line.name, becomes});
      if (becomes == "stays") {
        ++out.members_already;
      } else {
        ended.push_back(line.login);
      }
    }
    PutAuditLines(tx, who, "take_back", course_id, ended, now);
    return out;
  });
}

}  // namespace faultlab::server
