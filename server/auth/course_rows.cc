#include "server/auth/course_rows.h"
#include "server/storage/rows.h"

#include <chrono>

namespace faultlab::server::course_rows {

core::Error NoCourse() {
  return core::Refuse("no_course").As(core::ErrorCode::kNotFound);
}

bool Exists(Transaction& tx, std::int64_t course) {
  return CountRows(tx, "course WHERE id = :id", {{"id", course}}) == 1;
}

void PutMember(Transaction& tx, std::int64_t course, std::int64_t account, bool teaches) {
  // Rounded in the same way as the times of the members' runs.
  const std::int64_t since_ms = ToMilliseconds(
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()));
  InsertInto(tx,
             "enrolment",
             {{"course_id", course},
              {"account_id", account},
              {"teaches", teaches},
              {"since_ms", since_ms}},
             "ON CONFLICT (course_id, account_id) DO NOTHING");
}

bool IsMember(Transaction& tx, std::int64_t course, std::int64_t account) {
  return CountRows(tx,
                   "enrolment WHERE course_id = :course AND account_id = :account",
                   {{"course", course}, {"account", account}}) > 0;
}

bool PutInvitation(Transaction& tx,
                   std::int64_t course,
                   std::int64_t account,
                   std::int64_t teacher,
                   WallTime now) {
  return InsertInto(tx,
                    "course_invitation",
                    {{"course_id", course},
                     {"account_id", account},
                     {"invited_by", teacher},
                     {"created_ms", now}},
                    "ON CONFLICT (course_id, account_id) DO NOTHING") > 0;
}

bool DropInvitation(Transaction& tx, std::int64_t course, std::int64_t account) {
  return Execute(
             tx,
             "DELETE FROM course_invitation WHERE course_id = :course AND account_id = :account",
             {{"course", course}, {"account", account}}) == 1;
}

}  // namespace faultlab::server::course_rows
