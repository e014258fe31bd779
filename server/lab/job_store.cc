#include "server/lab/job_store.h"

#include <soci/soci.h>

#include "server/storage/turns.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr const char* kColumns =
    "id, owner, account_id, batch, name, run_name, rig, recording, state, run_id, error, result, "
    "created_ms, started_ms, ended_ms, attempts, server_id";

struct Row {
  Job job;
  std::int64_t created_ms = 0;
  std::int64_t started_ms = 0;
  std::int64_t ended_ms = 0;

  void BindInto(soci::statement& statement) {
    statement.exchange(into(job.id));
    statement.exchange(into(job.owner));
    statement.exchange(into(job.account_id));
    statement.exchange(into(job.batch));
    statement.exchange(into(job.name));
    statement.exchange(into(job.run_name));
    statement.exchange(into(job.rig));
    statement.exchange(into(job.recording));
    statement.exchange(into(job.state));
    statement.exchange(into(job.run_id));
    statement.exchange(into(job.error));
    statement.exchange(into(job.result));
    statement.exchange(into(created_ms));
    statement.exchange(into(started_ms));
    statement.exchange(into(ended_ms));
    statement.exchange(into(job.attempts));
    statement.exchange(into(job.server_id));
  }
  Job ToJob() const {
    Job out = job;
    out.created_at = FromMilliseconds(created_ms);
    if (started_ms != 0) out.started_at = FromMilliseconds(started_ms);
    if (ended_ms != 0) out.ended_at = FromMilliseconds(ended_ms);
    return out;
  }
};

std::optional<Job> FindJob(Transaction& tx, const std::string& id) {
  Row row;
  soci::statement statement(tx.sql());
  row.BindInto(statement);
  statement.exchange(use(id, "id"));
  statement.alloc();
  statement.prepare(std::string("SELECT ") + kColumns + " FROM job WHERE id = :id");
  statement.define_and_bind();
  if (!statement.execute(true)) return std::nullopt;
  return row.ToJob();
}

constexpr const char* kLive = "state IN ('waiting', 'running')";

std::int64_t BodyBytes(Transaction& tx, const std::string& owner) {
  std::int64_t bytes = 0;
  tx.sql() << std::string(
                  "SELECT CAST(COALESCE(SUM(body_bytes), 0) AS BIGINT) FROM job "
                  "WHERE owner = :owner AND ") +
                  kLive,
      into(bytes), use(owner, "owner");
  return bytes;
}

core::Status CheckRoom(Transaction& tx, const std::string& owner, const std::vector<Job>& jobs) {
  std::int64_t waiting = 0;
  tx.sql() << "SELECT COUNT(*) FROM job WHERE owner = :owner AND state = 'waiting'", into(waiting),
      use(owner, "owner");
  if (waiting + static_cast<std::int64_t>(jobs.size()) > JobStore::kWaitingMax) {
    return Error{ErrorCode::kTooMany, "your quota of 1000 waiting jobs is used; wait for some", ""};
  }
  const std::int64_t kept = BodyBytes(tx, owner);
  std::int64_t bytes = kept;
  for (const Job& job : jobs) bytes += static_cast<std::int64_t>(job.body.size());
  if (bytes <= JobStore::kBodyBytesMax) return Done{};
  const std::string most = std::to_string(JobStore::kBodyBytesMax);
  return Error{ErrorCode::kConflict,
               "The jobs that wait hold " + std::to_string(kept) + " bytes, these would make " +
                   std::to_string(bytes) + " of " + most +
                   "; send fewer at a time, wait for some or cancel them.",
               "",
               "jobs_full",
               {{"kept", std::to_string(kept)}, {"most", most}}};
}

/// An owner who submits and cancels jobs for hours would fill the database.
void DropOldIdle(Transaction& tx, const std::string& owner) {
  const int kept = JobStore::kIdleKept;
  tx.sql() << "DELETE FROM job WHERE id IN (SELECT id FROM job WHERE owner = :owner AND state IN "
              "('cancelled', 'failed') AND run_id = '' ORDER BY ended_ms DESC, id DESC "
              "LIMIT 1000000 OFFSET :kept)",
      use(owner, "owner"), use(kept, "kept");
}

Error NoJob() {
  return {ErrorCode::kNotFound, "no such thing, or not yours to see", ""};
}

}  // namespace

