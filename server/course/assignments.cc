#include "server/course/assignments.h"

#include <algorithm>
#include <array>

#include "server/course/grade.h"
#include "server/storage/not_yours.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::course {

template <typename Visit>
void Fields(Assignment& of, Visit&& visit) {
  visit("id", of.id);
  visit("course_id", of.course);
  visit("account_id", of.author);
  visit("fault_set_id", of.fault_set);
  visit("name", of.name);
  visit("bench", of.bench);
  visit("pool", of.pool_json);
  visit("plan", of.plan_json);
  visit("rubric", of.rubric_json);
  visit("opens_ms", of.opens);
  visit("due_ms", of.due);
  visit("attempts", of.attempts);
  visit("reveal_at_once", of.reveal_at_once);
  visit("secret", of.secret);
  visit("created_ms", of.created_at);
  visit("version", of.version);
  visit("on_bench", of.on_bench);
  visit("rubric_version", of.rubric_version);
  visit("group_max", of.group_max);
  visit("deleted", of.deleted);
}

namespace {

using core::Done;

void ReadExtensions(Transaction& tx, Assignment& of) {
  for (const auto& [account, due] : SelectTuples<std::int64_t, WallTime>(
           tx,
           "SELECT account_id, due_ms FROM assignment_extension WHERE assignment_id = :id",
           {{"id", of.id}})) {
    of.extensions[account] = due;
  }
}

std::vector<Assignment> SelectAssignments(Transaction& tx, const std::string& condition) {
  std::vector<Assignment> out = SelectRows<Assignment>(tx, "assignment WHERE " + condition);
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
    const std::int64_t kept = CountRows(tx,
                                        "assignment WHERE course_id = :course AND deleted = 0",
                                        {{"course", assignment.course}});
    if (kept >= kOfCourseMax) {
      return core::Refuse("assignments_full", "", {{"most", kOfCourseMax}});
    }
    assignment.id = AddRow(tx, "assignment", assignment);
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
  return database_.Read([&](Transaction& tx) { return SelectAssignments(tx, condition); });
}

core::Result<Assignment> Assignments::Change(const Assignment& assignment, std::int64_t version) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Assignment> {
    TakeTurn(tx, "assignment " + std::to_string(assignment.id));
    const auto before = FindAssignment(tx, assignment.id);
    if (!before) return NotYours();
    if (before->version != version) {
      return core::Refuse("assignment_changed");
    }
    Assignment changed = assignment;
    changed.version = version + 1;
    // What an answer loses for being late depends on when it was due.
    const bool same = GradesAlike(before->rubric_json, assignment.rubric_json) &&
                      (before->due == assignment.due || !LosesByLateness(assignment.rubric_json));
    changed.rubric_version = before->rubric_version + (same ? 0 : 1);
    constexpr std::array<std::string_view, 8> kChanged = {"name",
                                                          "opens_ms",
                                                          "due_ms",
                                                          "attempts",
                                                          "reveal_at_once",
                                                          "version",
                                                          "rubric",
                                                          "rubric_version"};
    ChangeRows(tx, "assignment", changed, kChanged, "id = :id", {{"id", assignment.id}});
    // Another attempt may count: platforms are told (server/lti).
    if (!CountsAlike(before->rubric_json, assignment.rubric_json)) {
      UpdateWhere(tx, "lti_seat", {{"due", 1}}, {{"assignment_id", assignment.id}});
    }
    return *FindAssignment(tx, assignment.id);
  });
}

core::Status Assignments::Extend(std::int64_t id,
                                 std::int64_t account,
                                 std::optional<WallTime> due) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    DeleteFrom(tx, "assignment_extension", {{"assignment_id", id}, {"account_id", account}});
    // What answers have lost for being late is counted anew.
    TakeTurn(tx, "assignment " + std::to_string(id));
    if (const auto of = FindAssignment(tx, id); of && LosesByLateness(of->rubric_json)) {
      UpdateWhere(tx, "assignment", {{"rubric_version", of->rubric_version + 1}}, {{"id", id}});
    }
    if (!due) return Done{};
    InsertInto(tx,
               "assignment_extension",
               {{"assignment_id", id}, {"account_id", account}, {"due_ms", *due}});
    return Done{};
  });
}

core::Status Assignments::Delete(std::int64_t id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    UpdateWhere(tx, "assignment", {{"deleted", 1}}, {{"id", id}});
  });
}

}  // namespace faultlab::server::course
