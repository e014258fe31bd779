// Opening hours, hours of courses, series of bookings, policies of rig classes.
#include <boost/json.hpp>

#include "server/api/iso8601.h"
#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

class HoursApi : public ApiTest {
 protected:
  /// An hour of a day ahead.
  static std::string At(int day, int hour) {
    const auto midnight = std::chrono::floor<std::chrono::duration<int, std::ratio<86'400>>>(Now());
    return Iso8601(midnight + std::chrono::hours(24 * day + hour));
  }
  HttpAnswer SetHours(const Person& who, json::object body) {
    return Call(who, "POST rig-classes/bench/hours", json::serialize(body));
  }
  std::string Book(const Person& who, const std::string& start, const std::string& end) {
    const json::object wish{{"rig_class", "bench"}, {"start", start}, {"end", end}};
    const HttpAnswer answer = Call(who, "POST bookings", json::serialize(wish));
    if (answer.status == 201) return "booked";
    EXPECT_EQ(answer.status, 409) << answer.body;
    return ReasonOf(answer);
  }
  json::object Free(const Person& who, const std::string& from, const std::string& to) {
    const std::string path = "rig-classes/bench/availability?from=" + from + "&to=" + to;
    return Ok(Call(who, "GET " + path));
  }
};

TEST_F(HoursApi, ACourseHasItsHoursAndTheLabIsClosedAtNight) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  const Person bob = Make("bob", Role::kStudent);
  WaitForBenches(2);
  const json::object open{
      {"title", "Open"}, {"start", At(2, 8)}, {"end", At(2, 18)}, {"repeat", "FREQ=DAILY;COUNT=5"}};
  EXPECT_EQ(SetHours(teacher, open).status, 403);
  const Person admin = Admin();
  const json::object set = Ok(SetHours(admin, open), 201);
  EXPECT_EQ(set.at("times"), 5);
  EXPECT_EQ(set.at("course"), nullptr);

  json::object lesson{{"title", "Drives, group 2"},
                      {"course", course.id},
                      {"start", At(2, 10)},
                      {"end", At(2, 12)},
                      {"repeat", "FREQ=WEEKLY;COUNT=3"},
                      {"time_zone", "Europe/Belgrade"}};
  EXPECT_EQ(SetHours(ann, lesson).status, 403);
  const Person other = Make("other", Role::kInstructor);
  EXPECT_GE(SetHours(other, lesson).status, 403);
  json::object nobodys = lesson;
  nobodys["course"] = 999'999;
  EXPECT_EQ(SetHours(admin, nobodys).status, 400);
  EXPECT_EQ(Book(bob, At(2, 10), At(2, 11)), "booked");
  const json::object made = Ok(SetHours(teacher, lesson), 201);
  EXPECT_EQ(made.at("bookings_kept"), 1);

  EXPECT_EQ(Book(bob, At(2, 11), At(2, 12)), "hours_of_course");
  EXPECT_EQ(Book(ann, At(2, 11), At(2, 12)), "booked");
  EXPECT_EQ(Book(teacher, At(2, 10), At(2, 11)), "booked");
  EXPECT_EQ(Book(bob, At(3, 20), At(3, 21)), "class_closed");
  const json::object free = Free(bob, At(2, 0), At(3, 0));
  for (const json::value& each : free.at("next_free").as_array()) {
    const std::string start = Text(each, "start");
    EXPECT_TRUE((start >= At(2, 8) && start < At(2, 10)) ||
                (start >= At(2, 12) && start < At(2, 18)))
        << start;
  }
  int closed = 0;
  int of_course = 0;
  for (const json::value& each : free.at("busy").as_array()) {
    closed += each.at("kind") == "closed" ? 1 : 0;
    of_course += each.at("kind") == "course" && each.at("reason") == "Drives, group 2" ? 1 : 0;
  }
  EXPECT_EQ(closed, 2);  // before 8 and after 18
  EXPECT_EQ(of_course, 1);

  const std::string path = "rig-classes/bench/hours/";
  const auto remove = [&](const Person& who, const json::object& which) {
    return Call(who, "DELETE " + path + Id(which)).status;
  };
  EXPECT_EQ(remove(teacher, set), 403);
  EXPECT_EQ(remove(teacher, made), 204);
  EXPECT_EQ(remove(teacher, made), 404);
  EXPECT_EQ(Book(bob, At(2, 11), At(2, 12)), "booked");
  const json::object left = Ok(Call(bob, "GET rig-classes/bench/hours"));
  ASSERT_EQ(left.at("items").as_array().size(), 1u);
  Restart();
  WaitForBenches(2);
  EXPECT_EQ(Ok(Call(bob, "GET rig-classes/bench/hours")), left);
}

