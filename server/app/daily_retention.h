#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string_view>
#include <thread>

#include "server/clock.h"
#include "server/privacy/retention.h"

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
  ~DailyRetention();
  DailyRetention(const DailyRetention&) = delete;
  DailyRetention& operator=(const DailyRetention&) = delete;

 private:
  void Retain();

  Database& database_;
  const Clock& clock_;
  const RetentionRules rules_;
  const std::function<void(std::string_view)> log_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
