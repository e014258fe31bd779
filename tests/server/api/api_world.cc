#include "tests/server/api/api_world.h"

#include <boost/json.hpp>
#include <fstream>
#include <sstream>
#include <thread>

#include "server/api/iso8601.h"
#include "tests/support/await.h"
#include "tests/support/paths.h"

namespace faultlab::server {

namespace json = boost::json;
using tests::HttpAnswer;

namespace {

constexpr const char* kApi = "/api/v1/";

}  // namespace

const std::string ApiTest::kPassword = "correct horse battery";

std::string ReadText(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string IfMatch(std::int64_t version) {
  return "If-Match: \"" + std::to_string(version) + "\"\r\n";
}

std::string Text(const json::value& object, std::string_view member) {
  const json::value& value = object.at(member);
  return value.is_string() ? std::string(value.as_string()) : std::to_string(value.as_int64());
}

std::string ReasonOf(const HttpAnswer& answer) {
  const json::value parsed = json::parse(answer.body);
  const json::value* reason = parsed.as_object().if_contains("reason");
  return reason != nullptr ? std::string(reason->as_string()) : "";
}

ApiTest::ApiTest(const Clock& clock, const std::function<void(Config&)>& configure)
    : description_(ReadText(tests::InSource("server/api/openapi.json"))), clock_(clock) {
  config_.listen = "127.0.0.1:0";
  config_.data_dir = folder_.File("data");
  config_.sim_speed = 50.0;
  config_.fixture_seed = 1;
  config_.lab_benches = 2;
  if (configure) configure(config_);
  Restart();
  database_ = Database::Open({.location = config_.data_dir + "/faultlab.db"}).value();
  accounts_ = std::make_unique<Accounts>(*database_, GuestAccess::kNever, PasswordCost::kLeast);
}

void ApiTest::Restart() {
  application_.reset();
  auto opened = Application::Open(config_, clock_);
  EXPECT_TRUE(opened.ok()) << opened.error().message;
  application_ = std::move(opened).value();
}

HttpAnswer ApiTest::Call(const Person& who,
                         const std::string& request,
                         const std::string& body,
                         const std::string& more_headers) {
  const auto [method, target] = Split(request);
  std::string headers = who.headers + more_headers;
  if (!body.empty() && headers.find("Content-Type") == std::string::npos) {
    headers += "Content-Type: application/json\r\n";
  }
  HttpAnswer answer = tests::Request(application_->port(), method, target, headers, body);
  const auto error = description_.CheckAnswer(method,
                                              description_.PatternOf(target),
                                              answer.status,
                                              answer.Header("Content-Type"),
                                              answer.body);
  EXPECT_FALSE(error) << request.substr(0, 200) << " " << body.substr(0, 500) << ": " << *error
                      << "\n"
                      << answer.body.substr(0, 500);
  return answer;
}

std::pair<std::string, std::string> ApiTest::Split(const std::string& request) {
  const std::size_t space = request.find(' ');
  const std::string target = request.substr(space + 1);
  return {request.substr(0, space), (target.starts_with('/') ? "" : kApi) + target};
}

json::object ApiTest::Ok(const HttpAnswer& answer, int status) {
  EXPECT_EQ(answer.status, status) << answer.body;
  if (answer.status != status || answer.body.empty()) return {};
  return json::parse(answer.body).as_object();
}

json::array ApiTest::Items(const Person& who, const std::string& target) {
  const json::object list = Ok(Call(who, "GET " + target));
  return list.at("items").as_array();
}

Person ApiTest::ByPassword(const std::string& login) {
  const HttpAnswer answer =
      Call(kNobody,
           "POST auth/login",
           json::serialize(json::object{{"login", login}, {"password", kPassword}}));
  const json::object me = Ok(answer);
  const std::string cookie = answer.Header("Set-Cookie");
  EXPECT_NE(cookie.find("HttpOnly; SameSite=Lax"), std::string::npos) << cookie;
  return {"Cookie: " + cookie.substr(0, cookie.find(';')) +
          "\r\nX-CSRF-Token: " + std::string(me.at("csrf_token").as_string()) + "\r\n"};
}

Person ApiTest::Admin() {
  const auto link = accounts_->FirstStartLink(config_.server_id, Now()).value();
  EXPECT_TRUE(link.has_value());
  const HttpAnswer set =
      Call(kNobody,
           "POST auth/reset",
           json::serialize(json::object{{"token", link->secret}, {"password", kPassword}}));
  EXPECT_EQ(set.status, 204) << set.body;
  return ByPassword("admin");
}

Person ApiTest::Make(const std::string& login, Role role) {
  const auto account = accounts_->Create(login, login, role, Now());
  EXPECT_TRUE(account.ok());
  const auto link = accounts_->CreateLink(account.value().id, Now());
  EXPECT_TRUE(accounts_->UseLink(link.value(), kPassword, Now()).ok());
  return SignIn(login, Now());
}

Person ApiTest::SignIn(const std::string& login, WallTime now) {
  const auto in = accounts_->SignIn({login, kPassword, "127.0.0.1", ""}, now).signed_in;
  EXPECT_TRUE(in.ok());
  return {"Cookie: faultlab_session=" + in.value().cookie_secret +
          "\r\nX-CSRF-Token: " + in.value().principal.csrf_token + "\r\n"};
}

Course ApiTest::MakeCourse(const std::string& teacher, const std::string& student) {
  const auto course = accounts_->CreateCourse("c", AccountOf(teacher), Now()).value();
  EXPECT_TRUE(accounts_->Enrol(course.id, AccountOf(student), false).ok());
  return course;
}

void ApiTest::WaitForBenches(int ready) {
  EXPECT_TRUE(tests::Await([&] {
    const json::array items = Items(kNobody, "rig-classes");
    return !items.empty() && items[0].at("ready").as_int64() >= ready;
  })) << "the benches never passed their check";
}

std::string ApiTest::In(std::chrono::minutes from_now) {
  return Iso8601(Now() + from_now);
}

}  // namespace faultlab::server
