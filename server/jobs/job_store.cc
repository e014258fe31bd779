#include "server/jobs/job_store.h"

#include <algorithm>

#include "server/jobs/waiting_jobs.h"
#include "server/storage/not_yours.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server {

template <typename Visit>
void Fields(Job& job, Visit&& visit) {
  visit("id", job.id);
  visit("owner", job.owner);
  visit("account_id", job.account_id);
  visit("batch", job.batch);
  visit("name", job.name);
  visit("run_name", job.run_name);
  visit("rig", job.rig);
  visit("recording", job.recording);
  visit("state", job.state);
  visit("run_id", job.run_id);
  visit("error", job.error);
  visit("result", job.result);
  visit("created_ms", job.created_at);
  visit("started_ms", job.started_at);
  visit("ended_ms", job.ended_at);
  visit("attempts", job.attempts);
  visit("server_id", job.server_id);
  visit("boot", job.boot);
}

/// With its body, which lists do not load.
struct NewJob {
  Job job;
  std::int64_t bytes = 0;
};

template <typename Visit>
void Fields(NewJob& of, Visit&& visit) {
  Fields(of.job, visit);
  visit("body", of.job.body);
  visit("body_bytes", of.bytes);
}

struct StateCount {
  std::string state;
  std::int64_t jobs = 0;
  std::optional<WallTime> last;
};

template <typename Visit>
void Fields(StateCount& of, Visit&& visit) {
  visit("state", of.state);
  visit("jobs", of.jobs);
  visit("last_ms", of.last);
}

namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

std::optional<Job> FindJob(Transaction& tx, const std::string& id) {
  return SelectRow<Job>(tx, "job WHERE id = :id", {{"id", id}});
}

constexpr const char* kLive = "state IN ('waiting', 'running')";

std::int64_t BodyBytes(Transaction& tx, const std::string& owner) {
  return *SelectValue<std::int64_t>(
      tx,
      std::string("SELECT CAST(COALESCE(SUM(body_bytes), 0) AS BIGINT) FROM job "
                  "WHERE owner = :owner AND ") +
          kLive,
      {{"owner", owner}});
}

/// How long what these jobs are to work through takes together with what the owner's others do.
core::Status CheckWork(Transaction& tx, const std::string& owner, const std::vector<Job>& jobs) {
  std::map<std::string, std::int64_t> samples_of;
  std::int64_t samples = 0;
  for (const Job& job : jobs) {
    if (job.recording.empty()) continue;
    const auto [found, is_new] = samples_of.try_emplace(job.recording);
    if (is_new) {
      found->second =
          SelectValue<std::int64_t>(
              tx, "SELECT samples FROM recording WHERE id = :id", {{"id", job.recording}})
              .value_or(0);
    }
    samples += found->second;
  }
  if (samples == 0) return Done{};
  const auto kept = *SelectValue<std::int64_t>(
      tx,
      std::string("SELECT CAST(COALESCE(SUM(r.samples), 0) AS BIGINT) FROM job j "
                  "JOIN recording r ON r.id = j.recording WHERE j.owner = :owner AND j.") +
          kLive,
      {{"owner", owner}});
  if (kept + samples <= JobStore::kSamplesMax) return Done{};
  return core::Refuse(
      "jobs_work_full",
      "",
      {{"kept", kept}, {"wanted", kept + samples}, {"most", JobStore::kSamplesMax}});
}

core::Status CheckRoom(Transaction& tx, const std::string& owner, const std::vector<Job>& jobs) {
  const std::int64_t waiting =
      CountRows(tx, "job WHERE owner = :owner AND state = 'waiting'", {{"owner", owner}});
  if (waiting + static_cast<std::int64_t>(jobs.size()) > JobStore::kWaitingMax) {
    return core::Refuse("waiting_jobs_full");
  }
  if (const auto room = CheckWork(tx, owner, jobs); !room.ok()) return room;
  const std::int64_t kept = BodyBytes(tx, owner);
  std::int64_t bytes = kept;
  for (const Job& job : jobs) bytes += static_cast<std::int64_t>(job.body.size());
  if (bytes <= JobStore::kBodyBytesMax) return Done{};
  return core::Refuse(
      "jobs_full", "", {{"kept", kept}, {"wanted", bytes}, {"most", JobStore::kBodyBytesMax}});
}

/// An owner who submits and cancels jobs for hours would fill the database.
void DropOldIdle(Transaction& tx, const std::string& owner) {
  Execute(tx,
          "DELETE FROM job WHERE id IN (SELECT id FROM job WHERE owner = :owner AND state IN "
          "('cancelled', 'failed') AND run_id = '' ORDER BY ended_ms DESC, id DESC "
          "LIMIT 1000000 OFFSET :kept)",
          {{"owner", owner}, {"kept", JobStore::kIdleKept}});
}

