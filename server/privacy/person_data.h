#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// One table's rows about a person, as text, for an export.
struct PersonTable {
  std::string name;                            ///< "account", "recording", ..
  std::vector<std::string> columns;            ///< without hashes of secrets
  std::vector<std::vector<std::string>> rows;  ///< numbers as text
};

/// Everything that is stored about an account except its samples, in one transaction.
core::Result<std::vector<PersonTable>> PersonData(Database& database, std::int64_t account_id);
/// Ids of the recordings of an account, oldest first.
core::Result<std::vector<std::string>> RecordingsOf(Database& database, std::int64_t account_id);

/// Erases a person from the database, in one transaction. Deleted: recordings with their samples,
/// jobs, keys, sign-ins, links, devices, identities, enrolments, invitations and news. The account
/// becomes "erased-7", without a name and disabled for ever. Kept with the number of the account
/// only: past sessions and bookings, fault sets of courses, and the audit log, which names accounts
/// by their numbers and is never changed; replays that others made of the recordings are named by
/// their id. Text that people wrote themselves (a reason, a note, the name of another's run) is not
/// changed. kConflict while the person has a running run, session, booking, place in the queue or
/// job.
core::Status ErasePerson(Database& database, std::int64_t account_id, WallTime now);

}  // namespace faultlab::server
