#include "server/privacy/retention.h"

#include <chrono>
#include <set>

#include "server/lab/rig_use.h"
#include "server/storage/picture_store.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

constexpr int kTurnMax = 10'000;
/// The reports of a year, and some days.
constexpr auto kUseKept = std::chrono::hours(24 * 400);
/// Benches that nothing names, as of agents that were tried once. Who is about to name one has
/// renewed it within a day (Benches::Keep).
constexpr int kUnnamedBenchDays = 40;
constexpr const char* kUnnamedBench =
    "bench WHERE since_ms < :before AND id NOT IN (SELECT bench FROM rig_bench) "
    "AND id NOT IN (SELECT bench FROM recording) AND id NOT IN (SELECT bench FROM rig_calibration)";

/// Excludes recordings that are still needed.
constexpr const char* kNotInUse =
    " AND r.state <> 'running' "
    "AND NOT EXISTS (SELECT 1 FROM job w WHERE w.state IN ('waiting', 'running') "
    "AND (w.run_id = r.id OR w.body LIKE '%' || r.id || '%')) "
    "AND NOT EXISTS (SELECT 1 FROM recording p WHERE p.state = 'running' "
    "AND p.plan_json LIKE '%' || r.id || '%')";

WallTime Before(WallTime now, int days) {
  return now - std::chrono::hours(24) * days;
}

class Search {
 public:
  Search(Transaction& tx, RetentionReport& report) : tx_(tx), report_(report) {}

  /// `query` selects id, owner, created_ms and has the one parameter :before.
  void Add(const char* kind, const char* rule, const std::string& query, WallTime before) {
    for (const auto& [id, owner, created] : SelectTuples<std::string, std::string, WallTime>(
             tx_,
             query + " ORDER BY 3, 1 LIMIT :most",
             {{"before", before}, {"most", kTurnMax - static_cast<int>(report_.items.size())}})) {
      if (seen_.insert(id).second) report_.items.push_back({kind, id, owner, rule, created});
    }
  }

 private:
  Transaction& tx_;
  RetentionReport& report_;
  std::set<std::string> seen_;
};

void Find(Transaction& tx, const RetentionRules& rules, WallTime now, RetentionReport& report) {
  const std::string recordings = "SELECT r.id, r.owner, r.created_ms FROM recording r WHERE ";
  Search search(tx, report);
  if (rules.guest_days > 0) {
    search.Add("recording",
               "guest_days",
               recordings + "r.owner = 'guest' AND r.created_ms < :before" + kNotInUse,
               Before(now, rules.guest_days));
  }
  if (rules.student_days > 0) {
    // Recordings of students whose courses have all ended, the last one before :before.
    search.Add("recording",
               "student_days",
               recordings +
                   "r.owner IN (SELECT 'user:' || a.id FROM account a "
                   "JOIN enrolment e ON e.account_id = a.id JOIN course c ON c.id = e.course_id "
                   "WHERE a.role = 'student' GROUP BY a.id "
                   "HAVING MIN(c.ends_ms) > 0 AND MAX(c.ends_ms) < :before)" +
                   kNotInUse,
               Before(now, rules.student_days));
  }
  if (rules.job_days > 0) {
    const std::string over =
        "j.state IN ('finished', 'failed', 'cancelled') AND j.ended_ms < :before";
    search.Add("recording",
               "job_days",
               "SELECT r.id, r.owner, r.created_ms FROM recording r "
               "JOIN job j ON j.run_id = r.id WHERE " +
                   over + kNotInUse,
               Before(now, rules.job_days));
    search.Add("job",
               "job_days",
               "SELECT j.id, j.owner, j.created_ms FROM job j WHERE " + over,
               Before(now, rules.job_days));
  }
}

void Remove(Transaction& tx, const Expired& item) {
  if (item.kind == "job") {
    DeleteFrom(tx, "job", {{"id", item.id}});
    return;
  }
  EraseRecordingBlobs(tx, item.id);
  DeleteFrom(tx, "recording_event", {{"recording_id", item.id}});
  DeleteFrom(tx, "recording", {{"id", item.id}});
}

/// Rows that only have an age: counts them, and deletes them if `remove` is set.
std::int64_t Sweep(Transaction& tx,
                   const std::string& table_and_condition,
                   WallTime before,
                   bool remove) {
  const std::int64_t count = CountRows(tx, table_and_condition, {{"before", before}});
  if (remove && count > 0) {
    Execute(tx, "DELETE FROM " + table_and_condition, {{"before", before}});
  }
  return count;
}

}  // namespace

core::Result<RetentionReport> Retain(Database& database,
                                     const RetentionRules& rules,
                                     WallTime now,
                                     bool remove) {
  using Outcome = core::Result<RetentionReport>;
  const auto body = [&](Transaction& tx) -> Outcome {
    RetentionReport report;
    Find(tx, rules, now, report);
    if (remove) {
      for (const Expired& item : report.items) Remove(tx, item);
    }
    if (rules.news_days > 0) {
      const WallTime before = Before(now, rules.news_days);
      report.news = Sweep(tx, "lab_event WHERE at_ms < :before", before, remove);
      report.stale = Sweep(tx, "one_time_link WHERE expires_ms < :before", before, remove) +
                     Sweep(tx, "sign_in WHERE expires_ms < :before", before, remove);
    }
    report.benches = Sweep(tx, kUnnamedBench, Before(now, kUnnamedBenchDays), remove);
    if (remove) lab::rig_use::Forget(tx, now - kUseKept);
    const bool any =
        !report.items.empty() || report.news > 0 || report.stale > 0 || report.benches > 0;
    if (remove && any) {
      const std::string detail = std::to_string(report.items.size()) + " recordings and jobs, " +
                                 std::to_string(report.news) + " news, " +
                                 std::to_string(report.stale) + " links and sign-ins, " +
                                 std::to_string(report.benches) + " benches that nothing names";
      InsertInto(tx,
                 "audit_log",
                 {{"at_ms", now},
                  {"actor", "system"},
                  {"verb", "retention"},
                  {"object", "database"},
                  {"detail", detail}});
    }
    return report;
  };
  return remove ? database.Write(Durability::kPromise, body) : database.Read(body);
}

}  // namespace faultlab::server
