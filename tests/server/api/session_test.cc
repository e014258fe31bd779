// Queue, bookings and sessions over HTTP, and the messages of the feed.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <chrono>
#include <thread>

#include "server/api/iso8601.h"
#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

TEST_F(ApiTest, AStudentQueuesWorksHandsOverAndEnds) {
  PlayAtSpeed(4.0);
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  const Person cem = Make("cem", Role::kStudent);
  WaitForBenches(2);
  EXPECT_EQ(Call(ann, "POST runs", R"({"rig":"bench-1"})").status, 403);

  const std::string ask = R"({"rig_class":"bench","min_s":600,"want_s":1800})";
  const json::object ticket = Ok(Call(ann, "POST tickets", ask), 201);
  const json::object mine = ticket.at("ticket").as_object();
  EXPECT_EQ(mine.at("state"), "offered");
  const std::string accept = "tickets/" + Id(mine) + "/accept";
  EXPECT_EQ(Call(bob, "POST " + accept, "{}").status, 404);
  const json::object session = Ok(Call(ann, "POST " + accept, "{}"));
  const std::string rig = Text(session, "rig");
  const std::string id = Id(session);
  EXPECT_EQ(Ok(Call(ann, "POST tickets", ask), 201).count("session"), 1u)
      << "one's own session comes back";
  const auto foreign = tests::Request(application_->port(),
                                      "POST",
                                      "/api/v1/sessions/" + id + "/end",
                                      bob.headers + "Content-Type: application/json\r\n",
                                      "{}");
  EXPECT_EQ(foreign.status, 404) << "as if it were not there";

  const std::string run_body =
      R"({"rig":")" + rig +
      R"(","duration_s":600,"faults":[{"component":"R1","value":100,"at_s":10}]})";
  EXPECT_EQ(Call(bob, "POST runs", run_body).status, 403);
  const json::object run = Ok(Call(ann, "POST runs", run_body), 201);
  EXPECT_EQ(run.at("rig").as_string(), rig);

  Ok(Call(ann, "POST sessions/" + id + "/still-there", "{}"));
  EXPECT_EQ(Call(ann, "POST sessions/" + id + "/extend", "{}").status, 409)
      << "only in its last 5 minutes";
  EXPECT_EQ(Call(ann, "POST sessions/" + id + "/handover", R"({"to":"nobody-here"})").status, 400);
  Ok(Call(ann, "POST sessions/" + id + "/handover", R"({"to":"bob"})"));
  const std::string take = "sessions/" + id + "/handover/accept";
  EXPECT_EQ(Call(cem, "POST " + take, "{}").status, 404);
  EXPECT_EQ(Items(bob, "sessions").size(), 1u);
  const json::object taken = Ok(Call(bob, "POST " + take, "{}"));
  EXPECT_GT(taken.at("epoch").as_int64(), session.at("epoch").as_int64());
  EXPECT_EQ(taken.at("user"), "bob");
  application_->runs().Wait(run.at("id").as_string());
  EXPECT_EQ(application_->store().Get(Id(run)).value().state, RunState::kStopped)
      << "the old controller's run ends with the control";

  EXPECT_EQ(Call(bob, "POST sessions/" + id + "/end", "{}").status, 204);
  EXPECT_EQ(Call(bob, "POST sessions/" + id + "/end", "{}").status, 404);
  const json::object past = Ok(Call(bob, "GET sessions/past?limit=1"));
  ASSERT_EQ(past.at("items").as_array().size(), 1u);
  const json::object& ended = past.at("items").at(0).as_object();
  EXPECT_EQ(ended.at("rig").as_string(), rig);
  EXPECT_EQ(ended.at("why"), "ended");
  EXPECT_GE(ParseIso8601(Text(ended, "end"), "").value(),
            ParseIso8601(Text(ended, "start"), "").value());
  const std::string after = Id(ended);
  EXPECT_TRUE(Items(bob, "sessions/past?cursor=" + after).empty());
  EXPECT_TRUE(Items(cem, "sessions/past").empty()) << "of others";
  WaitForBenches(2);
  const json::object told = Ok(Call(ann, "GET events?since=0"));
  EXPECT_FALSE(told.at("items").as_array().empty());
  const std::string next = Text(told, "next");
  EXPECT_TRUE(Items(ann, "events?since=" + next).empty());
}