TEST_F(HoursApi, ARequestThatMakesNoSenseIsRefusedByName) {
  const Person admin = Admin();
  WaitForBenches(2);
  const json::object good{{"title", "Open"}, {"start", At(2, 8)}, {"end", At(2, 18)}};
  const auto refused = [&](const char* member, const json::value& value) {
    json::object body = good;
    body[member] = value;
    const HttpAnswer answer = SetHours(admin, body);
    EXPECT_EQ(answer.status, 400) << answer.body;
    return std::string(json::parse(answer.body).at("field").as_string());
  };
  EXPECT_EQ(refused("repeat", "FREQ=WEEKLY"), "/repeat");
  EXPECT_EQ(refused("time_zone", 7), "/time_zone");
  EXPECT_EQ(refused("end", json::string(At(2, 8))), "/end");
  EXPECT_EQ(refused("except", json::array{"tomorrow"}), "/except");
  EXPECT_EQ(refused("weekly", true), "/weekly");
  EXPECT_EQ(Ok(SetHours(admin, good), 201).at("times"), 1);
}

TEST_F(HoursApi, ASeriesIsBookedAsAWhole) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  WaitForBenches(2);
  const auto series = [&](const Person& who, int day, int count) {
    const json::object body{{"rig_class", "bench"},
                            {"start", At(day, 9)},
                            {"end", At(day, 10)},
                            {"repeat", "FREQ=WEEKLY;COUNT=" + std::to_string(count)}};
    return Call(who, "POST bookings/series", json::serialize(body));
  };
  const json::object made = Ok(series(ann, 2, 3), 201);
  ASSERT_EQ(made.at("items").as_array().size(), 3u);
  EXPECT_EQ(made.at("items").as_array()[2].at("start").as_string(), At(16, 9));
  const HttpAnswer again = series(ann, 23, 1);
  EXPECT_EQ(ReasonOf(again), "bookings_full") << again.body;
  Ok(series(bob, 9, 1), 201);
  const Person cem = Make("cem", Role::kStudent);
  const json::object refused = json::parse(series(cem, 2, 3).body).as_object();
  EXPECT_EQ(refused.at("reason"), "series_refused");
  EXPECT_EQ(refused.at("field"), "/repeat");
  EXPECT_TRUE(Items(cem, "bookings").empty());
}

TEST_F(HoursApi, AClassHasAPolicyOfItsOwnUntilItIsDropped) {
  const Person admin = Admin();
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const std::string path = "rig-classes/bench/policy";
  json::object wanted = Ok(Call(ann, "GET " + path));
  EXPECT_EQ(wanted.at("version"), 0);
  wanted.erase("version");
  wanted["booking_max_s"] = 1800;
  const std::string body = json::serialize(wanted);
  EXPECT_GT(Ok(Call(admin, "PUT " + path, body, IfMatch(0))).at("version").as_int64(), 0);
  EXPECT_EQ(Call(admin, "PUT " + path, body, IfMatch(0)).status, 409);
  EXPECT_EQ(Ok(Call(ann, "GET policy")).at("booking_max_s"), 14'400);
  const json::object wish{{"rig_class", "bench"}, {"start", At(2, 8)}, {"end", At(2, 9)}};
  EXPECT_EQ(Call(ann, "POST bookings", json::serialize(wish)).status, 400);
  Restart();
  WaitForBenches(2);
  EXPECT_EQ(Ok(Call(ann, "GET " + path)).at("booking_max_s"), 1800);
  EXPECT_EQ(Call(admin, "DELETE " + path).status, 204);
  EXPECT_EQ(Call(admin, "DELETE " + path).status, 404);
  EXPECT_EQ(Ok(Call(ann, "GET " + path)).at("booking_max_s"), 14'400);
  Ok(Call(ann, "POST bookings", json::serialize(wish)), 201);
  EXPECT_EQ(Call(ann, "GET rig-classes/none/policy").status, 404);
}

}  // namespace
}  // namespace faultlab::server
