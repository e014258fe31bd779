// Runs while the database takes nothing: another program holds its lock.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <filesystem>
#include <stdexcept>

#include "server/run/backlog.h"
#include "tests/server/run/run_fixture.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

using tests::FakeRig;
namespace fs = std::filesystem;

/// Until Return, writers are refused as busy.
class TakenDatabase {
 public:
  explicit TakenDatabase(const std::string& path) {
    EXPECT_EQ(sqlite3_open(path.c_str(), &db_), SQLITE_OK);
    EXPECT_EQ(sqlite3_busy_timeout(db_, 5000), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  ~TakenDatabase() { Return(); }
  void Return() { sqlite3_close(std::exchange(db_, nullptr)); }

 private:
  sqlite3* db_ = nullptr;
};

class OutageTest : public tests::RunFixture {
 protected:
  OutageTest() {
    manager_.reset();
    OpenDatabase();
    Manage(1.0);
  }
  void OpenDatabase() {
    DatabaseOptions options;
    options.location = path();
    options.patience = std::chrono::milliseconds(20);
    options.at_commit = [this](CommitMoment moment) {
      if (moment == CommitMoment::kAfter && lose_answer_.exchange(false)) {
        throw std::runtime_error("the answer to this commit is lost");
      }
    };
    store_.reset();
    database_ = std::move(Database::Open(options)).value();
    store_ = std::make_unique<RecordingStore>(*database_);
  }
  std::string path() const { return folder_.File("test.db"); }
  std::vector<std::string> Backlogs() const { return Backlog::RunsIn(folder_.File("backlog")); }
  /// Waits for something that another thread does.
  template <typename Happened>
  static void Await(Happened happened) {
    ASSERT_TRUE(tests::Await(happened));
  }
  /// Says so many samples, each other than all others, and waits until the run has taken them.
  void Say(FakeRig& rig, const std::string& run, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      core::Sample sample = SampleAt(static_cast<std::int64_t>(said_.size()));
      sample.um_v = 4.8 + 1e-6 * static_cast<double>(said_.size());
      said_.push_back(sample);
      rig.Say(sample);
      if (said_.size() % 1000 == 0) AwaitSaid(run);
    }
    AwaitSaid(run);
  }
  void AwaitSaid(const std::string& run) {
    const auto said = static_cast<std::int64_t>(said_.size());
    Await([&] { return manager_->Find(run)->samples > said - 5; });  // 5 are a frame
  }
  /// All that was said is stored, bit for bit.
  void ExpectWhole(const std::string& run) {
    const auto stored = store_->LoadSamples(run);
    ASSERT_TRUE(stored.ok());
    ASSERT_EQ(stored.value().size(), said_.size());
    for (std::size_t i = 0; i < said_.size(); ++i) {
      ASSERT_EQ(stored.value()[i].index, said_[i].index);
      ASSERT_EQ(stored.value()[i].um_v, said_[i].um_v);
    }
    EXPECT_EQ(store_->Get(run).value().samples, static_cast<std::int64_t>(said_.size()));
  }
  static hardware::RigEvent EventOf(hardware::RigEventKind kind, std::int64_t index) {
    hardware::RigEvent event;
    event.kind = kind;
    event.index = index;
    return event;
  }
  /// As the next process does at its start.
  void StartAnew() {
    manager_.reset();
    OpenDatabase();
    const core::Status marked =
        database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
          InterruptRuns(tx, "local", clock_.Wall());
          return core::Done{};
        });
    ASSERT_TRUE(marked.ok());
    Manage(1.0);
    ASSERT_TRUE(manager_->StoreBacklogs().ok());
  }

  std::vector<core::Sample> said_;
  std::atomic<bool> lose_answer_{false};
};

TEST_F(OutageTest, ARecordingGoesOnAndIsWholeAfterwards) {
  auto rig = std::make_shared<FakeRig>();
  const std::string run = manager_->Start(Scripted(rig)).value().id;
  Say(*rig, run, 300);
  TakenDatabase taken(path());
  // Many more chunks than the queue has places, and events between them.
  Say(*rig, run, 5000);
  rig->Say(EventOf(hardware::RigEventKind::kOverrun, 5300));
  Await([&] { return Backlogs() == std::vector<std::string>{run}; });
  Say(*rig, run, 5000);
  EXPECT_EQ(manager_->Find(run)->state, RunState::kRunning) << log_;
  taken.Return();
  Await([&] { return Backlogs().empty(); });
  Say(*rig, run, 300);
  rig->Say(EventOf(hardware::RigEventKind::kFinished, 10'600));
  rig->End();
  manager_->Wait(run);
  ExpectWhole(run);
  EXPECT_EQ(store_->Get(run).value().state, RunState::kFinished) << log_;
  const auto kinds = Kinds(run);
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), "overrun"), 1);
  EXPECT_TRUE(Backlogs().empty());
}

