// What SECURITY.md promises of people, files and limits, and no other test holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <thread>

#include "server/privacy/person_data.h"
#include "tests/server/api/trial_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

TEST_F(ApiTest, ALinkForANewPasswordIsGoodOnceAlsoForTenAtOnce) {
  Make("ann", Role::kStudent);
  const std::string ann = std::to_string(AccountOf("ann"));
  const json::object link = Ok(Call(Admin(), "POST users/" + ann + "/reset-link", "{}"), 201);
  const std::string path = Text(link, "link");
  std::atomic<int> used{0};
  std::vector<std::thread> all;
  for (int k = 0; k < 10; ++k) {
    all.emplace_back([&, k] {
      const std::string body =
          json::serialize(json::object{{"token", path.substr(path.find('=') + 1)},
                                       {"password", "a long secret " + std::to_string(k)}});
      const HttpAnswer answer = tests::Request(application_->port(),
                                               "POST",
                                               "/api/v1/auth/reset",
                                               "Content-Type: application/json\r\n",
                                               body);
      used += answer.status == 204 ? 1 : 0;
    });
  }
  for (std::thread& each : all) each.join();
  EXPECT_EQ(used, 1);
}

TEST_F(ApiTest, NoOtherSiteReadsAnAnswer) {
  const Person ann = Make("ann", Role::kStudent);
  for (const char* method : {"GET", "OPTIONS"}) {
    const HttpAnswer answer = tests::Request(application_->port(),
                                             method,
                                             "/api/v1/auth/me",
                                             ann.headers +
                                                 "Origin: https://evil.example\r\n"
                                                 "Access-Control-Request-Method: GET\r\n");
    EXPECT_NE(answer.status, 0);
    for (auto [name, value] : answer.headers) {
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
      EXPECT_FALSE(name.starts_with("access-control")) << method << " " << name << ": " << value;
    }
  }
}

TEST_F(ApiTest, ACookieOfABrowserThatCameByHttpsGoesNoOtherWay) {
  Make("ann", Role::kStudent);
  const auto cookies = [&](const std::string& proxied) {
    std::vector<std::string> set;
    const HttpAnswer answer =
        Call(kNobody,
             "POST auth/login",
             json::serialize(json::object{{"login", "ann"}, {"password", kPassword}}),
             proxied);
    EXPECT_LT(answer.status, 300) << answer.body;
    for (const auto& [name, value] : answer.headers) {
      if (name == "Set-Cookie") set.push_back(value);
    }
    return set;
  };
  const auto by_https = cookies("X-Forwarded-For: 192.0.2.1\r\nX-Forwarded-Proto: https\r\n");
  EXPECT_EQ(by_https.size(), 2U);
  for (const std::string& each : by_https) {
    EXPECT_NE(each.find("; HttpOnly; SameSite=Lax"), std::string::npos) << each;
    EXPECT_NE(each.find("; Secure"), std::string::npos) << each;
  }
  const auto by_http = cookies("");
  EXPECT_EQ(by_http.size(), 2U);
  for (const std::string& each : by_http) EXPECT_EQ(each.find("Secure"), std::string::npos);
}

TEST_F(ApiTest, AnAccountKeepsSoManySamplesAndGuestsLoseTheirOldest) {
  config_.samples_per_account = 1000;
  config_.samples_of_guests = 1000;
  config_.guests = "everywhere";
  Restart();
  const Person ann = Make("ann", Role::kStudent);
  const auto run = [&](const Person& who) {
    const HttpAnswer answer = Call(who, "POST runs", R"({"duration_s":6})");
    if (answer.status == 201) {
      application_->runs().Wait(Id(json::parse(answer.body).as_object()));
    }
    return answer;
  };
  EXPECT_EQ(run(ann).status, 201);
  const HttpAnswer refused = run(ann);
  EXPECT_EQ(refused.status, 409);
  EXPECT_NE(refused.body.find(R"("quota_full")"), std::string::npos) << refused.body;
  const std::string first(json::parse(run({}).body).as_object().at("id").as_string());
  EXPECT_EQ(run({}).status, 201);
  EXPECT_EQ(Call(kNobody, "GET runs/" + first).status, 404);
}

TEST_F(TrialTest, WhatIsStoredAboutAStudentTellsNoOpenTrial) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  Play(assignment);
  const auto all = [&] {
    std::string text;
    const auto tables = PersonData(*database_, AccountOf("ann"));
    EXPECT_TRUE(tables.ok());
    for (const PersonTable& table : tables.value()) {
      text += table.name + "\n";
      for (const auto& row : table.rows) {
        for (const std::string& cell : row) text += cell + "\n";
      }
    }
    return text;
  };
  const std::string sealed = all();
  EXPECT_NE(sealed.find("trial"), std::string::npos);
  EXPECT_EQ(sealed.find("9.81247"), std::string::npos);
  EXPECT_EQ(sealed.find("\"Ra\""), std::string::npos);
  const core::Status released =
      database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        tx.sql() << "UPDATE trial SET released_ms = 1";
        return core::Done{};
      });
  ASSERT_TRUE(released.ok());
  EXPECT_NE(all().find("9.81247"), std::string::npos) << "the test would find it";
}

TEST_F(TrialTest, WhatATeacherChangesAboutOneStudentIsInTheLog) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::string path = "assignments/" + std::to_string(assignment);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const std::string person = std::to_string(AccountOf("ann"));
  Ok(Call(mila_,
          "PUT " + path + "/extensions/" + person,
          R"({"due":")" + In(std::chrono::minutes(120)) + "\"}"));
  Ok(Call(mila_, "DELETE " + path + "/extensions/" + person));
  MakeDue(assignment);
  Trial(ann_, id);
  Ok(Call(mila_,
          "PUT trials/" + std::to_string(id) + "/points",
          R"({"points":80,"reason":"drew the right chart"})"));
  const json::object log = Ok(Call(Admin(), "GET audit?limit=100"));
  const auto lines = [&](const char* verb) {
    return std::ranges::count_if(log.at("items").as_array(), [&](const json::value& line) {
      return line.at("actor_login") == "mila" && line.at("verb") == verb;
    });
  };
  EXPECT_EQ(lines("extend_assignment"), 2) << json::serialize(log);
  EXPECT_EQ(lines("award_points"), 1);
}

}  // namespace
}  // namespace faultlab::server