template <typename Bind>
core::Status JobStore::Change(const Job& claimed,
                              Durability durability,
                              const char* columns,
                              const Bind& bind) {
  return database_.Write(durability, [&](Transaction& tx) -> core::Status {
    soci::statement statement(tx.sql());
    bind(statement);
    statement.exchange(use(claimed.id, "id"));
    statement.exchange(use(claimed.server_id, "server"));
    statement.exchange(use(claimed.attempts, "attempt"));
    statement.alloc();
    statement.prepare(std::string("UPDATE job SET ") + columns +
                      " WHERE id = :id AND server_id = :server AND attempts = :attempt AND "
                      "state = 'running'");
    statement.define_and_bind();
    statement.execute(true);
    if (statement.get_affected_rows() == 1) return Done{};
    return Error{ErrorCode::kStale, "this claim of the job is over", ""};
  });
}

core::Status JobStore::Add(const std::vector<Job>& jobs) {
  if (jobs.empty()) return Error{ErrorCode::kInvalid, "no runs", "/runs"};
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::string& owner = jobs.front().owner;
    TakeTurn(tx, "jobs of " + owner);
    if (const auto room = CheckRoom(tx, owner, jobs); !room.ok()) return room;
    DropOldIdle(tx, owner);
    for (const Job& job : jobs) {
      const auto bytes = static_cast<std::int64_t>(job.body.size());
      const std::int64_t created_ms = ToMilliseconds(job.created_at);
      tx.sql()
          << "INSERT INTO job (id, owner, account_id, batch, name, body, body_bytes, run_name, "
             "rig, "
             "recording, state, run_id, error, created_ms, started_ms, ended_ms, server_id, "
             "lease_until_ms, attempts) VALUES (:id, :owner, :account, :batch, :name, :body, "
             ":bytes, :run_name, :rig, :recording, 'waiting', '', '', :created, 0, 0, '', 0, 0)",
          use(job.id, "id"), use(job.owner, "owner"), use(job.account_id, "account"),
          use(job.batch, "batch"), use(job.name, "name"), use(job.body, "body"),
          use(bytes, "bytes"), use(job.run_name, "run_name"), use(job.rig, "rig"),
          use(job.recording, "recording"), use(created_ms, "created");
    }
    return Done{};
  });
}

core::Result<Job> JobStore::Get(const std::string& id) {
  return database_.Read([&](Transaction& tx) -> core::Result<Job> {
    const auto job = FindJob(tx, id);
    if (!job) return NoJob();
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
    Row row;
    soci::statement statement(tx.sql());
    row.BindInto(statement);
    std::string query = std::string("SELECT ") + kColumns + " FROM job WHERE 1 = 1";
    if (!owner.empty()) {
      query += " AND owner = :owner";
      statement.exchange(use(owner, "owner"));
    }
    if (!batch.empty()) {
      query += " AND batch = :batch";
      statement.exchange(use(batch, "batch"));
    }
    if (!before_id.empty()) {
      query += " AND (created_ms < :before OR (created_ms = :same AND id < :id))";
      statement.exchange(use(before_ms, "before"));
      statement.exchange(use(before_ms, "same"));
      statement.exchange(use(before_id, "id"));
    }
    statement.exchange(use(limit, "count"));
    statement.alloc();
    statement.prepare(query + " ORDER BY created_ms DESC, id DESC LIMIT :count");
    statement.define_and_bind();
    statement.execute(false);
    Jobs out;
    while (statement.fetch()) out.push_back(row.ToJob());
    return out;
  });
}

core::Result<std::optional<Job>> JobStore::Claim(const std::string& server_id,
                                                 WallTime now,
                                                 WallTime lease_until) {
  using MaybeJob = std::optional<Job>;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<MaybeJob> {
    std::string id;
    std::string query =
        "SELECT id FROM job j WHERE state = 'waiting' AND "
        "(lease_until_ms <= :now OR server_id = :server) ORDER BY "
        "(SELECT COUNT(*) FROM job r WHERE r.owner = j.owner AND r.state = 'running'), "
        "created_ms, id LIMIT 1";
    const std::int64_t now_ms = ToMilliseconds(now);
    if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE OF j SKIP LOCKED";
    tx.sql() << query, into(id), use(now_ms, "now"), use(server_id, "server");
    if (!tx.sql().got_data()) return MaybeJob{};
    const std::int64_t lease_ms = ToMilliseconds(lease_until);
    tx.sql() << "UPDATE job SET state = 'running', server_id = :server, started_ms = :now, "
                "lease_until_ms = :lease, attempts = attempts + 1 WHERE id = :id",
        use(server_id, "server"), use(now_ms, "now"), use(lease_ms, "lease"), use(id, "id");
    MaybeJob job = FindJob(tx, id);
    tx.sql() << "SELECT body FROM job WHERE id = :id", into(job->body), use(id, "id");
    return job;
  });
}

