// Which rigs the lab has: rigs of a class are interchangeable, and one that is not heard for a
// moment keeps its session.
#include "server/upkeep/roll_call.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

#include "hardware/bench/benches.h"
#include "tests/paper_bench.h"
#include "tests/server/upkeep/upkeep_fixture.h"

namespace faultlab::server {
namespace {

using hardware::RigKind;
using std::chrono::seconds;

const core::Bench& Servo() {
  return *hardware::LoadBench("servo-motor").value();
}

class RollCallTest : public UpkeepFixture {
 protected:
  void Come(const std::string& id, const core::Bench& bench, RigKind kind = RigKind::kRemote) {
    RigStatus rig;
    rig.description.id = id;
    rig.description.rig_class = "desks";
    rig.description.kind = kind;
    rig.description.bench = &bench;
    if (kind == RigKind::kRemote) rig.remote.emplace().link = hardware::LinkState::kBack;
    rigs_.push_back(std::move(rig));
  }
  /// Everything is heard or nothing.
  void Hear(bool heard) {
    for (RigStatus& rig : rigs_) {
      rig.remote->link = heard ? hardware::LinkState::kBack : hardware::LinkState::kLost;
      rig.state = heard ? hardware::RigState::kIdle : hardware::RigState::kOffline;
    }
    Look();
  }
  void Look() {
    if (!roll_call_) roll_call_.emplace(*lab_, clock_, [](std::string_view) {});
    roll_call_->Take(rigs_);
  }
  void RestartTheServer() {
    roll_call_.reset();
    RestartTheLab();
  }
  std::string WhyOut(const lab::RigId& id) const {
    const lab::Rig rig = RigNow(id);
    return rig.status == lab::RigStatus::kOffline ? rig.reason : "";
  }
  static std::string BuiltOtherwise(const core::Bench& bench) {
    return "its class desks has rigs built otherwise (" + bench.id +
           "): give its description another rig_class, or update it";
  }
  /// @param accepted  else it is only offered
  void GiveSession(bool accepted) {
    Come("desk", paper::Bench());
    Look();
    ASSERT_TRUE(lab_->CleaningDone("desk", RigNow("desk").epoch, true, "").ok());
    const auto given =
        lab_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
          TRY(const auto ticket,
              scheduler.RequestTicket({.user = kUser, .rig_class = "desks", .job = ""}, now));
          if (!accepted) return lab::Session{};
          return scheduler.AcceptTicket(std::get<lab::Ticket>(ticket).id, kUser, now);
        });
    ASSERT_TRUE(given.ok()) << given.error().message;
    ASSERT_TRUE(IsHeld());
  }
  bool IsHeld() const { return RigNow("desk").status == lab::RigStatus::kLeased; }

  static constexpr lab::UserId kUser{1};
  std::vector<RigStatus> rigs_;
  std::optional<RollCall> roll_call_;
};

TEST_F(RollCallTest, AClassIsBuiltLikeThisServersOwnRigs) {
  Come("a-far", Servo());
  Come("b-far", paper::Bench());
  Come("own", paper::Bench(), RigKind::kBench);
  Look();
  EXPECT_EQ(WhyOut("a-far"), BuiltOtherwise(paper::Bench()));
  EXPECT_EQ(WhyOut("b-far"), "");
  EXPECT_EQ(WhyOut("own"), "");
}

TEST_F(RollCallTest, AClassIsNotThatOfThisServersSimulators) {
  Come("a-far", paper::Bench());
  Come("own", paper::Bench(), RigKind::kSimulated);
  Look();
  EXPECT_EQ(WhyOut("own"), "");
  EXPECT_EQ(WhyOut("a-far").find("its class desks is that of this server's simulators"), 0u);
  EXPECT_TRUE(RigNow("own").elastic);
}

TEST_F(RollCallTest, AClassIsBuiltLikeTheFirstAgentWhenTheServerHasNoneOfItsOwn) {
  Come("b-far", paper::Bench());
  Come("a-far", Servo());
  Look();
  EXPECT_EQ(WhyOut("a-far"), "");
  EXPECT_EQ(WhyOut("b-far"), BuiltOtherwise(Servo()));
}

TEST_F(RollCallTest, AClassStaysAsItIsWhenAnAgentOfASmallerIdComes) {
  Come("b-far", paper::Bench());
  Look();
  Come("a-far", Servo());
  Look();
  EXPECT_EQ(WhyOut("a-far"), BuiltOtherwise(paper::Bench()));
  EXPECT_EQ(WhyOut("b-far"), "");
}

/// An agent is heard some seconds after a restart of the server, in which a session goes on.
TEST_F(RollCallTest, ARigIsWaitedForAfterARestartBeforeItsSessionEnds) {
  GiveSession(/*accepted=*/true);
  RestartTheServer();
  rigs_.clear();
  Look();
  clock_.Advance(seconds(19));
  Look();
  EXPECT_TRUE(IsHeld());
  clock_.Advance(seconds(1));
  Look();
  EXPECT_EQ(WhyOut("desk"), "this server has no such rig now");
}

TEST_F(RollCallTest, AfterARestartAgentsAreHeardOneAfterTheOther) {
  Come("desk", paper::Bench());
  Look();
  RestartTheServer();
  rigs_.clear();
  Look();
  EXPECT_FALSE(roll_call_->AllHeard());
  EXPECT_EQ(WhyOut("desk"), "");
  clock_.Advance(seconds(5));
  EXPECT_TRUE(roll_call_->AllHeard());
  Look();
  EXPECT_EQ(WhyOut("desk"), "this server has no such rig now");
}

TEST_F(RollCallTest, ASilentRigThatIsOnlyOfferedGoesOfflineAtOnce) {
  GiveSession(/*accepted=*/false);
  Hear(false);
  EXPECT_EQ(WhyOut("desk"), "the rig does not answer");
}

TEST_F(RollCallTest, ASilentRigThatIsHeardAgainSoonKeepsItsSession) {
  GiveSession(/*accepted=*/true);
  const std::uint64_t epoch = RigNow("desk").epoch;
  for (int i = 0; i < 3; ++i) {  // each silence is a new one
    Hear(false);
    clock_.Advance(seconds(15));
    Hear(false);
    EXPECT_TRUE(IsHeld());
    Hear(true);
  }
  EXPECT_EQ(RigNow("desk").epoch, epoch);
  Hear(false);
  clock_.Advance(seconds(20));
  Hear(false);
  EXPECT_EQ(WhyOut("desk"), "the rig does not answer");
}

}  // namespace
}  // namespace faultlab::server
