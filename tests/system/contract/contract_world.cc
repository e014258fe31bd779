#include "tests/system/contract/contract_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <fstream>
#include <sstream>
#include <thread>

#include "server/api/iso8601.h"
#include "tests/support/await.h"
#include "tests/support/paths.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;
using server::Accounts;
using server::Role;
using server::WallTime;

const std::string kPassword = "correct horse battery";

std::string ReadText(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

WallTime Now() {
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return static_cast<char>(std::tolower(c));
  });
  return text;
}

}  // namespace

ContractWorld::ContractWorld()
    : description_(ReadText(tests::InSource("server/api/openapi.json"))) {
  server::Config config;
  config.listen = "127.0.0.1:0";
  config.data_dir = folder_.File("data");
  config.sim_speed = 50.0;
  config.fixture_seed = 1;
  config.lab_benches = 2;
  config.mail.smtp = "smtp://127.0.0.1:1";  // nothing listens: mail waits
  config.mail.from = "lab@example.org";
  config.cameras.push_back({"sim-1", camera_.url()});
  server::oidc::ProviderSettings provider;
  provider.id = "uni";
  provider.label = "University";
  provider.issuer = "http://127.0.0.1:1";
  provider.client_id = "faultlab";
  provider.insecure_loopback = true;
  config.providers.push_back(provider);
  auto opened = server::Application::Open(config);
  if (!opened.ok()) throw std::runtime_error(opened.error().message);
  application_ = std::move(opened).value();
  database_ = server::Database::Open({.location = config.data_dir + "/faultlab.db"}).value();
  accounts_ = std::make_unique<Accounts>(
      *database_, server::GuestAccess::kNever, server::PasswordCost::kLeast);
  headers_["guest"] = "";
  MakePerson("ann", Role::kStudent);
  MakePerson("bob", Role::kStudent);
  MakePerson("teacher", Role::kInstructor);
  MakePerson("operator", Role::kOperator);
  MakePerson("chief", Role::kAdmin);
  headers_["admin"] = headers_["chief"];
  server::Principal ann;
  ann.user_id = accounts_->GetByLogin("ann").value().id;
  const auto key = [&](const std::set<std::string>& scopes) {
    const auto made = accounts_->CreateKey(ann, "k", scopes, Now() + std::chrono::hours(1), Now());
    return "Authorization: Bearer " + made.value().secret + "\r\n";
  };
  headers_["robot"] = key({"runs:read", "runs:write", "jobs", "lab"});
  headers_["reader"] = key({"runs:read"});
  headers_["sender"] = key({"jobs"});
}

void ContractWorld::MakePerson(const std::string& login, Role role) {
  const auto account = accounts_->Create(login, login, role, Now());
  const auto link = accounts_->CreateLink(account.value().id, Now());
  EXPECT_TRUE(accounts_->UseLink(link.value(), kPassword, Now()).ok());
  const auto in = accounts_->SignIn({login, kPassword, "127.0.0.1", ""}, Now()).signed_in.value();
  headers_[login] = "Cookie: faultlab_session=" + in.cookie_secret +
                    "\r\nX-CSRF-Token: " + in.principal.csrf_token + "\r\n";
}

HttpAnswer ContractWorld::Call(const std::string& who,
                               const std::string& method,
                               const std::string& pattern,
                               const std::string& target,
                               const std::string& body,
                               const std::string& headers) {
  std::string all = headers_.at(who) + headers;
  if (!body.empty() && all.find("Content-Type") == std::string::npos) {
    all += "Content-Type: application/json\r\n";
  }
  const HttpAnswer answer = Request(port(), method, target, all, body);
  ++calls_;
  const std::string what = who + " " + method + " " + target.substr(0, 200) + " " +
                           body.substr(0, 300) + (body.size() > 300 ? ".." : "");
  const auto error = description_.CheckAnswer(
      method, pattern, answer.status, answer.Header("Content-Type"), answer.body);
  EXPECT_FALSE(error) << what << ": " << *error << "\n"
                      << answer.status << answer.body.substr(0, 500);
  EXPECT_NE(answer.status, 0) << what << ": no answer";
  EXPECT_TRUE(answer.status < 500 || answer.status == 503) << what << ": " << answer.body;
  seen_[Lower(method) + " " + pattern].insert(answer.status);
  return answer;
}

json::object ContractWorld::Expect(int status,
                                   const std::string& who,
                                   const std::string& method,
                                   const std::string& pattern,
                                   const std::map<std::string, std::string>& parameters,
                                   const std::string& body,
                                   const std::string& headers) {
  const HttpAnswer answer = Call(
      who, method, "/api/v1/" + pattern, Fill("/api/v1/" + pattern, parameters), body, headers);
  EXPECT_EQ(answer.status, status) << method << " " << pattern << " by " << who << "\n"
                                   << answer.body.substr(0, 500);
  const bool is_json = answer.Header("Content-Type").starts_with("application/json");
  if (answer.status != status || !is_json) return {};
  return json::parse(answer.body).as_object();
}

std::string ContractWorld::Fill(std::string pattern,
                                const std::map<std::string, std::string>& values) {
  for (std::size_t open = pattern.find('{'); open != std::string::npos; open = pattern.find('{')) {
    const std::size_t close = pattern.find('}', open);
    const auto value = values.find(pattern.substr(open + 1, close - open - 1));
    pattern.replace(open, close - open + 1, value == values.end() ? "1" : value->second);
  }
  return pattern;
}

void ContractWorld::WaitForBenches() {
  EXPECT_TRUE(Await([&] {
    const HttpAnswer answer = Get(port(), "/api/v1/rig-classes");
    const json::value classes = json::parse(answer.body);
    const json::array& items = classes.at("items").as_array();
    return !items.empty() && items[0].at("ready").as_int64() >= 2;
  })) << "the benches never passed their checks";
}

json::object ContractWorld::WaitForAlarm() {
  json::array items;
  const bool raised = Await([&] {
    items = Expect(200, "operator", "GET", "alarms").at("items").as_array();
    return !items.empty();
  });
  EXPECT_TRUE(raised) << "no alarm was raised";
  return raised ? items[0].as_object() : json::object{};
}

void ContractWorld::WaitForRun(const std::string& id) {
  application_->runs().Wait(id);
}

void ContractWorld::WaitForPicture(const std::string& id) {
  server::PictureStore pictures(*database_);
  EXPECT_TRUE(Await([&] { return !pictures.List(id).value().empty(); })) << "no picture was stored";
}

std::string ContractWorld::In(std::chrono::minutes from_now) const {
  return server::Iso8601(Now() + from_now);
}

}  // namespace faultlab::tests
