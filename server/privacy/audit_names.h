#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/database.h"

// Finds a person's login or name in the audit log. They occur in a few places only, which the verb
// determines. Nothing else is searched, because a login may also be a common word of the log, and a
// name an address.
namespace faultlab::server {

struct AuditLine {
  std::int64_t seq = 0;
  std::int64_t at_ms = 0;
  std::string actor;
  std::string verb;
  std::string object;
  std::string detail;
};

struct LoggedPerson {
  std::string owner;  ///< "user:7"
  std::string login;
};

/// The line with `by` in place of the person; nullopt when it does not name them.
std::optional<AuditLine> Renamed(AuditLine line, const LoggedPerson& person, const std::string& by);
/// The lines that name the person, oldest first, unchanged.
std::vector<AuditLine> LinesThatName(Transaction& tx, const LoggedPerson& person);
/// The only change that is ever made in the log.
void RenameInLog(Transaction& tx, const LoggedPerson& person, const std::string& by);

}  // namespace faultlab::server
