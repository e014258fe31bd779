#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "server/auth/accounts.h"
#include "server/auth/principal.h"
#include "server/clock.h"

namespace faultlab::server {

/// Writes down who did what. A deed that is done and stored is not refused because its line cannot
/// be written: the program's log says so then.
class AuditLog {
 public:
  /// Both must outlive it.
  AuditLog(Accounts& accounts, const Clock& clock, std::function<void(std::string_view)> log)
      : accounts_(accounts), clock_(clock), log_(std::move(log)) {}

  void Add(const Principal& who,
           const std::string& verb,
           const std::string& object,
           const std::string& detail) const;

 private:
  Accounts& accounts_;
  const Clock& clock_;
  std::function<void(std::string_view)> log_;
};

}  // namespace faultlab::server
