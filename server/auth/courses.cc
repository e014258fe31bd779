// Accounts: courses, their members, and their teachers.

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/auth/course_rows.h"
#include "server/storage/owner_key.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {

template <typename Visit>
void Fields(Course& course, Visit&& visit) {
  visit("c.id", course.id);
  visit("c.name", course.name);
  visit("c.ends_ms", course.ends);
  visit("COALESCE(mine.teaches, 0)", course.teaches);
  visit("(SELECT COUNT(*) FROM enrolment e WHERE e.course_id = c.id)", course.members);
}

namespace {

using core::Done;

core::Status CheckCourses(Transaction& tx, std::int64_t teacher) {
  const std::int64_t taught = CountRows(
      tx, "enrolment WHERE account_id = :teacher AND teaches = 1", {{"teacher", teacher}});
  if (taught < Accounts::kCoursesTaughtMax) return Done{};
  return core::Refuse("courses_full", "", {{"most", Accounts::kCoursesTaughtMax}});
}

core::Result<bool> Enrolled(Database& database,
                            std::int64_t account,
                            std::int64_t course,
                            std::int64_t teaches) {
  return database.Read([&](Transaction& tx) {
    return CountRows(tx,
                     "enrolment WHERE account_id = :account "
                     "AND course_id = :course AND teaches >= :teaches",
                     {{"account", account}, {"course", course}, {"teaches", teaches}}) > 0;
  });
}

}  // namespace

core::Result<Course> Accounts::CreateCourse(const std::string& name,
                                            std::int64_t teacher,
                                            WallTime now) {
  if (name.empty() || name.size() > 200) {
    return core::Refuse("name_length", "name");
  }
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Course> {
    Course course;
    course.name = name;
    course.teaches = true;
    course.members = 1;
    TakeTurn(tx, "courses of " + std::to_string(teacher));
    if (const auto room = CheckCourses(tx, teacher); !room.ok()) return room.error();
    // The newest id may belong to a course of another server.
    course.id = AddInto(tx, "course", {{"name", name}, {"created_ms", now}});
    course_rows::PutMember(tx, course.id, teacher, /*teaches=*/true);
    return course;
  });
}

core::Result<std::vector<Course>> Accounts::ListCourses(std::int64_t account_id,
                                                        bool all,
                                                        std::int64_t after,
                                                        int limit) {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<Course>(tx,
                              std::string("course c ") + (all ? "LEFT " : "") +
                                  "JOIN enrolment mine ON mine.course_id = c.id AND "
                                  "mine.account_id = :account WHERE c.id > :after "
                                  "ORDER BY c.id LIMIT :count",
                              {{"account", account_id}, {"after", after}, {"count", limit}});
  });
}

core::Result<std::optional<Course>> Accounts::FindCourse(std::int64_t course_id) {
  constexpr bool kAll = true;
  TRY(auto found, ListCourses(0, kAll, course_id - 1, 1));
  if (found.empty() || found.front().id != course_id) return std::optional<Course>{};
  return std::optional(std::move(found.front()));
}

core::Status Accounts::SetCourseEnd(std::int64_t course_id, std::optional<WallTime> ends) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    UpdateWhere(tx, "course", {{"ends_ms", ends}}, {{"id", course_id}});
    return Done{};
  });
}

core::Status Accounts::Enrol(std::int64_t course_id, std::int64_t account_id, bool teaches) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    if (!account_rows::Find(tx, "id = :value", account_id)) return account_rows::NoAccount();
    course_rows::PutMember(tx, course_id, account_id, teaches);
    course_rows::DropInvitation(tx, course_id, account_id);
    return Done{};
  });
}

core::Status Accounts::EndEnrolment(std::int64_t course_id, std::int64_t account_id) {
  const auto ended = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (DeleteFrom(tx, "enrolment", {{"course_id", course_id}, {"account_id", account_id}}) != 1) {
      return core::Refuse("not_a_member");
    }
    return Done{};
  });
  if (ended.ok()) {
    Tell({.what = Revocation::What::kCourse, .account_id = account_id, .course_id = course_id});
  }
  return ended;
}

core::Result<std::vector<Account>> Accounts::Members(std::int64_t course_id) {
  using Found = std::vector<Account>;
  return database_.Read([&](Transaction& tx) -> core::Result<Found> {
    if (!course_rows::Exists(tx, course_id)) return course_rows::NoCourse();
    Found out;
    ForEachRow<account_rows::Row>(
        tx,
        "account WHERE id IN (SELECT account_id FROM enrolment WHERE course_id = :course) "
        "ORDER BY login",
        [&out](const account_rows::Row& row) { out.push_back(row.ToAccount()); },
        {{"course", course_id}});
    return out;
  });
}

core::Result<Ownership> Accounts::Relation(const Principal& who,
                                           std::int64_t account_id,
                                           std::optional<WallTime> made_at) {
  if (who.user_id == account_id) return Ownership::kOwn;
  const std::int64_t made_ms = made_at ? ToMilliseconds(*made_at) : INT64_MAX;
  return database_.Read([&](Transaction& tx) -> core::Result<Ownership> {
    const std::int64_t common =
        CountRows(tx,
                  "enrolment mine JOIN enrolment theirs "
                  "ON mine.course_id = theirs.course_id WHERE mine.account_id = :me "
                  "AND mine.teaches = 1 AND theirs.account_id = :they AND theirs.since_ms <= :made",
                  {{"me", who.user_id}, {"they", account_id}, {"made", made_ms}});
    return common > 0 ? Ownership::kCourse : Ownership::kForeign;
  });
}

core::Result<Ownership> Accounts::RelationTo(const Principal& who,
                                             std::string_view owner_key,
                                             std::optional<WallTime> made_at) {
  const Ownership whose = OwnershipOf(who, owner_key);
  if (whose == Ownership::kOwn || !who.signed_in()) return whose;
  const std::optional<std::int64_t> owner = AccountOfOwner(owner_key);
  return owner ? Relation(who, *owner, made_at) : whose;
}

core::Result<bool> Accounts::Teaches(std::int64_t account_id, std::int64_t course_id) {
  return Enrolled(database_, account_id, course_id, 1);
}

core::Result<bool> Accounts::Attends(std::int64_t account_id, std::int64_t course_id) {
  return Enrolled(database_, account_id, course_id, 0);
}

core::Result<std::vector<std::int64_t>> Accounts::CoursesOf(std::int64_t account_id) {
  return database_.Read([&](Transaction& tx) {
    return SelectColumn<std::int64_t>(
        tx,
        "SELECT course_id FROM enrolment WHERE account_id = :account ORDER BY course_id",
        {{"account", account_id}});
  });
}

core::Result<Ownership> Accounts::InCourse(std::int64_t account_id, std::int64_t course_id) {
  TRY(const auto teaches, Teaches(account_id, course_id));
  if (teaches) return Ownership::kOwn;
  TRY(const auto attends, Attends(account_id, course_id));
  return attends ? Ownership::kCourse : Ownership::kForeign;
}

}  // namespace faultlab::server
