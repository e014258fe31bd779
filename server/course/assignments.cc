#include "server/course/assignments.h"

#include <soci/soci.h>

#include <algorithm>

#include "server/course/grade.h"
#include "server/storage/not_yours.h"
#include "server/storage/turns.h"

namespace faultlab::server::course {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr const char* kAssignmentColumns =
    "id, course_id, account_id, fault_set_id, name, bench, pool, plan, rubric, opens_ms, due_ms, "
    "attempts, reveal_at_once, secret, created_ms, version, on_bench, rubric_version, group_max";

void ReadExtensions(Transaction& tx, Assignment& of) {
  std::int64_t account = 0, due_ms = 0;
  soci::statement statement =
      (tx.sql().prepare << "SELECT account_id, due_ms FROM assignment_extension WHERE "
                           "assignment_id = :id",
       into(account),
       into(due_ms),
       use(of.id, "id"));
  statement.execute(false);
  while (statement.fetch()) of.extensions[account] = FromMilliseconds(due_ms);
}

std::vector<Assignment> SelectAssignments(Transaction& tx, const std::string& condition) {
  Assignment row;
  std::int64_t opens_ms = 0, due_ms = 0, created_ms = 0, at_once = 0, on_bench = 0;
  soci::statement statement = (tx.sql().prepare << std::string("SELECT ") + kAssignmentColumns +
                                                       " FROM assignment WHERE " + condition,
                               into(row.id),
                               into(row.course),
                               into(row.author),
                               into(row.fault_set),
                               into(row.name),
                               into(row.bench),
                               into(row.pool_json),
                               into(row.plan_json),
                               into(row.rubric_json),
                               into(opens_ms),
                               into(due_ms),
                               into(row.attempts),
                               into(at_once),
                               into(row.secret),
                               into(created_ms),
                               into(row.version),
                               into(on_bench),
                               into(row.rubric_version),
                               into(row.group_max));
  statement.execute(false);
  std::vector<Assignment> out;
  while (statement.fetch()) {
    row.opens = FromMilliseconds(opens_ms);
    row.due = FromMilliseconds(due_ms);
    row.created_at = FromMilliseconds(created_ms);
    row.reveal_at_once = at_once != 0;
    row.on_bench = on_bench != 0;
    out.push_back(row);
  }
  for (Assignment& each : out) ReadExtensions(tx, each);
  return out;
}

std::optional<Assignment> FindAssignment(Transaction& tx, std::int64_t id) {
  std::vector<Assignment> found = SelectAssignments(tx, "id = " + std::to_string(id));
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

}  // namespace

WallTime Assignment::DueFor(std::int64_t account) const {
  const auto longer = extensions.find(account);
  return longer == extensions.end() ? due : std::max(due, longer->second);
}

core::Result<Assignment> Assignments::Create(Assignment assignment) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Assignment> {
    TakeTurn(tx, "assignments of " + std::to_string(assignment.course));
    std::int64_t kept = 0;
    tx.sql() << "SELECT COUNT(*) FROM assignment WHERE course_id = :course AND deleted = 0",
        into(kept), use(assignment.course, "course");
    if (kept >= kOfCourseMax) {
      const std::string most = std::to_string(kOfCourseMax);
      return Error{ErrorCode::kConflict,
                   "The course has " + most + " assignments, as many as it may have.",
                   "",
                   "assignments_full",
                   {{"most", most}}};
    }
    const std::int64_t opens_ms = ToMilliseconds(assignment.opens);
    const std::int64_t due_ms = ToMilliseconds(assignment.due);
    const std::int64_t created_ms = ToMilliseconds(assignment.created_at);
    const std::int64_t at_once = assignment.reveal_at_once ? 1 : 0;
    const std::int64_t on_bench = assignment.on_bench ? 1 : 0;
    tx.sql() << "INSERT INTO assignment (course_id, account_id, fault_set_id, name, bench, pool, "
                "plan, rubric, opens_ms, due_ms, attempts, reveal_at_once, secret, created_ms, "
                "on_bench, group_max, deleted) VALUES (:course, :author, :set, :name, :bench, "
                ":pool, :plan, "
                ":rubric, "
                ":opens, :due, :attempts, :at_once, :secret, :created, :on_bench, :group_max, 0) "
                "RETURNING id",
        into(assignment.id), use(assignment.course, "course"), use(assignment.author, "author"),
        use(assignment.fault_set, "set"), use(assignment.name, "name"),
        use(assignment.bench, "bench"), use(assignment.pool_json, "pool"),
        use(assignment.plan_json, "plan"), use(assignment.rubric_json, "rubric"),
        use(opens_ms, "opens"), use(due_ms, "due"), use(assignment.attempts, "attempts"),
        use(at_once, "at_once"), use(assignment.secret, "secret"), use(created_ms, "created"),
        use(on_bench, "on_bench"), use(assignment.group_max, "group_max");
    return assignment;
  });
}

