#pragma once

#include <gtest/gtest.h>

#include <boost/json/object.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

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

/// The lab over HTTP, in a complete server in this process; every answer is checked against the
/// API's description.
class ApiTest : public ::testing::Test {
 protected:
  explicit ApiTest(std::vector<CameraSettings> cameras = {},
                   std::optional<std::uint64_t> fixture_seed = 1,
                   const Clock& clock = kSystemClock);

  static WallTime Now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  }
  /// Pattern and target below /api/v1/; checks the answer against the description.
  tests::HttpAnswer Call(const Person& who,
                         const std::string& method,
                         const std::string& pattern,
                         const std::string& target,
                         const std::string& body = {},
                         const std::string& more_headers = {});
  static boost::json::object Ok(const tests::HttpAnswer& answer, int status = 200);

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
