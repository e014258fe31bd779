#pragma once

#include <boost/json/object.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "server/app/application.h"
#include "server/auth/accounts.h"
#include "server/storage/picture_store.h"
#include "tests/support/camera_site.h"
#include "tests/support/json_schema.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"

namespace faultlab::tests {

/// A complete server with people of every role, and with one object of every kind that has an id.
/// Each answer is checked against the description and counted: operation x status.
class ContractWorld {
 public:
  ContractWorld();

  /// "guest", "ann" and "bob" (students), "teacher", "operator", "admin", "robot" (a key of ann's
  /// with every scope), "reader" (a key with only the scope runs:read), "sender" (with only jobs).
  HttpAnswer Call(const std::string& who,
                  const std::string& method,
                  const std::string& pattern,
                  const std::string& target,
                  const std::string& body = {},
                  const std::string& headers = {});
  /// The same, and the status must be `status`; returns the parsed body, or {}.
  boost::json::object Expect(int status,
                             const std::string& who,
                             const std::string& method,
                             const std::string& pattern,
                             const std::map<std::string, std::string>& parameters = {},
                             const std::string& body = {},
                             const std::string& headers = {});
  /// The pattern with its {names} replaced; a name without a value becomes 1.
  static std::string Fill(std::string pattern, const std::map<std::string, std::string>& values);

  /// Blocks until both benches have passed their checks.
  void WaitForBenches();
  /// Blocks until there is an alarm; returns the newest.
  boost::json::object WaitForAlarm();
  /// Blocks until the run has ended.
  void WaitForRun(const std::string& id);
  std::string In(std::chrono::minutes from_now) const;

  const ApiDescription& description() const { return description_; }
  int port() const { return application_->port(); }
  server::Accounts& accounts() { return *accounts_; }
  /// Blocks until a picture of the run is stored.
  void WaitForPicture(const std::string& id);
  /// "get /api/v1/runs/{id}" -> statuses seen.
  const std::map<std::string, std::set<int>>& seen() const { return seen_; }
  int calls() const { return calls_; }

 private:
  void MakePerson(const std::string& login, server::Role role);

  TempFolder folder_;
  CameraSite camera_;  ///< looks at sim-1
  ApiDescription description_;
  std::unique_ptr<server::Application> application_;
  std::unique_ptr<server::Database> database_;
  std::unique_ptr<server::Accounts> accounts_;
  std::map<std::string, std::string> headers_;  ///< by person
  std::map<std::string, std::set<int>> seen_;
  int calls_ = 0;
};

}  // namespace faultlab::tests