TEST_F(ApiTest, ABookingIsMadeShownInTheCalendarAndCancelledByVersion) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  WaitForBenches(2);
  const auto body = [&](std::chrono::minutes from, std::chrono::minutes to) {
    return json::serialize(
        json::object{{"rig_class", "bench"}, {"start", In(from)}, {"end", In(to)}});
  };
  using std::chrono::minutes;
  const HttpAnswer made = Call(ann, "POST bookings", body(minutes(60), minutes(90)));
  const json::object booking = Ok(made, 201);
  EXPECT_EQ(made.Header("ETag"), "\"1\"");
  const HttpAnswer calendar = Call(ann, "GET calendar.ics");
  EXPECT_NE(calendar.body.find("BEGIN:VEVENT\r\nUID:booking-"), std::string::npos);
  EXPECT_EQ(Call(bob, "GET calendar.ics").body.find("VEVENT"), std::string::npos);
  const json::object free = Ok(Call(bob, "GET rig-classes/bench/availability"));
  EXPECT_FALSE(free.at("next_free").as_array().empty());
  EXPECT_EQ(free.at("busy").as_array().size(), 1u);

  const std::string path = "bookings/" + Id(booking);
  EXPECT_EQ(Call(ann, "POST " + path + "/claim", "{}").status, 409);
  EXPECT_EQ(Call(ann, "DELETE " + path).status, 400);
  EXPECT_EQ(Call(bob, "DELETE " + path, {}, IfMatch(1)).status, 404);
  EXPECT_EQ(Call(ann, "DELETE " + path, {}, IfMatch(2)).status, 409);
  EXPECT_EQ(Call(ann, "DELETE " + path, {}, IfMatch(1)).status, 204);

  const auto field = [&](const std::string& start, const std::string& end) {
    const json::object wanted{{"rig_class", "bench"}, {"start", start}, {"end", end}};
    const HttpAnswer answer = Call(ann, "POST bookings", json::serialize(wanted));
    EXPECT_EQ(answer.status, 400) << answer.body;
    return std::string(json::parse(answer.body).at("field").as_string());
  };
  EXPECT_EQ(field(In(minutes(-60)), In(minutes(30))), "/start");
  EXPECT_EQ(field(In(minutes(60)), In(minutes(60) + std::chrono::hours(24 * 3650))), "/end");
  EXPECT_EQ(field("2027-03-28 02:30 Europe/Berlin", In(minutes(30))), "/start");
  EXPECT_EQ(field("2027-03-28T02:30:00", In(minutes(30))), "/start");
}

TEST_F(ApiTest, EveryStartThatIsOfferedLiesAheadAndCanBeBooked) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const WallTime asked = Now();
  const json::object answer = Ok(Call(ann, "GET rig-classes/bench/availability"));
  const json::array& offered = answer.at("next_free").as_array();
  ASSERT_FALSE(offered.empty());
  for (const json::value& each : offered) {
    const WallTime start = ParseIso8601(each.at("start").as_string(), "start").value();
    EXPECT_GE(start - asked, std::chrono::minutes(1)) << each;
    EXPECT_EQ(start.time_since_epoch() % std::chrono::minutes(5), std::chrono::minutes(0)) << each;
  }
  const json::object wish{
      {"rig_class", "bench"}, {"start", offered[0].at("start")}, {"end", offered[0].at("end")}};
  Ok(Call(ann, "POST bookings", json::serialize(wish)), 201);
}

