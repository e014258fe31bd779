#include "server/auth/course_rows.h"
#include "server/storage/rows.h"

#include <soci/soci.h>

#include <chrono>

namespace faultlab::server::course_rows {

using soci::into;
using soci::use;

core::Error NoCourse() {
  return core::Refuse("no_course").As(core::ErrorCode::kNotFound);
}

bool Exists(Transaction& tx, std::int64_t course) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM course WHERE id = :id", into(count), use(course, "id");
  return count == 1;
}

void PutMember(Transaction& tx, std::int64_t course, std::int64_t account, bool teaches) {
  const std::int64_t flag = teaches ? 1 : 0;
  // Rounded in the same way as the times of the members' runs.
  const std::int64_t since_ms = ToMilliseconds(
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()));
  tx.sql() << "INSERT INTO enrolment (course_id, account_id, teaches, since_ms) "
              "VALUES (:course, :account, :teaches, :since) "
              "ON CONFLICT (course_id, account_id) DO NOTHING",
      use(course, "course"), use(account, "account"), use(flag, "teaches"), use(since_ms, "since");
}

bool IsMember(Transaction& tx, std::int64_t course, std::int64_t account) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM enrolment WHERE course_id = :course AND account_id = :account",
      into(count), use(course, "course"), use(account, "account");
  return count > 0;
}

bool PutInvitation(Transaction& tx,
                   std::int64_t course,
                   std::int64_t account,
                   std::int64_t teacher,
                   WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  return Execute(tx,
                 "INSERT INTO course_invitation (course_id, account_id, invited_by, created_ms) "
                 "VALUES (:course, :account, :teacher, :now) "
                 "ON CONFLICT (course_id, account_id) DO NOTHING",
                 use(course, "course"),
                 use(account, "account"),
                 use(teacher, "teacher"),
                 use(now_ms, "now")) > 0;
}

bool DropInvitation(Transaction& tx, std::int64_t course, std::int64_t account) {
  return Execute(
             tx,
             "DELETE FROM course_invitation WHERE course_id = :course AND account_id = :account",
             use(course, "course"),
             use(account, "account")) == 1;
}

}  // namespace faultlab::server::course_rows