TEST_F(OutageTest, ARunThatEndsMeanwhileIsStoredAsItEnded) {
  auto rig = std::make_shared<FakeRig>();
  const std::string run = manager_->Start(Scripted(rig)).value().id;
  Say(*rig, run, 300);
  TakenDatabase taken(path());
  Say(*rig, run, 1000);
  ASSERT_TRUE(manager_->Stop(run, "stopped by a person").ok());
  Await([&] { return !manager_->Find(run)->on_rig; });
  EXPECT_EQ(manager_->Find(run)->state, RunState::kRunning) << "until its end is stored";
  EXPECT_EQ(store_->Delete(run).error().code, core::ErrorCode::kBusy);
  taken.Return();
  manager_->Wait(run);
  ExpectWhole(run);
  EXPECT_EQ(store_->Get(run).value().state, RunState::kStopped);
  EXPECT_TRUE(Backlogs().empty());
  EXPECT_TRUE(store_->Delete(run).ok()) << "nothing of it lives on";
}

TEST_F(OutageTest, TheNextProcessStoresWhatTheLastOneCouldNot) {
  leave_after_ = std::chrono::milliseconds(0);
  Manage(1.0);
  auto rig = std::make_shared<FakeRig>();
  const std::string run = manager_->Start(Scripted(rig)).value().id;
  Say(*rig, run, 300);
  TakenDatabase taken(path());
  Say(*rig, run, 1000);
  manager_.reset();
  EXPECT_EQ(Backlogs(), std::vector<std::string>{run});
  EXPECT_EQ(store_->Get(run).value().state, RunState::kRunning);
  taken.Return();
  StartAnew();
  ExpectWhole(run);
  EXPECT_EQ(store_->Get(run).value().state, RunState::kStopped) << "as it ended, not interrupted";
  EXPECT_TRUE(Happened(run, "stopped"));
  EXPECT_TRUE(Backlogs().empty());
}

TEST_F(OutageTest, AProcessThatIsKilledLosesNothingOfTheOutage) {
  auto rig = std::make_shared<FakeRig>();
  const std::string run = manager_->Start(Scripted(rig)).value().id;
  Say(*rig, run, 300);
  TakenDatabase taken(path());
  Say(*rig, run, 1000);
  // As it is on the disk at this moment; part of it may be in the database, too.
  const std::string backlog = "/" + run + ".backlog";
  const std::string kept = folder_.File("kept");
  Await([&] { return fs::exists(folder_.File("backlog") + backlog); });
  fs::copy_file(folder_.File("backlog") + backlog, kept);
  taken.Return();
  Await([&] { return Backlogs().empty(); });
  fs::copy_file(kept, folder_.File("backlog") + backlog);
  ASSERT_TRUE(manager_->StoreBacklogs().ok()) << "once more: nothing is stored twice";
  rig->End();
  manager_->Wait(run);
  ExpectWhole(run);
}

TEST_F(OutageTest, ABacklogOfADeletedRunIsDeleted) {
  {
    ASSERT_TRUE(
        Backlog::Open(folder_.File("backlog"), "run-gone").value().Append({.end = RunEnd{}}).ok());
  }
  ASSERT_TRUE(manager_->StoreBacklogs().ok());
  EXPECT_TRUE(Backlogs().empty());
}

TEST_F(OutageTest, ARunWhoseBeginHadNoAnswerDoesNotRemain) {
  lose_answer_ = true;
  const auto refused = manager_->Start(Scripted(std::make_shared<FakeRig>()));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kUnavailable);
  manager_.reset();  // all ends are stored
  const auto page = store_->List("", 10, {});
  ASSERT_TRUE(page.ok());
  ASSERT_EQ(page.value().items.size(), 1u) << "it was stored all the same";
  EXPECT_EQ(page.value().items[0].state, RunState::kFailed);
}

TEST_F(OutageTest, AnEndWhoseAnswerIsLostIsStoredOnce) {
  auto rig = std::make_shared<FakeRig>();
  const std::string run = manager_->Start(Scripted(rig)).value().id;
  Say(*rig, run, 300);
  lose_answer_ = true;  // of the event, or of the end: each is stored once
  ASSERT_TRUE(manager_->Stop(run, "stopped by a person").ok());
  manager_->Wait(run);
  ExpectWhole(run);
  EXPECT_EQ(store_->Get(run).value().state, RunState::kStopped);
  const auto kinds = Kinds(run);
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), "stopped"), 1);
  EXPECT_TRUE(Backlogs().empty());
}

}  // namespace
}  // namespace faultlab::server
