#pragma once

#include <soci/soci.h>

#include <cstdint>
#include <string>

#include "server/storage/database.h"
#include "server/wall_time.h"

// Rows by which an account is let in without its password: sign-ins, devices, keys, links.
namespace faultlab::server::credentials {

/// Whether this device has signed in to the account of this login.
bool IsKnownDevice(Transaction& tx, const std::string& login, const std::string& device_hash);
/// The device has signed in now. The newest 20 of an account are kept, for 400 days.
void RememberDevice(Transaction& tx, std::int64_t account, const std::string& hash, WallTime now);

struct NewSignIn {
  std::string token_hash;
  std::int64_t account = 0;
  std::string csrf;
  std::string address;
};
/// The newest 200 sign-ins of an account are kept, for 12 h.
void AddSignIn(Transaction& tx, const NewSignIn& sign_in, WallTime now);

/// All sign-ins but the one with this hash, and all devices.
void EndSignIns(Transaction& tx, std::int64_t account, const std::string& but_this);
/// API keys and the calendar link.
void EndKeys(Transaction& tx, std::int64_t account);
/// All of it, one-time links too, and identities that were added to the account later: whoever had
/// the password may have added them.
void EndAll(Transaction& tx, std::int64_t account);

}  // namespace faultlab::server::credentials
