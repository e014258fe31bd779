#include "tests/system/contract/contract_world.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

namespace faultlab::tests {

namespace json = boost::json;
using server::Config;
using server::Role;

ContractWorld::ContractWorld()
    : ApiTest(server::kSystemClock, [this](Config& config) {
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
      }) {
  people_["guest"] = server::kNobody;
  people_["ann"] = Make("ann", Role::kStudent);
  people_["bob"] = Make("bob", Role::kStudent);
  people_["teacher"] = Make("teacher", Role::kInstructor);
  people_["operator"] = Make("operator", Role::kOperator);
  people_["admin"] = Make("chief", Role::kAdmin);
  server::Principal ann;
  ann.user_id = AccountOf("ann");
  const auto key = [&](const std::set<std::string>& scopes) {
    const auto made = accounts_->CreateKey(ann, "k", scopes, Now() + std::chrono::hours(1), Now());
    return server::Person{"Authorization: Bearer " + made.value().secret + "\r\n"};
  };
  people_["robot"] = key({"runs:read", "runs:write", "jobs", "lab"});
  people_["reader"] = key({"runs:read"});
  people_["sender"] = key({"jobs"});
}

HttpAnswer ContractWorld::Call(const std::string& who,
                               const std::string& request,
                               const std::string& body,
                               const std::string& headers) {
  HttpAnswer answer = ApiTest::Call(people_.at(who), request, body, headers);
  ++calls_;
  EXPECT_TRUE(answer.status < 500 || answer.status == 503)
      << who << " " << request.substr(0, 200) << " " << body.substr(0, 300) << ": " << answer.body;
  const auto [method, target] = Split(request);
  seen_[method + " " + description_.PatternOf(target)].insert(answer.status);
  return answer;
}

json::object ContractWorld::Expect(int status,
                                   const std::string& who,
                                   const std::string& request,
                                   const std::string& body,
                                   const std::string& headers) {
  const HttpAnswer answer = Call(who, request, body, headers);
  EXPECT_EQ(answer.status, status) << request << " by " << who << "\n"
                                   << answer.body.substr(0, 500);
  const bool is_json = answer.Header("Content-Type").starts_with("application/json");
  if (answer.status != status || !is_json) return {};
  return json::parse(answer.body).as_object();
}

}  // namespace faultlab::tests
