#pragma once

#include <boost/json/object.hpp>
#include <map>
#include <set>
#include <string>

#include "tests/server/api/api_world.h"
#include "tests/support/camera_site.h"

namespace faultlab::tests {

struct HasCamera {
  CameraSite camera_;  ///< looks at sim-1
};

/// A complete server with people of every role, with mail, a provider and a camera. The answers are
/// counted: operation x status.
class ContractWorld : protected HasCamera, public server::ApiTest {
 protected:
  ContractWorld();

  /// "guest", "ann" and "bob" (students), "teacher", "operator", "admin", "robot" (a key of ann's
  /// with every scope), "reader" (a key with only the scope runs:read), "sender" (with only jobs).
  HttpAnswer Call(const std::string& who,
                  const std::string& request,
                  const std::string& body = {},
                  const std::string& headers = {});
  /// The same, and the status must be `status`; returns the parsed body, or {}.
  boost::json::object Expect(int status,
                             const std::string& who,
                             const std::string& request,
                             const std::string& body = {},
                             const std::string& headers = {});
  void WaitForRun(const std::string& id) { application_->runs().Wait(id); }

  std::map<std::string, server::Person> people_;
  std::map<std::string, std::set<int>> seen_;  ///< "GET /api/v1/runs/{id}" -> statuses
  int calls_ = 0;
};

}  // namespace faultlab::tests
