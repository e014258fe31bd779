#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "server/auth/accounts.h"
#include "server/auth/principal.h"
#include "server/clock.h"

namespace faultlab::server {

/// Logs who did what. An action that is done and stored is not refused because its line cannot be
/// written; the program's log then reports it.
///
/// One student (or all guests together) gets at most 200 lines of a verb in an hour, one teacher or
/// service 1000, so that a program in a loop cannot fill the log, which is kept for ever. The last
/// line states that more are omitted, the first line of a later hour how many were.
class AuditLog {
 public:
  /// Both must outlive it.
  AuditLog(Accounts& accounts, const Clock& clock, std::function<void(std::string_view)> log)
      : accounts_(accounts), clock_(clock), log_(std::move(log)) {}

  void Add(const Principal& who,
           const std::string& verb,
           const std::string& object,
           const std::string& detail);
  /// For actions that anybody can repeat: at most 30 lines of a verb about one object and 1000 of a
  /// verb in an hour. For operators and admins who are signed in there is no limit.
  void AddBounded(const AuditNote& note);

 private:
  struct Hour {
    WallTime began{};
    int lines = 0;
    int left_out = 0;
  };
  struct Counted {
    bool write = true;
    std::string remark;  ///< appended to the detail
  };
  Counted Count(const std::string& key, int lines_max, WallTime now);
  void Write(const Principal& who,
             const std::string& verb,
             const std::string& object,
             const std::string& detail);

  Accounts& accounts_;
  const Clock& clock_;
  std::function<void(std::string_view)> log_;
  std::mutex mutex_;
  std::map<std::string, Hour> hours_;
};

}  // namespace faultlab::server
