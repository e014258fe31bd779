// What operators look at: checks, alarms, queue, planned outages.
#include <gmock/gmock.h>

#include <boost/json.hpp>

#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using std::chrono::minutes;

class OperateTest : public ApiTest {
 protected:
  json::object History(const Person& who, const std::string& rig) {
    return Ok(Call(who, "GET rigs/" + rig + "/history"));
  }
  /// Waits until `count` alarms are open; the list then.
  json::array AwaitAlarms(const Person& who, std::size_t count) {
    json::array items;
    EXPECT_TRUE(tests::Await([&] {
      items = Items(who, "alarms");
      return items.size() == count;
    })) << "not "
        << count << " alarms";
    return items;
  }
};

TEST_F(OperateTest, AFinishedCheckIsInTheHistoryStepByStep) {
  const Person op = Make("olga", Role::kOperator);
  WaitForBenches(2);
  EXPECT_EQ(Call(op, "GET rigs/unicorn/history").status, 404);
  Ok(Call(op, "POST rigs/bench-1/self-test", "{}"));
  WaitForBenches(2);
  const json::array checks = History(op, "bench-1").at("checks").as_array();
  ASSERT_EQ(checks.size(), 2u) << "the one at the start, and this one";
  EXPECT_EQ(checks[0].at("kind"), "self_test");
  EXPECT_EQ(checks[1].at("kind"), "between_users");
  EXPECT_TRUE(checks[0].at("passed").as_bool());
  const json::array steps = checks[0].at("steps").as_array();
  std::size_t relays = 0;
  for (const json::value& step : steps) {
    EXPECT_TRUE(step.at("passed").as_bool());
    if (step.at("step") == "relay") ++relays;
    if (step.at("step") != "gain") continue;
    EXPECT_GT(step.at("measured").as_double(), step.at("low").as_double());
    EXPECT_LT(step.at("measured").as_double(), step.at("high").as_double());
  }
  EXPECT_EQ(relays, 16u);
  EXPECT_EQ(steps.size(), 1 + relays + 3);
  const json::array days = History(op, "bench-1").at("days").as_array();
  ASSERT_EQ(days.size(), 30u);
  EXPECT_EQ(days[0].at("idle_s").as_int64(), 0) << "before the lab began";
}

TEST_F(OperateTest, AnAlarmIsAcknowledgedByNameAndLeavesTheListWhenItIsOver) {
  const Person op = Make("olga", Role::kOperator);
  WaitForBenches(2);
  EXPECT_TRUE(Items(op, "alarms").empty());
  Ok(Call(op, "POST rigs/bench-1/quarantine", R"({"reason":"smells"})"));
  const json::object alarm = AwaitAlarms(op, 1).at(0).as_object();
  EXPECT_EQ(alarm.at("kind"), "quarantined");
  EXPECT_EQ(alarm.at("subject"), "bench-1");
  EXPECT_EQ(alarm.at("text"), "smells");
  EXPECT_TRUE(alarm.at("acknowledged_by").is_null());
  const std::string path = "alarms/" + Id(alarm) + "/acknowledge";
  const json::object seen = Ok(Call(op, "POST " + path, "{}"));
  EXPECT_EQ(seen.at("acknowledged_by").at("login"), "olga");
  EXPECT_EQ(Items(op, "audit?limit=1").at(0).at("verb"), "acknowledge");
  EXPECT_EQ(Items(op, "alarms").size(), 1u) << "the rig is still out";
  Ok(Call(op, "POST rigs/bench-1/release", "{}"));
  AwaitAlarms(op, 0);
  EXPECT_EQ(Items(op, "alarms?state=all").size(), 1u);
  EXPECT_EQ(Call(op, "GET alarms?state=none").status, 400);
}

TEST_F(OperateTest, TheQueueNamesWhoWaitsAndAPreviewWhomAnOutageMeets) {
  const Person op = Make("olga", Role::kOperator);
  WaitForBenches(2);
  std::vector<Person> people;
  for (const char* login : {"ann", "bob", "cem"}) people.push_back(Make(login, Role::kStudent));
  for (const Person& each : people) {
    Ok(Call(each, "POST tickets", R"({"rig_class":"bench"})"), 201);
  }
  const json::array queue = Items(op, "queue");
  ASSERT_EQ(queue.size(), 3u) << "two are offered a bench, one waits";
  EXPECT_EQ(queue[2].at("user").at("login"), "cem");
  EXPECT_EQ(queue[2].at("state"), "waiting");
  EXPECT_EQ(queue[2].at("place").as_int64(), 1);
  EXPECT_EQ(Items(op, "queue?limit=2").size(), 2u);

  const auto book = [&](const Person& who) {
    const json::object when{
        {"rig_class", "bench"}, {"start", In(minutes(600))}, {"end", In(minutes(660))}};
    return Ok(Call(who, "POST bookings", json::serialize(when)), 201);
  };
  const json::object first = book(people[0]);
  const std::string rig = Text(first, "rig");
  const std::string target =
      "rigs/" + rig + "/outages/preview?start=" + In(minutes(590)) + "&end=" + In(minutes(700));
  const auto effect = [&] { return Ok(Call(op, "GET " + target)).at("bookings").as_array(); };
  ASSERT_EQ(effect().size(), 1u);
  EXPECT_EQ(effect()[0].at("outcome"), "moved");
  EXPECT_EQ(effect()[0].at("user").at("login"), "ann");
  EXPECT_NE(Text(effect()[0], "rig"), rig);
  book(people[1]);
  EXPECT_EQ(effect()[0].at("outcome"), "cancelled") << "the other bench is taken, too";
  EXPECT_TRUE(effect()[0].at("rig").is_null());
  const json::array kept = Items(people[0], "bookings");
  EXPECT_EQ(kept.at(0).at("state"), "booked") << "a preview changes nothing";
  EXPECT_EQ(Call(op, "GET rigs/" + rig + "/outages/preview").status, 400);
}

TEST_F(OperateTest, UsersAndTheLogAreSearched) {
  const Person admin = Admin();
  Make("ann", Role::kStudent);
  Make("olga", Role::kOperator);
  EXPECT_EQ(Items(admin, "users?q=OLG").size(), 1u);
  EXPECT_EQ(Call(admin, "GET sessions?all=some").status, 400);
  EXPECT_EQ(Items(admin, "users?role=student").size(), 1u);
  EXPECT_EQ(Items(admin, "users?q=nobody").size(), 0u);
  EXPECT_EQ(Call(admin, "GET users?role=king").status, 400);
  EXPECT_EQ(Call(admin, "GET audit?from=yesterday").status, 400);
  EXPECT_EQ(Items(admin, "audit").size(), 2u) << "the password by its link, and the sign-in";
  EXPECT_EQ(Items(admin, "audit?to=2020-01-01T00:00:00Z").size(), 0u);
  const json::array own = Items(admin, "audit?who=ADM&q=sign_in");
  ASSERT_EQ(own.size(), 1u);
  EXPECT_EQ(own[0].at("verb"), "sign_in");
}

}  // namespace
}  // namespace faultlab::server
