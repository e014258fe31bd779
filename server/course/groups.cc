#include "server/course/groups.h"

#include <cctype>
#include <string_view>

#include "server/auth/secrets.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::course {
namespace {

using core::Done;
using core::Error;

// Without those that look alike.
constexpr std::string_view kLetters = "ABCDEFGHJKMNPQRSTUVWXYZ23456789";
constexpr int kCodeLength = 6;

std::string NewCode() {
  std::string code;
  std::uint64_t number = SecretNumber();
  for (int i = 0; i < kCodeLength; ++i) {
    code += kLetters[number % kLetters.size()];
    number /= kLetters.size();
  }
  return code;
}

std::string AsWritten(const std::string& code) {
  std::string out;
  for (const char c : code) {
    if (c != ' ') out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return out;
}

Group Read(Transaction& tx, std::int64_t id) {
  return {
      id,
      SelectValue<std::string>(tx, "SELECT code FROM assignment_group WHERE id = :id", {{"id", id}})
          .value_or(""),
      SelectColumn<std::int64_t>(
          tx,
          "SELECT account_id FROM assignment_mate WHERE group_id = :id ORDER BY 1",
          {{"id", id}})};
}

std::optional<Group> GroupOf(Transaction& tx, std::int64_t assignment, std::int64_t account) {
  const auto id = SelectValue<std::int64_t>(
      tx,
      "SELECT group_id FROM assignment_mate WHERE assignment_id = :of AND account_id = :who",
      {{"of", assignment}, {"who", account}});
  if (!id) return std::nullopt;
  return Read(tx, *id);
}

/// Whether this person, or somebody in the same group, has begun a trial.
bool HasBegun(Transaction& tx, std::int64_t assignment, std::int64_t account) {
  return CountRows(tx, "trial WHERE " + WithMates(assignment, account)) > 0;
}

Error Begun() {
  return core::Refuse("group_begun");
}

/// Whoever is in a group already, or has begun, cannot be in another one.
core::Status MayEnter(Transaction& tx, std::int64_t assignment, std::int64_t account) {
  if (GroupOf(tx, assignment, account)) {
    return core::Refuse("in_group");
  }
  if (HasBegun(tx, assignment, account)) return Begun();
  return Done{};
}

void Enter(Transaction& tx, std::int64_t assignment, std::int64_t account, std::int64_t group) {
  InsertInto(tx,
             "assignment_mate",
             {{"assignment_id", assignment}, {"account_id", account}, {"group_id", group}});
}

void TakeTurnOf(Transaction& tx, std::int64_t assignment) {
  TakeTurn(tx, "trials of assignment " + std::to_string(assignment));
}

}  // namespace

std::string WithMates(std::int64_t assignment, std::int64_t account) {
  const std::string of = std::to_string(assignment);
  const std::string who = std::to_string(account);
  return "assignment_id = " + of + " AND (account_id = " + who +
         " OR account_id IN (SELECT mate.account_id FROM assignment_mate mate JOIN "
         "assignment_mate me ON me.group_id = mate.group_id WHERE me.assignment_id = " +
         of + " AND me.account_id = " + who + "))";
}

core::Result<std::optional<Group>> Groups::Of(std::int64_t assignment, std::int64_t account) {
  return database_.Read([&](Transaction& tx) { return GroupOf(tx, assignment, account); });
}

core::Result<std::map<std::int64_t, Group>> Groups::All(std::int64_t assignment) {
  return database_.Read([&](Transaction& tx) {
    std::map<std::int64_t, Group> groups;
    for (const auto& [id, code, account] : SelectTuples<std::int64_t, std::string, std::int64_t>(
             tx,
             "SELECT g.id, g.code, m.account_id FROM assignment_group g JOIN assignment_mate m ON "
             "m.group_id = g.id WHERE g.assignment_id = :of ORDER BY m.account_id",
             {{"of", assignment}})) {
      groups.try_emplace(id, Group{id, code, {}}).first->second.members.push_back(account);
    }
    std::map<std::int64_t, Group> by_member;
    for (const auto& [id, group] : groups) {
      for (const std::int64_t member : group.members) by_member.emplace(member, group);
    }
    return by_member;
  });
}

core::Result<Group> Groups::Form(std::int64_t assignment, std::int64_t account) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Group> {
    TakeTurnOf(tx, assignment);
    TRY_DONE(MayEnter(tx, assignment, account));
    const std::int64_t id =
        AddInto(tx, "assignment_group", {{"assignment_id", assignment}, {"code", NewCode()}});
    Enter(tx, assignment, account, id);
    return Read(tx, id);
  });
}

core::Result<Group> Groups::Join(std::int64_t assignment,
                                 std::int64_t account,
                                 const std::string& code,
                                 int most,
                                 WallTime now) {
  const std::string guesser = std::to_string(account);
  TRY_DONE(guesses_.Try(guesser, now));
  auto joined = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Group> {
    TakeTurnOf(tx, assignment);
    TRY_DONE(MayEnter(tx, assignment, account));
    const auto id = SelectValue<std::int64_t>(
        tx,
        "SELECT id FROM assignment_group WHERE assignment_id = :of AND code = :code",
        {{"of", assignment}, {"code", AsWritten(code)}});
    if (!id) return core::Refuse("group_unknown", "/code");
    const Group group = Read(tx, *id);
    if (group.members.size() >= static_cast<std::size_t>(most)) {
      return core::Refuse("group_full", "", {{"most", most}});
    }
    if (!group.members.empty() && HasBegun(tx, assignment, group.members.front())) return Begun();
    Enter(tx, assignment, account, *id);
    return Read(tx, *id);
  });
  if (joined.ok() || joined.error().reason != "group_unknown") guesses_.Forgive(guesser);
  return joined;
}

core::Status Groups::Leave(std::int64_t assignment, std::int64_t account) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    TakeTurnOf(tx, assignment);
    if (!GroupOf(tx, assignment, account)) return Done{};
    if (HasBegun(tx, assignment, account)) return Begun();
    DeleteFrom(tx, "assignment_mate", {{"assignment_id", assignment}, {"account_id", account}});
    return Done{};
  });
}

}  // namespace faultlab::server::course
