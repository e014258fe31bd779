#include "server/lab/rig_use.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/lab/lab_service.h"
#include "tests/server/lab/lab_fixture.h"
#include "tests/server/lab/waiting_bench.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab::rig_use {
namespace {

constexpr WallTime kEnd{std::chrono::milliseconds{1'800'000'000'000}};

TEST(SumHours, CutsAtTheDaysAndAtNow) {
  const std::vector<Line> lines = {{kEnd - hours(60), Use::kIdle},
                                   {kEnd - hours(26), Use::kPeople},
                                   {kEnd - hours(23), Use::kChecks},
                                   {kEnd - hours(22), Use::kJobs}};
  const auto days = SumHours(lines, kEnd, 2, kEnd - hours(20));
  ASSERT_EQ(days.size(), 2u);
  EXPECT_EQ(days[0].idle, hours(22));
  EXPECT_EQ(days[0].people, hours(2));
  EXPECT_EQ(days[1].people, hours(1));
  EXPECT_EQ(days[1].checks, hours(1));
  EXPECT_EQ(days[1].jobs, hours(2)) << "what lies ahead is not counted";
  EXPECT_EQ(days[1].idle, hours(0));
}

class RigUseTest : public testing::TestWithParam<Engine> {
 protected:
  std::vector<Hours> Days(int days) {
    return HoursOf(*database_, "bench-1", clock_.Wall(), days, clock_.Wall()).value();
  }
  /// Passes in steps: a longer one would be a time without any server.
  void Pass(LabService& service, seconds time) {
    for (seconds passed{0}; passed < time; passed += seconds(1)) {
      clock_.Advance(seconds(1));
      ASSERT_TRUE(service.TickNow().ok());
    }
  }

  tests::TestDatabase database_{GetParam()};
  ManualClock clock_;
  WaitingBench bench_;
};

TEST_P(RigUseTest, CountsChecksPeopleIdleAndTheTimeWithoutServer) {
  LabServiceOptions options;
  options.tick = hours(1);
  auto service = std::move(LabService::Open(*database_, clock_, bench_, options)).value();
  ASSERT_TRUE(service
                  ->Do([](Scheduler& lab, WallTime now) -> core::Status {
                    (void)lab.AddRig("bench-1", "bench", false);
                    return lab.Claim("bench-1", "local", now);
                  })
                  .ok());
  Pass(*service, seconds(20));
  bench_.AwaitChecks(1);
  bench_.PassChecks(*service);
  Pass(*service, seconds(30));
  const auto session = service->Do([](Scheduler& lab, WallTime now) -> core::Result<Session> {
    TicketRequest request;
    request.user = kAnn;
    request.rig_class = "bench";
    const auto ticket = lab.RequestTicket(request, now);
    lab.Tick(now);
    return lab.AcceptTicket(std::get<Ticket>(ticket.value()).id, kAnn, now);
  });
  ASSERT_TRUE(session.ok()) << session.error().message;
  Pass(*service, seconds(40));
  service.reset();
  clock_.Advance(seconds(100));
  service = std::move(LabService::Open(*database_, clock_, bench_, options)).value();
  Pass(*service, seconds(5));
  const Hours sum = Days(1).at(0);
  EXPECT_EQ(sum.idle, seconds(30));
  EXPECT_EQ(sum.people.count() + sum.checks.count(), 1000 * (20 + 40 + 5))
      << "the session goes on after the restart, or its rig is checked";
  EXPECT_GE(sum.people, seconds(40));
  EXPECT_EQ(sum.out, seconds(100));
}

TEST_P(RigUseTest, ForgetsNothingThatTheTimeSinceThenNeeds) {
  ASSERT_TRUE(
      database_
          ->Write(Durability::kPromise,
                  [&](Transaction& tx) -> core::Status {
                    for (const char* line :
                         {"1000, 'idle'", "2000, 'people'", "3000, 'idle'", "9000, 'people'"}) {
                      tx.sql() << std::string(
                                      "INSERT INTO rig_use (rig, at_ms, what) "
                                      "VALUES ('bench-1', ") +
                                      line + ")";
                    }
                    Forget(tx, FromMilliseconds(5000));
                    return core::Done{};
                  })
          .ok());
  std::vector<std::int64_t> left;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    const soci::rowset<long long> rows =
                        (tx.sql().prepare << "SELECT at_ms FROM rig_use ORDER BY at_ms");
                    left.assign(rows.begin(), rows.end());
                    return core::Done{};
                  })
                  .ok());
  EXPECT_THAT(left, testing::ElementsAre(3000, 9000));
}

INSTANTIATE_TEST_SUITE_P(Engines, RigUseTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab::rig_use