/// The job with its body, now running; nullopt if it does not wait.
std::optional<Job> Begin(Transaction& tx,
                         const Claimant& who,
                         const std::string& id,
                         WallTime now) {
  if (Execute(tx,
              "UPDATE job SET state = 'running', server_id = :server, boot = :boot, "
              "started_ms = :now, attempts = attempts + 1 "
              "WHERE id = :id AND state = 'waiting'",
              {{"server", who.server_id}, {"boot", who.boot}, {"now", now}, {"id", id}}) != 1)
    return std::nullopt;
  std::optional<Job> job = FindJob(tx, id);
  job->body = *SelectValue<std::string>(tx, "SELECT body FROM job WHERE id = :id", {{"id", id}});
  return job;
}

constexpr const char* kNoMembership =
    "NOT EXISTS (SELECT 1 FROM lab_member m WHERE m.id = job.server_id AND m.boot = job.boot)";

}  // namespace

core::Status JobStore::Change(const Job& claimed, const Parameters& columns) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (LockMembership(tx, {claimed.server_id, claimed.boot}) &&
        UpdateWhere(tx,
                    "job",
                    columns,
                    {{"id", claimed.id},
                     {"server_id", claimed.server_id},
                     {"boot", claimed.boot},
                     {"attempts", claimed.attempts},
                     {"state", "running"}}) == 1) {
      return Done{};
    }
    return Error{ErrorCode::kStale, "this claim of the job is over", "", "internal"};
  });
}

core::Status JobStore::Add(const std::vector<Job>& jobs) {
  if (jobs.empty()) return core::Refuse("runs_outside", "/runs");
  const core::Status added =
      database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        const std::string& owner = jobs.front().owner;
        TakeTurn(tx, "jobs of " + owner);
        if (const auto room = CheckRoom(tx, owner, jobs); !room.ok()) return room;
        DropOldIdle(tx, owner);
        for (const Job& job : jobs) {
          InsertRow(tx, "job", NewJob{job, static_cast<std::int64_t>(job.body.size())});
        }
        return Done{};
      });
  if (added.ok() && added_) added_();
  return added;
}

core::Result<Job> JobStore::Get(const std::string& id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Job> {
    const auto job = FindJob(tx, id);
    if (!job) return NotYours();
    return *job;
  });
}

core::Result<std::int64_t> JobStore::BodyBytesOf(const std::string& owner) {
  return database_.Read(
      [&](Transaction& tx) -> core::Result<std::int64_t> { return BodyBytes(tx, owner); });
}

core::Result<std::vector<Job>> JobStore::List(const std::string& owner,
                                              const std::string& batch,
                                              std::int64_t before_ms,
                                              const std::string& before_id,
                                              int limit) {
  using Jobs = std::vector<Job>;
  return database_.Read([&](Transaction& tx) -> core::Result<Jobs> {
    Condition which;
    if (!owner.empty()) which.And("owner = :owner", {{"owner", owner}});
    if (!batch.empty()) which.And("batch = :batch", {{"batch", batch}});
    if (!before_id.empty()) {
      which.And("(created_ms, id) < (:before, :id)", {{"before", before_ms}, {"id", before_id}});
    }
    return SelectRows<Job>(tx,
                           "job WHERE " + which.sql + " ORDER BY created_ms DESC, id DESC LIMIT " +
                               std::to_string(limit),
                           which.parameters);
  });
}

core::Result<std::vector<Job>> JobStore::WaitingOn(const std::vector<std::string>& rigs,
                                                   int limit) {
  using Jobs = std::vector<Job>;
  return database_.Read([&](Transaction& tx) {
    Jobs out;
    for (const WaitingGroup& group : WaitingGroups(tx)) {
      if (std::ranges::find(rigs, group.rig) == rigs.end()) continue;
      for (Job& job :
           SelectRows<Job>(tx,
                           "job WHERE state = 'waiting' AND recording = '' AND rig = "
                           ":rig AND owner = :owner ORDER BY created_ms, id LIMIT :count",
                           {{"rig", group.rig}, {"owner", group.owner}, {"count", limit}})) {
        job.body =
            *SelectValue<std::string>(tx, "SELECT body FROM job WHERE id = :id", {{"id", job.id}});
        out.push_back(std::move(job));
      }
    }
    return out;
  });
}

core::Result<std::optional<Job>> JobStore::Claim(const Claimant& who,
                                                 const JobsLeftOut& left_out,
                                                 WallTime now) {
  using MaybeJob = std::optional<Job>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeJob> {
    std::vector<WaitingGroup> groups = WaitingGroups(tx);
    const auto leaves_out = [](const JobsLeftOut::Kinds& kinds, const WaitingGroup& group) {
      return group.computing ? kinds.computing : kinds.runs;
    };
    std::erase_if(groups, [&](const WaitingGroup& group) {
      const auto of = left_out.of.find(group.owner);
      return leaves_out(left_out.kinds, group) ||
             (of != left_out.of.end() && leaves_out(of->second.kinds, group)) ||
             std::ranges::find(left_out.on_rigs, group.rig) != left_out.on_rigs.end();
    });
    if (groups.empty() || !LockMembership(tx, who)) return MaybeJob{};
    OrderByTurn(tx, groups);
    for (const WaitingGroup& group : groups) {
      const auto of = left_out.of.find(group.owner);
      const auto id = LockOldest(
          tx, group, of == left_out.of.end() ? std::vector<std::string>{} : of->second.ids);
      if (id) return Begin(tx, who, *id, now);
    }
    return MaybeJob{};
  });
}

