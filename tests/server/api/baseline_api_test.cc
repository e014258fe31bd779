// What one person's run has learnt about a rig, and whether the next person's run starts with it.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class BaselineApiTest : public ApiTest {
 protected:
  struct Session {
    std::string id;
    std::string rig;
  };
  Session Begin(const Person& who) {
    const std::string ask = R"({"rig_class":"bench","min_s":600,"want_s":1800})";
    const json::object asked = Ok(Call(who, "POST tickets", ask), 201);
    const std::string ticket = Id(asked.at("ticket"));
    const json::object session = Ok(Call(who, "POST tickets/" + ticket + "/accept", "{}"));
    return {Id(session), Text(session, "rig")};
  }
  /// Ends it and waits until the rig's check between users has passed.
  void End(const Person& who, const Session& session) {
    const std::string end = "sessions/" + session.id + "/end";
    EXPECT_EQ(Call(who, "POST " + end, "{}").status, 204);
    WaitForBenches(1);
  }
  /// The plan of a run to its end, as it was resolved.
  json::object PlanOf(const Person& who, const std::string& rig, const std::string& more = "") {
    const std::string body =
        R"({"rig":")" + rig + R"(","duration_s":8,"learn":"if_needed")" + more + "}";
    const json::object run = Ok(Call(who, "POST runs", body), 201);
    const std::string id = Id(run);
    application_->runs().Wait(id);
    return Ok(Call(who, "GET runs/" + id)).at("plan").as_object();
  }
};

TEST_F(BaselineApiTest, IsOnesOwnAtOnceAndAnothersAfterTheRigsOwnCheck) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  WaitForBenches(2);
  (void)Begin(Make("cem", Role::kStudent));  // keeps the other bench
  const Session hers = Begin(ann);
  EXPECT_FALSE(PlanOf(ann, hers.rig).contains("calibration")) << "nothing is known yet";
  const json::object again = PlanOf(ann, hers.rig);
  ASSERT_TRUE(again.contains("calibration")) << again;
  EXPECT_TRUE(again.at("calibration").at("own").as_bool());
  End(ann, hers);

  const Session his = Begin(bob);
  ASSERT_EQ(his.rig, hers.rig);
  const json::object plan = PlanOf(bob, his.rig);
  ASSERT_TRUE(plan.contains("calibration")) << plan;
  EXPECT_FALSE(plan.at("calibration").at("own").as_bool());
}

TEST_F(BaselineApiTest, OfAnInputThatHardlyMovesSpoilsNobodysRun) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const Session session = Begin(ann);
  const std::string weak = R"(,"excitation":{"kind":"prbs","low_v":0,"high_v":0.4})";
  (void)PlanOf(ann, session.rig, weak);
  const json::object plan = PlanOf(ann, session.rig);
  EXPECT_FALSE(plan.contains("calibration")) << plan;
}

TEST_F(BaselineApiTest, IsNotUsedBeyondTheInputThatItWasLearntWith) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const Session session = Begin(ann);
  (void)PlanOf(ann, session.rig);
  const json::object plan =
      PlanOf(ann, session.rig, R"(,"excitation":{"kind":"prbs","low_v":1,"high_v":4})");
  EXPECT_FALSE(plan.contains("calibration")) << plan;
  ASSERT_TRUE(plan.contains("calibration_refused")) << plan;
  EXPECT_EQ(plan.at("calibration_refused").at("reason"), "input");
}

TEST_F(BaselineApiTest, OfAGuestIsNobodys) {
  (void)PlanOf({}, "sim-1");
  const json::object plan = PlanOf({}, "sim-1");
  EXPECT_FALSE(plan.contains("calibration")) << plan;
}

}  // namespace
}  // namespace faultlab::server
