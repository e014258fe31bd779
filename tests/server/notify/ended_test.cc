// What a person's webhook is told of the ends of runs and jobs.
#include <gmock/gmock.h>

#include "server/jobs/job_store.h"
#include "server/notify/news.h"
#include "server/notify/webhooks.h"
#include "server/storage/rows.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::notify {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr WallTime kStart{std::chrono::milliseconds{1'770'033'600'000}};

class Ended : public testing::TestWithParam<Engine> {
 protected:
  Ended() {
    Do([](Transaction& tx) {
      for (const int id : {1, 2}) {
        InsertInto(tx,
                   "account",
                   {{"id", id},
                    {"login", "p" + std::to_string(id)},
                    {"name", "P"},
                    {"role", "student"},
                    {"password_hash", ""},
                    {"disabled", 0},
                    {"created_ms", 0},
                    {"version", 1}});
      }
    });
  }
  void Do(const std::function<void(Transaction&)>& write) {
    EXPECT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              write(tx);
                              return core::Done{};
                            })
                    .ok());
  }
  void AddJob(const std::string& id, const std::string& owner, const std::string& batch) {
    Job job;
    job.id = id;
    job.owner = owner;
    job.batch = batch;
    job.name = "night";
    job.body = "{}";
    job.created_at = kStart;
    ASSERT_TRUE(jobs_.Add({job}).ok());
  }
  std::int64_t AddHook(std::int64_t account, const std::set<Kind>& kinds) {
    return Webhooks(*database_).Add(account, "https://x.example", kinds, kStart).value().id;
  }
  /// "hook:1 job_ended {..}" of all messages since the last call, oldest first.
  std::vector<std::string> Told() {
    EXPECT_TRUE(Gather(*database_, NewsOptions{}, kStart).ok());
    std::vector<std::string> told;
    Do([&](Transaction& tx) {
      for (const auto& [channel, kind, about] : SelectTuples<std::string, std::string, std::string>(
               tx, "SELECT channel, kind, about FROM outbox ORDER BY id")) {
        told.push_back(channel + " " + kind + " " + about);
      }
      Execute(tx, "DELETE FROM outbox");
    });
    return told;
  }
  std::int64_t Noted() {
    std::int64_t count = 0;
    Do([&](Transaction& tx) { count = CountRows(tx, "ended"); });
    return count;
  }

  tests::TestDatabase database_{GetParam()};
  JobStore jobs_{*database_};
};

TEST_P(Ended, IsToldOnceToWhoseItIsAndABatchWithItsLastJob) {
  const std::string hook = HookChannel(AddHook(1, {Kind::kJobEnded, Kind::kBatchEnded}));
  AddHook(0, {Kind::kYourTurn});
  for (const char* id : {"a", "b"}) AddJob(id, "user:1", "night");
  AddJob("c", "user:2", "theirs");
  ASSERT_TRUE(jobs_.Cancel("a", kStart).ok());
  ASSERT_TRUE(jobs_.Cancel("c", kStart).ok());
  const std::string of_a =
      R"( job_ended {"job":"a","batch":"night","name":"night","state":"cancelled","run":""})";
  EXPECT_THAT(Told(), ElementsAre(hook + of_a));
  EXPECT_THAT(Told(), IsEmpty());
  ASSERT_TRUE(jobs_.Cancel("b", kStart).ok());
  EXPECT_THAT(Told(),
              ElementsAre(testing::HasSubstr(R"({"job":"b",)"),
                          hook + R"( batch_ended {"batch":"night","jobs":{"cancelled":2}})"));
}

TEST_P(Ended, ARunIsToldWithoutWhatItHasShown) {
  const std::string hook = HookChannel(AddHook(1, {Kind::kRunEnded}));
  Do([](Transaction& tx) {
    for (const char* owner : {"user:1", "user:2", "guest"}) {
      InsertInto(tx,
                 "recording",
                 {{"id", std::string("run-of-") + owner},
                  {"name", "step"},
                  {"owner", owner},
                  {"rig", "sim-1"},
                  {"source", "run"},
                  {"server_id", "local"},
                  {"epoch", 0},
                  {"period_s", 0.01},
                  {"plan_json", "{}"},
                  {"state", "running"},
                  {"created_ms", kStart},
                  {"samples", 0},
                  {"next_index", 0},
                  {"diagnosis_json", ""},
                  {"verdict", "R1"}});
    }
    Execute(tx, "UPDATE recording SET next_index = 7");
    Execute(tx, "UPDATE recording SET state = 'finished'");
    Execute(tx, "UPDATE recording SET state = 'interrupted'");
  });
  EXPECT_THAT(
      Told(),
      ElementsAre(
          hook +
          R"( run_ended {"run":"run-of-user:1","name":"step","rig":"sim-1","state":"interrupted"})"));
}

TEST_P(Ended, NothingIsNotedForWhoHasNoWebhook) {
  AddHook(0, {Kind::kYourTurn});
  const std::int64_t hook = AddHook(1, {Kind::kJobEnded});
  ASSERT_TRUE(Webhooks(*database_).Remove(hook).ok());
  AddJob("a", "user:1", "night");
  ASSERT_TRUE(jobs_.Cancel("a", kStart).ok());
  EXPECT_EQ(Noted(), 0);
}

TEST_P(Ended, WhoIsShutOutIsToldNothing) {
  AddHook(1, {Kind::kJobEnded});
  AddJob("a", "user:1", "night");
  Do([](Transaction& tx) { UpdateWhere(tx, "account", {{"disabled", 1}}, {{"id", 1}}); });
  ASSERT_TRUE(jobs_.Cancel("a", kStart).ok());
  EXPECT_THAT(Told(), IsEmpty());
  EXPECT_EQ(Noted(), 0);
}

INSTANTIATE_TEST_SUITE_P(Engines, Ended, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::notify
