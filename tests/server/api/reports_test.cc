// reports/use: what the lab has stored of sessions and bookings, by five keys.
#include <soci/soci.h>

#include <boost/json.hpp>

#include "server/storage/rows.h"
#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using Hours = std::chrono::hours;
using Minutes = std::chrono::minutes;

class ReportsApi : public ApiTest {
 protected:
  void Put(const std::string& table, Parameters columns) {
    ASSERT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              InsertInto(tx, table, columns);
                              return core::Done{};
                            })
                    .ok());
  }
  /// A session that is over; `waited` before it, for who came by the queue.
  void PutSession(int id,
                  std::int64_t user,
                  WallTime start,
                  Minutes used,
                  const std::string& courses,
                  std::optional<Minutes> waited) {
    if (waited) {
      Put("lab_ticket",
          {{"id", id + 1000},
           {"user_id", user},
           {"rig_class", "bench"},
           {"kind", 0},
           {"job", ""},
           {"weight", 0.0},
           {"min_ms", 0},
           {"want_ms", 0},
           {"created_ms", start - *waited},
           {"state", 2},
           {"offered", id},
           {"offers_missed", 0},
           {"place", 0},
           {"expected_ms", 0},
           {"first_expected_ms", 0},
           {"courses", courses}});
    }
    Put("lab_session",
        {{"id", id},
         {"user_id", user},
         {"rig", "bench-1"},
         {"rig_class", "bench"},
         {"epoch", id},
         {"booking", 0},
         {"ticket", waited ? id + 1000 : 0},
         {"kind", 0},
         {"job", ""},
         {"state", 2},
         {"start_ms", start},
         {"hard_end_ms", start + Hours(9)},
         {"claim_until_ms", start},
         {"last_control_ms", start},
         {"charged_from_ms", start},
         {"run_in_progress", 0},
         {"extended_ms", 0},
         {"warning_stage", 0},
         {"idle_answer_ms", 0},
         {"offered_to", 0},
         {"end_reason", 1},
         {"end_text", ""},
         {"ended_ms", start + used},
         {"courses", courses}});
  }
  void PutBooking(int id, std::int64_t user, WallTime start, lab::BookingState state) {
    Put("lab_booking",
        {{"id", id},
         {"user_id", user},
         {"rig_class", "bench"},
         {"start_ms", start},
         {"end_ms", start + Hours(1)},
         {"state", static_cast<int>(state)},
         {"rig", "bench-1"},
         {"session", 0},
         {"version", 1},
         {"note", ""},
         {"courses", ""}});
  }
  json::array Lines(const Person& who, const std::string& by) {
    return Items(who, "reports/use?by=" + by);
  }
  static std::vector<std::string> Keys(const json::array& lines) {
    std::vector<std::string> keys;
    for (const json::value& each : lines) keys.emplace_back(each.at("key").as_string());
    return keys;
  }
};

TEST_F(ReportsApi, CountsUseWaitsAndNoShowsByEachKey) {
  const Person teacher = Make("teacher", Role::kInstructor);
  Make("ann", Role::kStudent);
  Make("bob", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  const Person admin = Admin();
  WaitForBenches(2);
  const WallTime day = std::chrono::floor<std::chrono::days>(Now()) - Hours(24 * 2);
  const std::string in_course = std::to_string(course.id);
  PutSession(9001, AccountOf("ann"), day, Minutes(30), in_course, Minutes(2));
  PutSession(9002, AccountOf("ann"), day + Hours(2), Minutes(60), in_course, Minutes(4));
  PutSession(9003, AccountOf("bob"), day + Hours(4), Minutes(90), "", std::nullopt);
  PutBooking(9004, AccountOf("bob"), day + Hours(6), lab::BookingState::kNoShow);
  PutBooking(9005, AccountOf("bob"), day + Hours(8), lab::BookingState::kCancelled);
  PutBooking(9006, AccountOf("bob"), day + Hours(9), lab::BookingState::kUnfulfilled);

  const json::array rigs = Lines(admin, "rig");
  const json::object* bench = nullptr;
  for (const json::value& each : rigs) {
    if (each.at("key") == "bench-1") bench = &each.as_object();
  }
  ASSERT_NE(bench, nullptr);
  EXPECT_EQ(bench->at("sessions"), 3);
  EXPECT_EQ(bench->at("people"), 2);
  EXPECT_EQ(bench->at("used_s"), 180 * 60);
  EXPECT_EQ(bench->at("bookings"), 2);
  EXPECT_EQ(bench->at("no_shows"), 1);
  EXPECT_EQ(bench->at("fell"), 1);
  EXPECT_EQ(bench->at("waits"), 2);
  EXPECT_EQ(bench->at("wait_p95_s"), 240);
  EXPECT_FALSE(bench->at("out_s").is_null());

  const json::array courses = Lines(admin, "course");
  EXPECT_EQ(Keys(courses), (std::vector<std::string>{"", in_course}));
  EXPECT_EQ(courses[1].at("sessions"), 2);
  EXPECT_TRUE(courses[1].at("out_s").is_null());
  EXPECT_EQ(Lines(admin, "person").size(), 2u);
  EXPECT_GE(Lines(admin, "month").size(), 1u);

  // A teacher sees what the course did; a student, and somebody who teaches nothing, sees nothing.
  EXPECT_EQ(Keys(Lines(teacher, "course")), std::vector<std::string>{in_course});
  EXPECT_EQ(Lines(teacher, "person").size(), 1u);
  EXPECT_TRUE(Lines(Make("other", Role::kInstructor), "rig").empty());

  const tests::HttpAnswer table = Call(admin, "GET reports/use.csv?by=person");
  EXPECT_EQ(table.status, 200);
  EXPECT_EQ(table.body.substr(0, 22), "person,label,sessions,");
  EXPECT_NE(table.body.find("ann (ann)"), std::string::npos) << table.body;
  EXPECT_EQ(Call(admin, "GET reports/use?by=rig&from=2020-01-01T00:00Z").status, 400);
}

}  // namespace
}  // namespace faultlab::server
