#pragma once

#include <gtest/gtest.h>

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "server/app/application.h"
#include "server/auth/accounts.h"
#include "tests/support/json_schema.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {

std::string ReadText(const std::string& path);

/// The credentials of a person.
struct Person {
  std::string headers;
};
inline const Person kNobody;  ///< who has not signed in

inline const std::string kCsv = "Content-Type: text/csv\r\n";
std::string IfMatch(std::int64_t version);
/// A member of an answer, a number or a text, as an address has it.
std::string Text(const boost::json::value& object, std::string_view member);
inline std::string Id(const boost::json::value& object) {
  return Text(object, "id");
}
/// Of a refusal; "" of what is none.
std::string ReasonOf(const tests::HttpAnswer& answer);

/// The lab over HTTP, in a complete server in this process; every answer is checked against the
/// API's description.
class ApiTest : public ::testing::Test {
 protected:
  explicit ApiTest(const Clock& clock = kSystemClock,
                   const std::function<void(Config&)>& configure = {});

  static WallTime Now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  }
  /// "GET runs/7" is below /api/v1/, "GET /healthz" is not; checks the answer against the
  /// description of its operation.
  tests::HttpAnswer Call(const Person& who,
                         const std::string& request,
                         const std::string& body = {},
                         const std::string& more_headers = {});
  /// Method and address of "GET runs/7".
  static std::pair<std::string, std::string> Split(const std::string& request);
  static boost::json::object Ok(const tests::HttpAnswer& answer, int status = 200);
  /// Of the list that is answered there.
  boost::json::array Items(const Person& who, const std::string& target);

  Person ByPassword(const std::string& login);
  Person Admin();
  /// Of an account that Make made, for tests whose time passes: a sign-in does not last for ever.
  Person SignIn(const std::string& login, WallTime now);
  /// The server stops as it does for SIGTERM, and starts again.
  void Restart();
  /// A run of 600 s then outlasts whatever keeps the machine busy meanwhile.
  void PlayAtSpeed(double speed) {
    config_.sim_speed = speed;
    Restart();
  }
  /// An account with a cookie, made without HTTP, for tests of other things than signing in.
  Person Make(const std::string& login, Role role);
  /// A course taught by one and attended by the other, both given by login.
  Course MakeCourse(const std::string& teacher, const std::string& student);
  std::int64_t AccountOf(const std::string& login) {
    return accounts_->GetByLogin(login).value().id;
  }
  void WaitForBenches(int ready);
  static std::string In(std::chrono::minutes from_now);

  static const std::string kPassword;

  tests::TempFolder folder_;
  tests::ApiDescription description_;
  Config config_;
  const Clock& clock_;
  std::unique_ptr<Application> application_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<Accounts> accounts_;
};

}  // namespace faultlab::server
