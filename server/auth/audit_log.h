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

/// Writes down who did what. A deed that is done and stored is not refused because its line cannot
/// be written: the program's log says so then.
///
/// Of one student (or all guests) an hour has at most 200 lines of a verb, of one teacher or
/// service 1000: no program in a loop fills what is kept for good. The last one says that more are
/// left out, the first one of a later hour how many were.
class AuditLog {
 public:
  /// Both must outlive it.
  AuditLog(Accounts& accounts, const Clock& clock, std::function<void(std::string_view)> log)
      : accounts_(accounts), clock_(clock), log_(std::move(log)) {}

  void Add(const Principal& who,
           const std::string& verb,
           const std::string& object,
           const std::string& detail);
  /// For what strangers can do as often as they like: in an hour at most 30 lines of a verb about
  /// an object and 1000 of a verb. Of operators and admins who are signed in, all.
  void AddBounded(const AuditNote& note);

 private:
  struct Hour {
    WallTime began{};
    int lines = 0;
    int left_out = 0;
  };
  struct Counted {
    bool write = true;
    std::string remark;  ///< for the detail
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
