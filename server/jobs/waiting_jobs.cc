#include "server/jobs/waiting_jobs.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

/// "(:x0, :x1)", and their values.
std::string ListOf(const std::vector<std::string>& values, Parameters& parameters) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string name = "x" + std::to_string(i);
    text += (i == 0 ? "(:" : ", :") + name;
    parameters.emplace_back(name, values[i]);
  }
  return text + ")";
}

/// As the indexes job_to_run and job_to_compute have it.
std::string Waiting(bool computing) {
  return std::string("state = 'waiting' AND recording ") + (computing ? "<> ''" : "= ''");
}

void AddGroups(Transaction& tx, bool computing, std::vector<WaitingGroup>& groups) {
  const std::string query = "SELECT rig, owner, created_ms FROM job WHERE " + Waiting(computing);
  const std::string order = " ORDER BY rig, owner, created_ms LIMIT 1";
  auto next = SelectTuple<std::string, std::string, std::int64_t>(tx, query + order);
  while (next) {
    const auto& [rig, owner, since_ms] = *next;
    groups.push_back({computing, rig, owner, since_ms});
    next = SelectTuple<std::string, std::string, std::int64_t>(
        tx,
        query + " AND (rig, owner) > (:rig, :owner)" + order,
        {{"rig", std::string(rig)}, {"owner", std::string(owner)}});
  }
}

/// When the last job of this owner ended; 0: none has.
std::int64_t LastEnded(Transaction& tx, const std::string& owner) {
  std::int64_t last_ms = 0;
  for (const std::string state : {"finished", "failed", "cancelled"}) {
    const auto ended_ms = SelectValue<std::int64_t>(tx,
                                                    "SELECT ended_ms FROM job WHERE owner = :owner "
                                                    "AND state = :state "
                                                    "ORDER BY ended_ms DESC LIMIT 1",
                                                    {{"owner", owner}, {"state", state}});
    last_ms = std::max(last_ms, ended_ms.value_or(0));
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
  for (const auto& [owner, running] : SelectTuples<std::string, int>(
           tx, "SELECT owner, COUNT(*) FROM job WHERE state = 'running' GROUP BY owner")) {
    for (WaitingGroup& group : groups) {
      if (group.owner == owner) group.running = running;
    }
  }
  std::ranges::sort(groups, [](const WaitingGroup& a, const WaitingGroup& b) {
    return std::tie(a.running, a.since_ms, a.owner) < std::tie(b.running, b.since_ms, b.owner);
  });
}

std::optional<std::string> LockOldest(Transaction& tx,
                                      const WaitingGroup& group,
                                      const std::vector<std::string>& left_out) {
  Parameters parameters{{"rig", group.rig}, {"owner", group.owner}};
  std::string query =
      "SELECT id FROM job WHERE " + Waiting(group.computing) + " AND rig = :rig AND owner = :owner";
  if (!left_out.empty()) query += " AND id NOT IN " + ListOf(left_out, parameters);
  query += " ORDER BY created_ms, id LIMIT 1";
  if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE SKIP LOCKED";
  return SelectValue<std::string>(tx, query, parameters);
}

}  // namespace faultlab::server
