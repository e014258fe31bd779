// A process with the real service on a real disk is killed with SIGKILL right before and right
// after every single commit of a scripted day (crash_day.h), which contains every transition of the
// state machines. Everything that was answered must be stored, nothing may be stored partly, and
// the day must continue to the same end.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <set>
#include <vector>

#include "server/lab/fair_order.h"
#include "server/lab/lab_store.h"
#include "tests/server/lab/crash_day.h"
#include "tests/server/lab/table_dump.h"
#include "tests/support/engines.h"
#include "tests/support/scale.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using tests::CrashDay;
using tests::Progress;
using tests::TableDump;

constexpr int kNever = 0;

/// Where a process is killed: at the n-th commit, counted from 1.
struct Kill {
  int commit = kNever;
  CommitMoment moment = CommitMoment::kBefore;
};

/// Written by a process that will be killed, read by the test.
class ProgressFile {
 public:
  explicit ProgressFile(const std::string& path)
      : fd_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    Write({});
  }
  ~ProgressFile() { close(fd_); }
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;
  void Write(Progress progress) const {
    if (pwrite(fd_, &progress, sizeof progress, 0) != sizeof progress) std::terminate();
  }
  Progress Read() const {
    Progress progress;
    EXPECT_EQ(pread(fd_, &progress, sizeof progress, 0), static_cast<ssize_t>(sizeof progress));
    return progress;
  }

 private:
  int fd_;
};

