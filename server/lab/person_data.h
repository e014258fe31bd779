#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// One table's rows of a person, as text: what an export shows.
struct PersonTable {
  std::string name;                            ///< "account", "recording", ..
  std::vector<std::string> columns;            ///< without hashes of secrets
  std::vector<std::vector<std::string>> rows;  ///< numbers as text
};

/// Everything that is kept of an account but for its samples, in one transaction.
core::Result<std::vector<PersonTable>> PersonData(Database& database, std::int64_t account_id);
/// Ids of the recordings of an account, oldest first.
core::Result<std::vector<std::string>> RecordingsOf(Database& database, std::int64_t account_id);

/// Takes a person out of the database, in one transaction: recordings with their samples, jobs,
/// keys, sign-ins, links, devices, identities, enrolments, invitations and news go; the account
/// becomes "erased-7", without a name and disabled for good. What stays carries its number alone:
/// past sessions and bookings, fault sets of courses, and the audit log, in which the login and the
/// name are replaced where a line has them by its kind (audit_names.h); replays that others made of
/// their recordings are named by the id. What people wrote by hand (a reason, a note, the name of
/// another's run) stays as it is. kConflict while a run, session, booking, place in the queue or
/// job of theirs lives.
core::Status ErasePerson(Database& database, std::int64_t account_id, WallTime now);

}  // namespace faultlab::server::lab
