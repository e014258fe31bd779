#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/database.h"

// Where the audit log says a person's login or name, which is in few places, known by the verb.
// Nothing else is looked at: a login may be a word of the log, a name an address.
namespace faultlab::server::lab {

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
/// The lines that name the person, oldest first, as they are.
std::vector<AuditLine> LinesThatName(Transaction& tx, const LoggedPerson& person);
/// The one change that the log takes.
void RenameInLog(Transaction& tx, const LoggedPerson& person, const std::string& by);

}  // namespace faultlab::server::lab