core::Result<std::optional<Job>> JobStore::ClaimThis(const Claimant& who,
                                                     const std::string& id,
                                                     WallTime now) {
  using MaybeJob = std::optional<Job>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeJob> {
    if (!LockMembership(tx, who)) return MaybeJob{};
    return Begin(tx, who, id, now);
  });
}

core::Status JobStore::SetRun(const Job& claimed, const std::string& run_id) {
  return Change(claimed, {{"run_id", run_id}});
}

core::Status JobStore::SetResult(const Job& claimed, const std::string& result) {
  return Change(claimed, {{"result", result}});
}

core::Status JobStore::Finish(const Job& claimed,
                              const std::string& state,
                              const std::string& error,
                              WallTime now) {
  return Change(
      claimed,
      {{"state", state}, {"error", error}, {"ended_ms", now}, {"body", ""}, {"body_bytes", 0}});
}

core::Status JobStore::GiveBack(const Job& claimed) {
  return Change(claimed,
                {{"state", "waiting"},
                 {"server_id", ""},
                 {"boot", ""},
                 {"started_ms", 0},
                 {"run_id", ""},
                 {"attempts", claimed.attempts - 1}});
}

core::Result<std::vector<std::string>> JobStore::HeldBy(const Claimant& who) {
  return database_.Read([&](Transaction& tx) {
    return SelectColumn<std::string>(
        tx,
        "SELECT id FROM job WHERE state = 'running' AND server_id = :server AND boot = :boot",
        {{"server", who.server_id}, {"boot", who.boot}});
  });
}

core::Result<Job> JobStore::Cancel(const std::string& id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Job> {
    const auto cancelled =
        Execute(tx,
                std::string("UPDATE job SET state = 'cancelled', ended_ms = :now, "
                            "body = '', body_bytes = 0 WHERE id = :id AND ") +
                    kLive,
                {{"now", now}, {"id", id}});
    const auto job = FindJob(tx, id);
    if (!job) return NotYours();
    if (cancelled == 1) return *job;
    return core::Refuse("job_ended");
  });
}

core::Result<JobStore::Batch> JobStore::BatchOf(const std::string& batch) {
  return database_.Read([&](Transaction& tx) -> core::Result<Batch> {
    const auto first = SelectRow<Job>(
        tx, "job WHERE batch = :batch ORDER BY created_ms, id LIMIT 1", {{"batch", batch}});
    if (!first) return NotYours();
    Batch out{first->owner, first->name, first->created_at, {}, {}};
    for (const StateCount& each : SelectRows<StateCount>(
             tx,
             "(SELECT state, COUNT(*) AS jobs, MAX(ended_ms) AS last_ms FROM job WHERE batch = "
             ":batch GROUP BY state) AS of_batch",
             {{"batch", batch}})) {
      out.count[each.state] = each.jobs;
      if (each.last) out.ended_at = std::max(each.last, out.ended_at);
    }
    if (out.count.contains("waiting") || out.count.contains("running")) out.ended_at.reset();
    return out;
  });
}

core::Result<std::vector<Job>> JobStore::CancelBatch(const std::string& batch, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    // First the change: what is claimed meanwhile is read as it became.
    Execute(tx,
            std::string("UPDATE job SET state = 'cancelled', ended_ms = :now, body = '', "
                        "body_bytes = 0 WHERE batch = :batch AND ") +
                kLive,
            {{"now", now}, {"batch", batch}});
    return SelectRows<Job>(tx,
                           "job WHERE batch = :batch AND state = 'cancelled' AND ended_ms = :now",
                           {{"batch", batch}, {"now", now}});
  });
}

core::Result<int> JobStore::Reap(WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const auto failed =
        Execute(tx,
                std::string("UPDATE job SET state = 'failed', ended_ms = :now, body = '', "
                            "body_bytes = 0, "
                            "error = 'the server died three times on this job' WHERE "
                            "state = 'running' AND attempts >= :most AND ") +
                    kNoMembership,
                {{"now", now}, {"most", kAttemptsMax}});
    const auto waiting =
        Execute(tx,
                std::string("UPDATE job SET state = 'waiting', server_id = '', boot = '', "
                            "started_ms = 0, run_id = '' WHERE state = 'running' AND ") +
                    kNoMembership);
    return static_cast<int>(failed + waiting);
  });
}

}  // namespace faultlab::server
