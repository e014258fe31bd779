#pragma once

#include <cstdint>
#include <string>

#include "server/storage/database.h"
#include "server/wall_time.h"

// Rows that give access to an account without its password: sign-ins, devices, keys, links.
namespace faultlab::server::credentials {

/// Whether this device has signed in to the account with this login.
bool IsKnownDevice(Transaction& tx, const std::string& login, const std::string& device_hash);
/// Whether one of the devices that are known has last signed in from this network (AddressKey).
bool IsKnownNetwork(Transaction& tx, const std::string& login, const std::string& network);
/// Stores that the device has signed in now, and from where. The newest 20 of an account are kept,
/// for 400 days.
void RememberDevice(Transaction& tx,
                    std::int64_t account,
                    const std::string& hash,
                    const std::string& network,
                    WallTime now);

struct NewSignIn {
  std::string token_hash;
  std::int64_t account = 0;
  std::string csrf;
  std::string address;
};
/// The newest 200 sign-ins of an account are kept, for 12 h.
void AddSignIn(Transaction& tx, const NewSignIn& sign_in, WallTime now);

/// Ends all sign-ins except the one with this hash, and all devices.
void EndSignIns(Transaction& tx, std::int64_t account, const std::string& but_this);
/// Ends API keys and the calendar link.
void EndKeys(Transaction& tx, std::int64_t account);
/// Ends all of these, one-time links too, and removes identities that were added to the account
/// later, because somebody who knew the password may have added them.
void EndAll(Transaction& tx, std::int64_t account);

}  // namespace faultlab::server::credentials
