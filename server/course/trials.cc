#include "server/course/trials.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>

#include "server/course/grade.h"
#include "server/course/groups.h"
#include "server/storage/not_yours.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

using core::Done;

constexpr std::array<std::string_view, 5> kStates = {
    "drawn", "running", "open", "answered", "void"};

}  // namespace

template <typename Visit>
void Fields(Trial& trial, Visit&& visit) {
  visit("id", trial.id);
  visit("assignment_id", trial.assignment);
  visit("account_id", trial.account);
  visit("state", trial.state, kStates);
  visit("item", trial.item);
  visit("run", trial.run);
  visit("commitment", trial.commitment);
  visit("nonce", trial.nonce);
  visit("truth", trial.truth);
  visit("events", trial.events);
  visit("created_ms", trial.created_at);
  visit("ended_ms", trial.ended_at);
  visit("answer", trial.answer);
  visit("answered_ms", trial.answered_at);
  visit("grade", trial.grade);
  visit("awarded", trial.awarded);
  visit("released_ms", trial.released_at);
  visit("why", trial.why);
  visit("graded_by", trial.graded_by);
  visit("copies", trial.copies);
  visit("hints", trial.hints);
  visit("tried", trial.tried);
}

template <typename Visit>
void Fields(Trials::Sealed& sealed, Visit&& visit) {
  visit("id", sealed.id);
  visit("run", sealed.run);
  visit("assignment_id", sealed.assignment);
  visit("account_id", sealed.account);
}

std::string_view Name(TrialState state) {
  return kStates[static_cast<std::size_t>(state)];
}

namespace {

std::optional<Trial> Find(Transaction& tx, std::int64_t id) {
  return SelectRow<Trial>(tx, "trial WHERE id = :id", {{"id", id}});
}

/// @param from  states in which it may be, in SQL
core::Status Move(Transaction& tx,
                  std::int64_t id,
                  const std::string& from,
                  const Parameters& set) {
  const std::string which =
      "id = " + std::to_string(id) + " AND released_ms = 0 AND state IN (" + from + ")";
  const std::string columns = rows::Equal(set, "", ", ");
  if (Execute(tx, "UPDATE trial SET " + columns + " WHERE " + which, set) == 1) return Done{};
  return core::Refuse("trial_changed");
}

core::Status Move(Database& database,
                  std::int64_t id,
                  const std::string& from,
                  const Parameters& set) {
  return database.Write(Durability::kPromise,
                        [&](Transaction& tx) { return Move(tx, id, from, set); });
}

/// Of one that is open and has had these hints: what they cost is counted before.
core::Status MoveOpen(Database& database,
                      std::int64_t id,
                      const std::string& hints,
                      const Parameters& set) {
  return database.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TakeTurn(tx, "hints of trial " + std::to_string(id));
    const auto trial = Find(tx, id);
    if (!trial || trial->hints != hints) return core::Refuse("trial_changed");
    return Move(tx, id, "'open'", set);
  });
}

/// Platforms that show this grade are told of it (server/lti).
void MarkDue(Transaction& tx, std::int64_t id) {
  const auto trial = Find(tx, id);
  if (!trial) return;
  Execute(tx, "UPDATE lti_seat SET due = 1 WHERE " + WithMates(trial->assignment, trial->account));
}

}  // namespace

core::Result<Trial> Trials::Add(
    std::int64_t assignment,
    std::int64_t account,
    int attempts,
    WallTime now,
    std::optional<std::chrono::milliseconds> limit,
    const std::function<void(const std::vector<Trial>&, Trial&)>& draw) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Trial> {
    TakeTurn(tx, "trials of assignment " + std::to_string(assignment));
    const std::vector<Trial> former =
        SelectRows<Trial>(tx, "trial WHERE " + WithMates(assignment, account) + " ORDER BY id");
    int counted = 0;
    for (const Trial& each : former) {
      if (each.state == TrialState::kVoid) continue;
      ++counted;
      if (each.state == TrialState::kAnswered || each.released_at) continue;
      if (each.state == TrialState::kOpen && limit && now >= each.created_at + *limit) continue;
      return core::Refuse("trial_open", "", {{"trial", each.id}});
    }
    if (counted >= attempts) {
      return core::Refuse("attempts_used", "", {{"attempts", attempts}});
    }
    Trial trial;
    trial.assignment = assignment;
    trial.account = account;
    trial.created_at = now;
    draw(former, trial);
    trial.events = "[]";
    trial.id = AddRow(tx, "trial", trial);
    return trial;
  });
}

core::Status Trials::Forget(std::int64_t id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    DeleteFrom(tx, "trial", {{"id", id}, {"state", "drawn"}});
  });
}

core::Status Trials::Began(std::int64_t id, const std::string& run) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TRY_DONE(Move(tx, id, "'drawn', 'open', 'void'", {{"run", run}}));
    UpdateWhere(tx, "trial", {{"state", "running"}}, {{"id", id}, {"state", "drawn"}});
    return Done{};
  });
}

core::Status Trials::Ended(std::int64_t id, const std::string& events, WallTime now) {
  return Move(database_,
              id,
              "'drawn', 'running'",
              {{"state", "open"}, {"events", events}, {"ended_ms", now}});
}

core::Status Trials::Answer(std::int64_t id,
                            const std::string& hints,
                            const std::string& answer,
                            const std::string& grade,
                            std::int64_t graded_by,
                            const std::string& events,
                            WallTime now) {
  return MoveOpen(database_,
                  id,
                  hints,
                  {{"state", "answered"},
                   {"answer", answer},
                   {"grade", grade},
                   {"graded_by", graded_by},
                   {"events", events},
                   {"answered_ms", now}});
}