TEST_F(ApiTest, AnInstructorTakesOverStudentsOfOwnCoursesOnlyAndWithAReason) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person other = Make("other-teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Account account = accounts_->GetByLogin("teacher").value();
  const Course course = accounts_->CreateCourse("c", account.id, Now()).value();
  ASSERT_TRUE(accounts_->Enrol(course.id, AccountOf("ann"), false).ok());
  WaitForBenches(2);
  const json::object ticket = Ok(Call(ann, "POST tickets", R"({"rig_class":"bench"})"), 201);
  const std::string ticket_id = Id(ticket.at("ticket"));
  const json::object session = Ok(Call(ann, "POST tickets/" + ticket_id + "/accept", "{}"));
  const std::string path = "sessions/" + Id(session) + "/take-over";
  const std::string why = R"({"reason":"the motor screams"})";
  const auto seen = [&](const Person& who) { return Items(who, "sessions?all=1"); };
  ASSERT_EQ(seen(teacher).size(), 1u);
  EXPECT_EQ(seen(teacher)[0].at("user"), "ann");
  EXPECT_FALSE(seen(teacher)[0].as_object().contains("run")) << "nothing runs";
  EXPECT_TRUE(seen(other).empty()) << "not a student of theirs";
  EXPECT_EQ(Call(ann, "GET sessions?all=1").status, 403);

  const std::string rig = Text(session, "rig");
  const json::object run =
      Ok(Call(ann, "POST runs", json::serialize(json::object{{"rig", rig}, {"duration_s", 600}})),
         201);
  json::array with_run = seen(teacher);
  for (int i = 0; i < 5000 && !with_run.at(0).at("run_in_progress").as_bool(); ++i) {
    with_run = seen(teacher);
  }
  ASSERT_TRUE(with_run.at(0).as_object().contains("run")) << with_run;
  EXPECT_EQ(with_run[0].at("run"), run.at("id"));
  const std::string watched = "runs/" + Id(run);
  EXPECT_EQ(Call(teacher, "GET " + watched).status, 200);
  EXPECT_EQ(Call(other, "GET " + watched).status, 404);
  EXPECT_EQ(Call(teacher, "DELETE " + watched).status, 403) << "watching is reading";
  const auto hello = [&](const Person& who) {
    const json::object token = Ok(Call(who, "POST " + watched + "/stream-token", "{}"), 201);
    tests::WebSocketClient page(application_->port(), "/ws?code=" + Text(token, "code"));
    return json::parse(page.ReadTextWith("\"hello\"").value_or("{}")).as_object();
  };
  EXPECT_TRUE(hello(ann).at("can_command").as_bool());
  EXPECT_FALSE(hello(teacher).at("can_command").as_bool()) << "without taking over";
  EXPECT_EQ(Call(other, "POST " + path, why).status, 404);
  EXPECT_EQ(Call(ann, "POST " + path, why).status, 403);
  EXPECT_EQ(Call(teacher, "POST " + path, R"({"reason":""})").status, 400);
  EXPECT_EQ(Ok(Call(teacher, "POST " + path, why)).at("user"), "teacher");
}