/// Runs the day from `from` in a child process, until its end (true) or the kill (false).
bool Live(const DatabaseOptions& where, Progress from, Kill kill_at, const ProgressFile& file) {
  const pid_t child = fork();
  if (child == 0) {
    int commits = 0;
    DatabaseOptions options = where;
    options.at_commit = [&](CommitMoment moment) {
      if (moment == CommitMoment::kBefore) ++commits;
      if (commits == kill_at.commit && moment == kill_at.moment) kill(getpid(), SIGKILL);
    };
    try {
      auto database = Database::Open(options).value();
      CrashDay day(*database, from, [&](Progress progress) { file.Write(progress); });
      if (from.step != 0) day.PassChecks();
      for (int step = from.step; step < CrashDay::steps(); ++step) day.Run(step);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  const bool done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  EXPECT_TRUE(killed || done) << "commit " << kill_at.commit;
  return done;
}

LabState StateOf(Database& database) {
  LabState state;
  EXPECT_TRUE(database
                  .Read([&](Transaction& tx) -> core::Status {
                    state = lab_store::Load(tx);
                    return core::Done{};
                  })
                  .ok());
  return state;
}

/// The results of the day, without the numbers that a restart may change.
std::vector<std::string> Outcome(const TableDump& dump) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& key, const std::string& value) {
    out.push_back(key.substr(0, key.find(' ')) + " " + value);
  };
  for (const auto& [key, row] : dump) {
    if (key.starts_with("lab_ticket ")) add(key, row.at("user_id") + ":" + row.at("state"));
    if (key.starts_with("lab_booking ")) add(key, row.at("user_id") + ":" + row.at("state"));
    if (key.starts_with("lab_rig ")) add(key, key + ":" + row.at("status"));
    if (key.starts_with("job ")) add(key, key + ":" + row.at("state"));
    if (key.starts_with("lab_outage ")) add(key, key);
    if (key.starts_with("lab_session ") && row.at("state") != "2") add(key, key + " lives");
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// Checks the restart itself: the order of the queue, the leases, increasing epochs, cut runs.
void CheckRestart(const LabState& before, const LabState& after, Database& database, WallTime now) {
  const TableDump dump = tests::DumpTables(database);
  EXPECT_EQ(FindBrokenInvariant(after), "");
  for (const char* rig_class : {"bench", "sim"}) {
    std::vector<TicketId> order;
    for (const TicketId id : QueueOrder(before, rig_class, now, Policy{})) {
      const auto still = after.tickets.find(id);
      const bool waits =
          still != after.tickets.end() && still->second.state == TicketState::kWaiting;
      if (waits) order.push_back(id);
    }
    std::vector<TicketId> kept = QueueOrder(after, rig_class, now, Policy{});
    std::erase_if(
        kept, [&](TicketId id) { return before.tickets.at(id).state != TicketState::kWaiting; });
    EXPECT_EQ(order, kept) << rig_class;
  }
  for (const auto& [id, rig] : before.rigs) {
    const Rig& now_rig = after.rigs.at(id);
    const bool was_free = rig.status == RigStatus::kReady || rig.status == RigStatus::kCleaning;
    EXPECT_GE(now_rig.epoch, rig.epoch + (was_free ? 1 : 0)) << id << " is checked anew";
    if (rig.elastic) continue;  // built anew for each lease
    EXPECT_NE(now_rig.status, RigStatus::kReady) << id << " is not handed on unchecked";
  }
  for (const auto& [id, session] : before.sessions) {
    const auto still = after.sessions.find(id);
    if (still != after.sessions.end()) {
      EXPECT_EQ(still->second.user, session.user);
      EXPECT_EQ(still->second.epoch, session.epoch);
      EXPECT_FALSE(still->second.run_in_progress);
      EXPECT_TRUE(!session.run_in_progress || still->second.charged_from == now) << "charged back";
      continue;
    }
    // A transition that was due at this second may have happened now.
    const int reason =
        std::stoi(dump.at("lab_session " + std::to_string(Number(id))).at("end_reason"));
    const std::set<EndReason> by_time = {EndReason::kExpired, EndReason::kIdle};
    const bool was_held = session.state == SessionState::kHeld;
    const auto why = static_cast<EndReason>(reason);
    EXPECT_TRUE(was_held ? why == EndReason::kRigFailed : by_time.contains(why)) << reason;
  }
  for (const auto& [key, row] : dump) {
    const bool is_job = key.starts_with("job ");
    if (is_job || key.starts_with("recording ")) {
      EXPECT_NE(row.at("state"), "running") << key;
    }
    if (is_job) {
      EXPECT_LE(std::stoi(row.at("attempts")), JobStore::kAttemptsMax) << key;
    }
  }
}

class CrashEverywhere : public testing::TestWithParam<Engine> {
 protected:
  /// The dump after a day from the morning that is killed at `kill_at`.
  TableDump DumpAfter(Kill kill_at) {
    tests::TestDatabase database{GetParam()};
    const ProgressFile file(database.folder().File("progress"));
    done_ = Live(database.options(), {}, kill_at, file);
    return tests::DumpTables(*database);
  }
  void KillAndLiveOn(Kill kill_at) {
    try {
      KillRestartAndLiveOn(kill_at);
    } catch (const std::exception& error) {
      ADD_FAILURE() << "commit " << kill_at.commit << ": " << error.what();
    }
  }
  /// Kills, restarts, checks the restart, continues to the end.
  void KillRestartAndLiveOn(Kill kill_at) {
    SCOPED_TRACE("killed " +
                 std::string(kill_at.moment == CommitMoment::kBefore ? "before" : "after") +
                 " commit " + std::to_string(kill_at.commit));
    tests::TestDatabase database{GetParam()};
    const ProgressFile file(database.folder().File("progress"));
    done_ = Live(database.options(), {}, kill_at, file);
    left_ = tests::DumpTables(*database);
    if (done_) return;
    EXPECT_TRUE(database->Check().ok());
    Progress reached = file.Read();
    SCOPED_TRACE("in step: " + CrashDay::NameOf(reached.step));
    // Every third process is killed again during its recovery.
    if (kill_at.commit % 3 == 0) {
      const int commit = 1 + kill_at.commit % 5;
      EXPECT_FALSE(Live(database.options(), reached, {commit, kill_at.moment}, file) &&
                   reached.step + 8 < CrashDay::steps());
      reached = file.Read();
    }
    const LabState before = StateOf(*database);
    EXPECT_EQ(FindBrokenInvariant(before), "");
    CrashDay day(*database, reached, [](Progress) {});
    CheckRestart(before, StateOf(*database), *database, day.service().Now());
    day.PassChecks();
    for (int step = reached.step; step < CrashDay::steps(); ++step) day.Run(step);
    EXPECT_EQ(Outcome(tests::DumpTables(*database)), outcome_);
  }

  bool done_ = false;
  TableDump left_;
  std::vector<std::string> outcome_;
};

TEST_P(CrashEverywhere, TheDayPassesEveryTransition) {
  tests::TestDatabase database{GetParam()};
  std::set<std::string> seen;
  TableDump last;
  const auto look = [&] {
    TableDump now = tests::DumpTables(*database);
    for (const auto& [key, row] : now) {
      const std::string table = key.substr(0, key.find(' '));
      for (const char* column : {"status", "state", "end_reason", "warning_stage"}) {
        if (!row.contains(column)) continue;
        const auto before = last.find(key);
        const std::string from = before == last.end() ? "" : before->second.at(column);
        if (from != row.at(column)) {
          seen.insert(table + "." + column + " " + from + ">" + row.at(column));
        }
      }
    }
    last = std::move(now);
  };
  CrashDay day(*database, {}, [](Progress) {});
  for (int step = 0; step < CrashDay::steps(); ++step) {
    day.Run(step);
    look();
  }
  // The enumerators of lab_types.h as numbers; "" is the creation of a row.
  const std::vector<std::string> wanted = {
      // rig: 0 offline, 1 ready, 2 leased, 3 cleaning, 4 quarantined, 5 maintenance
      "lab_rig.status >3",
      "lab_rig.status 3>1",
      "lab_rig.status 1>2",
      "lab_rig.status 3>2",
      "lab_rig.status 2>3",
      "lab_rig.status 2>1",
      "lab_rig.status 2>4",
      "lab_rig.status 4>3",
      "lab_rig.status 1>4",
      "lab_rig.status 1>0",
      "lab_rig.status 0>3",
      "lab_rig.status 1>5",
      "lab_rig.status 5>3",
      // ticket: 0 waiting, 1 offered, 2 claimed, 3 expired, 4 left
      "lab_ticket.state >0",
      "lab_ticket.state >1",
      "lab_ticket.state >2",
      "lab_ticket.state 0>1",
      "lab_ticket.state 1>2",
      "lab_ticket.state 1>3",
      "lab_ticket.state 1>4",
      // booking: 0 booked, 1 held, 2 claimed, 3 no-show, 4 cancelled, 5 unfulfilled, 6 done, 7
      // waiting
      "lab_booking.state >0",
      "lab_booking.state 0>1",
      "lab_booking.state 1>2",
      "lab_booking.state 1>3",
      "lab_booking.state 0>4",
      "lab_booking.state 0>5",
      "lab_booking.state >7",
      "lab_booking.state 7>0",
      "lab_booking.state 7>4",
      "lab_booking.state 2>6",
      // session: 0 held, 1 active, 2 closed; then the reason of its end, and the stage of its
      // warning
      "lab_session.state >0",
      "lab_session.state 0>1",
      "lab_session.state 1>2",
      "lab_session.state 0>2",
      "lab_session.end_reason 0>1",
      "lab_session.end_reason 0>2",
      "lab_session.end_reason 0>3",
      "lab_session.end_reason 0>4",
      "lab_session.end_reason 0>5",
      "lab_session.end_reason 0>6",
      "lab_session.warning_stage 0>1",
      "lab_session.warning_stage 1>2",
      "lab_session.warning_stage 2>3",
      "job.state >waiting",
      "job.state waiting>running",
      "job.state running>waiting",
      "job.state waiting>cancelled",
      "job.state waiting>finished",
      "recording.state >running",
      "recording.state running>finished"};
  for (const std::string& transition : wanted) EXPECT_TRUE(seen.contains(transition)) << transition;
}

TEST_P(CrashEverywhere, AKillBeforeOrAfterAnyCommitLosesNothingAndTheDayGoesOnToTheSameEnd) {
  outcome_ = Outcome(DumpAfter({}));
  ASSERT_TRUE(done_);
  ASSERT_EQ(outcome_.size(), 23u) << "8 tickets, 9 bookings, 3 rigs, 3 jobs";
  TableDump after_the_one_before;
  int commits = 0;
  // Making a database of a cluster takes a second: on PostgreSQL only after every `stride` commits
  // and before the next.
  const bool sqlite = GetParam() == Engine::kSqlite;
  const int stride = tests::Proving() ? (sqlite ? 1 : 4) : (sqlite ? 6 : 24);
  for (int commit = 1;; ++commit) {
    commits = commit;
    if (stride == 1 || commit % stride == 1) {
      KillAndLiveOn({commit, CommitMoment::kBefore});
      if (done_) break;
      if (commit > 1) {
        EXPECT_EQ(tests::FirstDifference(left_, after_the_one_before), "")
            << "half of commit " << commit << " is there, or the one before is lost";
      }
    }
    if (stride == 1 || commit % stride == 0) {
      KillAndLiveOn({commit, CommitMoment::kAfter});
      if (done_) break;
      after_the_one_before = left_;
    }
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(commits, CrashDay::steps());
  std::printf("%d commits\n", commits);
}

INSTANTIATE_TEST_SUITE_P(Engines, CrashEverywhere, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