core::Status JobStore::Renew(const Job& claimed, WallTime lease_until) {
  const std::int64_t lease_ms = ToMilliseconds(lease_until);
  return Change(claimed, Durability::kTelemetry, "lease_until_ms = :lease", [&](auto& statement) {
    statement.exchange(use(lease_ms, "lease"));
  });
}

core::Status JobStore::SetRun(const Job& claimed, const std::string& run_id) {
  return Change(claimed, Durability::kPromise, "run_id = :run", [&](auto& statement) {
    statement.exchange(use(run_id, "run"));
  });
}

core::Status JobStore::SetResult(const Job& claimed, const std::string& result) {
  return Change(claimed, Durability::kPromise, "result = :result", [&](auto& statement) {
    statement.exchange(use(result, "result"));
  });
}

core::Status JobStore::Finish(const Job& claimed,
                              const std::string& state,
                              const std::string& error,
                              WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  const char* columns =
      "state = :state, error = :error, ended_ms = :now, body = '', body_bytes = 0";
  return Change(claimed, Durability::kPromise, columns, [&](auto& statement) {
    statement.exchange(use(state, "state"));
    statement.exchange(use(error, "error"));
    statement.exchange(use(now_ms, "now"));
  });
}

core::Status JobStore::GiveBack(const Job& claimed, WallTime not_before) {
  const std::int64_t wait_ms = ToMilliseconds(not_before);
  const char* columns =
      "state = 'waiting', server_id = '', started_ms = 0, lease_until_ms = :wait, "
      "attempts = attempts - 1";
  return Change(claimed, Durability::kPromise, columns, [&](auto& statement) {
    statement.exchange(use(wait_ms, "wait"));
  });
}

core::Status JobStore::HandTo(const Job& claimed, const std::string& server_id, WallTime until) {
  const std::int64_t until_ms = ToMilliseconds(until);
  const char* columns =
      "state = 'waiting', server_id = :next, started_ms = 0, lease_until_ms = :until, "
      "attempts = attempts - 1";
  return Change(claimed, Durability::kPromise, columns, [&](auto& statement) {
    statement.exchange(use(server_id, "next"));
    statement.exchange(use(until_ms, "until"));
  });
}

core::Status JobStore::Cancel(const std::string& id, WallTime now) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::int64_t now_ms = ToMilliseconds(now);
    soci::statement change =
        (tx.sql().prepare << "UPDATE job SET state = 'cancelled', ended_ms = :now, "
                             "body = '', body_bytes = 0 WHERE id = :id AND state = 'waiting'",
         use(now_ms, "now"),
         use(id, "id"));
    change.execute(true);
    if (change.get_affected_rows() == 1) return Done{};
    if (!FindJob(tx, id)) return NoJob();
    return Error{ErrorCode::kConflict, "the job has begun; stop its run instead", ""};
  });
}

core::Result<int> JobStore::Reap(WallTime now, const std::string& own_server_id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<int> {
    const std::int64_t now_ms = ToMilliseconds(now);
    soci::statement failed =
        (tx.sql().prepare << "UPDATE job SET state = 'failed', ended_ms = :now, body = '', "
                             "body_bytes = 0, "
                             "error = 'the server died three times on this job' WHERE "
                             "state = 'running' AND attempts >= :most AND "
                             "(lease_until_ms < :limit OR server_id = :server)",
         use(now_ms, "now"),
         use(kAttemptsMax, "most"),
         use(now_ms, "limit"),
         use(own_server_id, "server"));
    failed.execute(true);
    soci::statement again =
        (tx.sql().prepare << "UPDATE job SET state = 'waiting', started_ms = 0, "
                             "lease_until_ms = 0 WHERE "
                             "state = 'running' AND (lease_until_ms < :limit OR "
                             "server_id = :server)",
         use(now_ms, "limit"),
         use(own_server_id, "server"));
    again.execute(true);
    return static_cast<int>(failed.get_affected_rows() + again.get_affected_rows());
  });
}

}  // namespace faultlab::server::lab
