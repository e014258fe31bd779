// Accounts: invitations to courses.
#include "server/auth/accounts.h"
#include "server/auth/course_rows.h"
#include "server/storage/rows.h"

namespace faultlab::server {

template <typename Visit>
void Fields(Invitation& row, Visit&& visit) {
  visit("c.id", row.course_id);
  visit("c.name", row.course_name);
  visit("a.login", row.login);
  visit("t.name", row.invited_by);
  visit("i.created_ms", row.at);
}

namespace {

using core::Done;

core::Result<std::vector<Invitation>> Invitations(Database& database,
                                                  const std::string& condition,
                                                  std::int64_t value) {
  return database.Read([&](Transaction& tx) {
    return SelectRows<Invitation>(tx,
                                  "course_invitation i JOIN course c ON c.id = i.course_id "
                                  "JOIN account a ON a.id = i.account_id "
                                  "JOIN account t ON t.id = i.invited_by WHERE " +
                                      condition + " ORDER BY c.id, a.login",
                                  {{"value", value}});
  });
}

}  // namespace

core::Result<std::vector<Invitation>> Accounts::InvitationsOf(std::int64_t account_id) {
  return Invitations(database_, "i.account_id = :value", account_id);
}

core::Result<std::vector<Invitation>> Accounts::InvitationsTo(std::int64_t course_id) {
  return Invitations(database_, "i.course_id = :value", course_id);
}

core::Status Accounts::AnswerInvitation(std::int64_t account_id,
                                        std::int64_t course_id,
                                        bool accept) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!course_rows::DropInvitation(tx, course_id, account_id)) {
      return core::Refuse("no_invitation");
    }
    if (accept) course_rows::PutMember(tx, course_id, account_id, /*teaches=*/false);
    return Done{};
  });
}

}  // namespace faultlab::server