core::Result<Assignment> Assignments::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Assignment> {
    auto found = FindAssignment(tx, id);
    if (!found) return NotYours();
    return std::move(*found);
  });
}

core::Result<std::vector<Assignment>> Assignments::List(std::optional<std::int64_t> account,
                                                        std::int64_t after,
                                                        int limit) {
  std::string condition = "deleted = 0 AND id > " + std::to_string(after);
  if (account) {
    condition += " AND course_id IN (SELECT course_id FROM enrolment WHERE account_id = " +
                 std::to_string(*account) + ")";
  }
  condition += " ORDER BY id LIMIT " + std::to_string(limit);
  return database_.Read([&](Transaction& tx) -> core::Result<std::vector<Assignment>> {
    return SelectAssignments(tx, condition);
  });
}

core::Result<Assignment> Assignments::Change(const Assignment& assignment, std::int64_t version) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Assignment> {
    TakeTurn(tx, "assignment " + std::to_string(assignment.id));
    const auto before = FindAssignment(tx, assignment.id);
    if (!before) return NotYours();
    if (before->version != version) {
      return Error{ErrorCode::kStale,
                   "The assignment has changed; look at it again.",
                   "",
                   "assignment_changed"};
    }
    const std::int64_t opens_ms = ToMilliseconds(assignment.opens);
    const std::int64_t due_ms = ToMilliseconds(assignment.due);
    const std::int64_t at_once = assignment.reveal_at_once ? 1 : 0;
    const std::int64_t rubric_version =
        before->rubric_version + (GradesAlike(before->rubric_json, assignment.rubric_json) ? 0 : 1);
    tx.sql() << "UPDATE assignment SET name = :name, opens_ms = :opens, due_ms = :due, "
                "attempts = :attempts, reveal_at_once = :at_once, version = version + 1, "
                "rubric = :rubric, rubric_version = :rubric_version WHERE id = :id",
        use(assignment.name, "name"), use(opens_ms, "opens"), use(due_ms, "due"),
        use(assignment.attempts, "attempts"), use(at_once, "at_once"),
        use(assignment.rubric_json, "rubric"), use(rubric_version, "rubric_version"),
        use(assignment.id, "id");
    return *FindAssignment(tx, assignment.id);
  });
}

core::Status Assignments::Extend(std::int64_t id,
                                 std::int64_t account,
                                 std::optional<WallTime> due) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "DELETE FROM assignment_extension WHERE assignment_id = :id AND account_id = :who",
        use(id, "id"), use(account, "who");
    if (!due) return Done{};
    const std::int64_t due_ms = ToMilliseconds(*due);
    tx.sql() << "INSERT INTO assignment_extension (assignment_id, account_id, due_ms) VALUES "
                "(:id, :who, :due)",
        use(id, "id"), use(account, "who"), use(due_ms, "due");
    return Done{};
  });
}

core::Status Assignments::Delete(std::int64_t id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "UPDATE assignment SET deleted = 1 WHERE id = :id", use(id, "id");
    return Done{};
  });
}

}  // namespace faultlab::server::course