core::Status Trials::TakeHint(std::int64_t id, const std::string& had, const std::string& hints) {
  return MoveOpen(database_, id, had, {{"hints", hints}});
}

core::Status Trials::GradeAgain(std::int64_t id, const std::string& grade, std::int64_t graded_by) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    Execute(tx,
            "UPDATE trial SET grade = :grade, graded_by = :by WHERE id = :id AND state = "
            "'answered' AND graded_by < :by",
            {{"grade", grade}, {"by", graded_by}, {"id", id}});
    MarkDue(tx, id);
  });
}

core::Status Trials::Release(std::int64_t id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TRY_DONE(Move(tx, id, "'open', 'answered', 'void'", {{"released_ms", now}}));
    MarkDue(tx, id);
    return Done{};
  });
}

core::Status Trials::Award(std::int64_t id, const std::string& awarded) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    Execute(tx,
            "UPDATE trial SET awarded = :awarded WHERE id = :id AND released_ms > 0",
            {{"awarded", awarded}, {"id", id}});
    MarkDue(tx, id);
  });
}

core::Status Trials::Void(std::int64_t id, const std::string& why, WallTime now) {
  return Move(database_,
              id,
              "'drawn', 'running', 'open'",
              {{"state", "void"}, {"why", why}, {"ended_ms", now}});
}

core::Result<Trial> Trials::Get(std::int64_t id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Trial> {
    auto found = Find(tx, id);
    if (!found) return NotYours();
    return std::move(*found);
  });
}

core::Result<std::vector<Trials::Sealed>> Trials::SealedNow(WallTime now) {
  constexpr auto kLate = std::chrono::hours(kLateHoursMax);
  return database_.Read([&](Transaction& tx) {
    return SelectRows<Sealed>(tx,
                              "trial WHERE released_ms = 0 AND run <> '' AND assignment_id IN "
                              "(SELECT id FROM assignment WHERE due_ms > :since UNION SELECT "
                              "assignment_id FROM assignment_extension WHERE due_ms > :since)",
                              {{"since", now - kLate}});
  });
}

core::Status Trials::AddCopy(std::int64_t id, const std::string& copy_json) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TakeTurn(tx, "copies of trial " + std::to_string(id));
    const auto found = Find(tx, id);
    if (!found) return NotYours();
    json::value list = json::parse(found->copies);
    json::array& copies = list.as_array();
    const json::value copy = json::parse(copy_json);
    // One line a person, and one for all guests: nobody is hidden behind others' many.
    const auto same = std::ranges::find_if(copies, [&copy](const json::value& each) {
      return each.at("account") == copy.at("account");
    });
    if (same != copies.end()) {
      *same = copy;
    } else if (copies.size() < kCopiesMax) {
      copies.push_back(copy);
    }
    UpdateWhere(tx, "trial", {{"copies", json::serialize(copies)}}, {{"id", id}});
    return Done{};
  });
}

core::Result<std::map<std::int64_t, bool>> Trials::Begun(std::int64_t assignment) {
  return database_.Read([&](Transaction& tx) {
    std::map<std::int64_t, bool> begun;
    for (const auto& [account, answered] : SelectTuples<std::int64_t, std::int64_t>(
             tx,
             "SELECT account_id, COUNT(CASE WHEN state = 'answered' THEN 1 END) FROM trial WHERE "
             "assignment_id = :of AND state <> 'void' AND tried = 0 GROUP BY account_id",
             {{"of", assignment}})) {
      begun[account] = answered > 0;
    }
    return begun;
  });
}

core::Result<std::vector<std::int64_t>> Trials::Overdue(std::int64_t after,
                                                        std::size_t limit,
                                                        WallTime now) {
  return database_.Read([&](Transaction& tx) {
    std::vector<std::int64_t> ids;
    for (const auto& [id, state] : SelectTuples<std::int64_t, std::string>(
             tx,
             "SELECT id, state FROM trial WHERE id > :after AND state = 'answered' AND EXISTS "
             "(SELECT 1 FROM assignment a WHERE a.id = trial.assignment_id AND ((released_ms = 0 "
             "AND a.due_ms < :now) OR graded_by < a.rubric_version)) ORDER BY id LIMIT " +
                 std::to_string(limit),
             {{"after", after}, {"now", now}})) {
      ids.push_back(id);
    }
    return ids;
  });
}

core::Result<std::int64_t> Trials::Stale(const Assignment& assignment) {
  return database_.Read([&](Transaction& tx) {
    return CountRows(
        tx,
        "trial WHERE assignment_id = :id AND state = 'answered' AND graded_by < :rubric",
        {{"id", assignment.id}, {"rubric", assignment.rubric_version}});
  });
}

core::Result<bool> Trials::IsOf(std::int64_t id, std::int64_t account) {
  TRY(const auto trial, Get(id));
  return database_.Read([&](Transaction& tx) {
    return CountRows(tx,
                     "trial WHERE " + WithMates(trial.assignment, account) + " AND id = :id",
                     {{"id", id}}) > 0;
  });
}

core::Result<std::vector<Trial>> Trials::Of(std::int64_t assignment,
                                            std::optional<std::int64_t> account,
                                            std::int64_t after,
                                            int limit) {
  std::string condition =
      account ? WithMates(assignment, *account) : "assignment_id = " + std::to_string(assignment);
  condition += " AND id > " + std::to_string(after) + " ORDER BY id LIMIT " + std::to_string(limit);
  return database_.Read(
      [&](Transaction& tx) { return SelectRows<Trial>(tx, "trial WHERE " + condition); });
}

}  // namespace faultlab::server::course
