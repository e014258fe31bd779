#include "server/jobs/waiting_jobs.h"

#include <soci/soci.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace faultlab::server {
namespace {

using soci::into;
using soci::use;

/// "(:x0, :x1)", and the values bound to it.
std::string BindList(soci::statement& statement, const std::vector<std::string>& values) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string name = "x" + std::to_string(i);
    text += (i == 0 ? "(:" : ", :") + name;
    statement.exchange(use(values[i], name));
  }
  return text + ")";
}

/// As the indexes job_to_run and job_to_compute have it.
std::string Waiting(bool computing) {
  return std::string("state = 'waiting' AND recording ") + (computing ? "<> ''" : "= ''");
}

void AddGroups(Transaction& tx, bool computing, std::vector<WaitingGroup>& groups) {
  WaitingGroup next;
  next.computing = computing;
  const std::string query = "SELECT rig, owner, created_ms FROM job WHERE " + Waiting(computing);
  const std::string order = " ORDER BY rig, owner, created_ms LIMIT 1";
  tx.sql() << query + order, into(next.rig), into(next.owner), into(next.since_ms);
  while (tx.sql().got_data()) {
    groups.push_back(next);
    const WaitingGroup& last = groups.back();
    tx.sql() << query + " AND (rig, owner) > (:rig, :owner)" + order, into(next.rig),
        into(next.owner), into(next.since_ms), use(last.rig, "rig"), use(last.owner, "owner");
  }
}

/// When the last job of this owner ended; 0: none has.
std::int64_t LastEnded(Transaction& tx, const std::string& owner) {
  std::int64_t last_ms = 0;
  for (const std::string state : {"finished", "failed", "cancelled"}) {
    std::int64_t ended_ms = 0;
    tx.sql() << "SELECT ended_ms FROM job WHERE owner = :owner AND state = :state "
                "ORDER BY ended_ms DESC LIMIT 1",
        into(ended_ms), use(owner, "owner"), use(state, "state");
    if (tx.sql().got_data()) last_ms = std::max(last_ms, ended_ms);
  }
  return last_ms;
}

}  // namespace

std::vector<WaitingGroup> WaitingGroups(Transaction& tx) {
  std::vector<WaitingGroup> groups;
  for (const bool computing : {false, true}) AddGroups(tx, computing, groups);
  return groups;
}

void OrderByTurn(Transaction& tx, std::vector<WaitingGroup>& groups) {
  std::map<std::string, std::int64_t> ended_ms;  // by owner
  for (WaitingGroup& group : groups) {
    const auto [last, is_new] = ended_ms.try_emplace(group.owner);
    if (is_new) last->second = LastEnded(tx, group.owner);
    group.since_ms = std::max(group.since_ms, last->second);
  }
  std::string owner;
  int running = 0;
  soci::statement statement =
      (tx.sql().prepare << "SELECT owner, COUNT(*) FROM job WHERE state = 'running' GROUP BY owner",
       into(owner),
       into(running));
  statement.execute(false);
  while (statement.fetch()) {
    for (WaitingGroup& group : groups) {
      if (group.owner == owner) group.running = running;
    }
  }
  std::sort(groups.begin(), groups.end(), [](const WaitingGroup& a, const WaitingGroup& b) {
    return std::tie(a.running, a.since_ms, a.owner) < std::tie(b.running, b.since_ms, b.owner);
  });
}

std::optional<std::string> LockOldest(Transaction& tx,
                                      const WaitingGroup& group,
                                      const std::vector<std::string>& left_out) {
  std::string id;
  soci::statement statement(tx.sql());
  statement.exchange(into(id));
  statement.exchange(use(group.rig, "rig"));
  statement.exchange(use(group.owner, "owner"));
  std::string query =
      "SELECT id FROM job WHERE " + Waiting(group.computing) + " AND rig = :rig AND owner = :owner";
  if (!left_out.empty()) query += " AND id NOT IN " + BindList(statement, left_out);
  query += " ORDER BY created_ms, id LIMIT 1";
  if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE SKIP LOCKED";
  statement.alloc();
  statement.prepare(query);
  statement.define_and_bind();
  if (!statement.execute(true)) return std::nullopt;
  return id;
}

}  // namespace faultlab::server
