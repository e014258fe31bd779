#pragma once

#include <functional>
#include <string_view>

#include "server/clock.h"
#include "server/privacy/retention.h"
#include "server/repeated.h"

namespace faultlab::server {

/// Deletes what has been kept long enough, once a day from the start of the server, by the rules in
/// the settings.
class DailyRetention {
 public:
  /// Database and clock must outlive this object.
  DailyRetention(Database& database,
                 const Clock& clock,
                 RetentionRules rules,
                 std::function<void(std::string_view)> log);

 private:
  void Retain();

  Database& database_;
  const Clock& clock_;
  const RetentionRules rules_;
  const std::function<void(std::string_view)> log_;
  Repeated looks_;  ///< last: it uses the others
};

}  // namespace faultlab::server