TEST_F(ApiTest, TellsAListenerItsPlaceAndItsSessionWithoutBeingAsked) {
  WaitForBenches(2);
  const Person ann = Make("ann", Role::kStudent);
  const Person ben = Make("ben", Role::kStudent);
  const Person eve = Make("eve", Role::kStudent);
  const auto listen = [&](const Person& who) {
    const HttpAnswer answer = Call(who, "POST events/stream-token", "{}");
    const std::string code(Ok(answer, 201).at("code").as_string());
    return std::make_unique<tests::WebSocketClient>(application_->port(), "/ws?code=" + code);
  };
  const auto next = [](tests::WebSocketClient& page) {
    const auto text = page.ReadTextWith("\"lab\"");
    EXPECT_TRUE(text) << "the feed has ended";
    return text ? json::parse(*text).as_object() : json::object{};
  };
  const auto page = listen(eve);
  const json::object first = next(*page);
  EXPECT_TRUE(first.at("tickets").as_array().empty());
  EXPECT_TRUE(first.at("sessions").as_array().empty());
  EXPECT_TRUE(first.at("news").as_array().empty());

  const std::string wish = R"({"rig_class":"bench","min_s":600,"want_s":1800})";
  for (const Person* taker : {&ann, &ben}) {
    Ok(Call(*taker, "POST tickets", wish), 201);
  }
  Ok(Call(eve, "POST tickets", wish), 201);
  json::object told;
  do {
    told = next(*page);
  } while (!told.empty() && told.at("tickets").as_array().empty());
  EXPECT_EQ(told.at("tickets").at(0).at("place").as_int64(), 1);

  // One session ends: the waiting user is offered the bench after its check, and gets a message.
  const json::array held = Items(ann, "sessions");
  ASSERT_EQ(held.size(), 1u);
  const std::string id = Id(held[0]);
  Ok(Call(ann, "POST sessions/" + id + "/end", "{}"), 204);
  bool news = false;
  do {
    told = next(*page);
    news = news || (!told.empty() && !told.at("news").as_array().empty());
  } while (!told.empty() && told.at("sessions").as_array().empty());
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.at("sessions").at(0).at("state"), "held");
  EXPECT_TRUE(news) << "an offer is news";

  // The feed contains nothing of another person, and a guest has no feed.
  EXPECT_EQ(json::serialize(told).find("ann"), std::string::npos);
}

TEST_F(ApiTest, TwoHundredClientsWhoAskInTheSameSecondAllGetAConsistentPlace) {
  constexpr int kClients = 200;
  std::vector<Person> people;
  for (int i = 0; i < kClients; ++i) {
    const auto account =
        accounts_->Create("student" + std::to_string(i), "S", Role::kStudent, Now()).value();
    Principal who;
    who.user_id = account.id;
    const auto key =
        accounts_->CreateKey(who, "k", {"lab"}, Now() + std::chrono::hours(1), Now()).value();
    people.push_back(
        {"Authorization: Bearer " + key.secret + "\r\nContent-Type: application/json\r\n"});
  }
  WaitForBenches(2);
  std::vector<double> took_ms(kClients);
  std::vector<int> status(kClients);
  std::vector<std::thread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&, i] {
      const auto index = static_cast<std::size_t>(i);
      const auto start = std::chrono::steady_clock::now();
      status[index] = tests::Request(application_->port(),
                                     "POST",
                                     "/api/v1/tickets",
                                     people[index].headers,
                                     R"({"rig_class":"bench"})")
                          .status;
      took_ms[index] =
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
              .count();
    });
  }
  for (auto& client : clients) client.join();
  EXPECT_EQ(std::count(status.begin(), status.end(), 201), kClients);
  std::set<std::int64_t> places;
  int waiting = 0;
  for (const Person& person : people) {
    const HttpAnswer mine =
        tests::Request(application_->port(), "GET", "/api/v1/tickets", person.headers);
    const json::value list = json::parse(mine.body);
    ASSERT_EQ(list.at("items").as_array().size(), 1u);
    const json::value& ticket = list.at("items").at(0);
    if (ticket.at("state") != "waiting") continue;
    ++waiting;
    places.insert(ticket.at("place").as_int64());
  }
  ASSERT_EQ(static_cast<int>(places.size()), waiting) << "no place is given twice";
  EXPECT_EQ(*places.begin(), 1);
  EXPECT_EQ(*places.rbegin(), waiting);
  std::sort(took_ms.begin(), took_ms.end());
  std::printf("200 clients in one second: p50 %.0f ms, p99 %.0f ms\n", took_ms[100], took_ms[197]);
}

}  // namespace
}  // namespace faultlab::server
