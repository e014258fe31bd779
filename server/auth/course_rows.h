#pragma once

#include <cstdint>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

// Rows of courses, their members and invitations, shared by the .cc files of Accounts.
namespace faultlab::server::course_rows {

core::Error NoCourse();
bool Exists(Transaction& tx, std::int64_t course);

bool IsMember(Transaction& tx, std::int64_t course, std::int64_t account);
/// Does nothing if the account is already a member.
void PutMember(Transaction& tx, std::int64_t course, std::int64_t account, bool teaches);

/// @returns whether the invitation is new
bool PutInvitation(
    Transaction& tx, std::int64_t course, std::int64_t account, std::int64_t teacher, WallTime now);
/// @returns whether there was an invitation
bool DropInvitation(Transaction& tx, std::int64_t course, std::int64_t account);

}  // namespace faultlab::server::course_rows
