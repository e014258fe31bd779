#pragma once

#include <cstdint>
#include <optional>

#include "server/auth/accounts.h"
#include "server/storage/database.h"

// Rows of people authenticated elsewhere, shared by the .cc files of Accounts.
namespace faultlab::server::identity_rows {

/// Of who makes the accounts of a whole class, and of each of them who comes meanwhile.
inline constexpr const char* kTurn = "identities";

std::optional<std::int64_t> AccountOf(Transaction& tx, const VouchedPerson& person);
/// The account of a person who comes for the first time, made or claimed. kForbidden with a reason.
/// @param made_by  the teacher who brings them; 0: nobody
core::Result<Account> First(Transaction& tx,
                            const VouchedPerson& person,
                            const NewcomerRules& rules,
                            WallTime now,
                            std::int64_t made_by = 0);

}  // namespace faultlab::server::identity_rows
