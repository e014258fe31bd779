// Accounts: invitations to courses.
#include <soci/soci.h>

#include "server/auth/accounts.h"
#include "server/auth/course_rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

core::Result<std::vector<Invitation>> Invitations(Database& database,
                                                  const std::string& condition,
                                                  std::int64_t value) {
  using Found = std::vector<Invitation>;
  return database.Read([&](Transaction& tx) -> core::Result<Found> {
    Invitation row;
    std::int64_t at_ms = 0;
    soci::statement statement =
        (tx.sql().prepare << "SELECT c.id, c.name, a.login, t.name, i.created_ms "
                             "FROM course_invitation i JOIN course c ON c.id = i.course_id "
                             "JOIN account a ON a.id = i.account_id "
                             "JOIN account t ON t.id = i.invited_by WHERE " +
                                 condition + " ORDER BY c.id, a.login",
         into(row.course_id),
         into(row.course_name),
         into(row.login),
         into(row.invited_by),
         into(at_ms),
         use(value, "value"));
    statement.execute(false);
    Found out;
    while (statement.fetch()) {
      row.at = FromMilliseconds(at_ms);
      out.push_back(row);
    }
    return out;
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
      return Error{
          ErrorCode::kNotFound, "no invitation to this course waits for you", "", "no_invitation"};
    }
    if (accept) course_rows::PutMember(tx, course_id, account_id, /*teaches=*/false);
    return Done{};
  });
}

}  // namespace faultlab::server
