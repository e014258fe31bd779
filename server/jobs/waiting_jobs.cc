#include "server/jobs/waiting_jobs.h"

#include <soci/soci.h>

#include <algorithm>
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

}  // namespace

std::vector<WaitingGroup> WaitingGroups(Transaction& tx) {
  std::vector<WaitingGroup> groups;
  WaitingGroup next;
  tx.sql() << "SELECT rig, owner, created_ms FROM job WHERE state = 'waiting' "
              "ORDER BY rig, owner, created_ms LIMIT 1",
      into(next.rig), into(next.owner), into(next.oldest_ms);
  while (tx.sql().got_data()) {
    groups.push_back(next);
    const WaitingGroup& last = groups.back();
    tx.sql() << "SELECT rig, owner, created_ms FROM job WHERE state = 'waiting' AND "
                "(rig, owner) > (:rig, :owner) ORDER BY rig, owner, created_ms LIMIT 1",
        into(next.rig), into(next.owner), into(next.oldest_ms), use(last.rig, "rig"),
        use(last.owner, "owner");
  }
  return groups;
}

void OrderByTurn(Transaction& tx, std::vector<WaitingGroup>& groups) {
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
    return std::tie(a.running, a.oldest_ms, a.owner) < std::tie(b.running, b.oldest_ms, b.owner);
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
      "SELECT id FROM job WHERE state = 'waiting' AND rig = :rig AND owner = :owner";
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
