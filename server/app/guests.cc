#include "server/app/guests.h"

#include "server/net/listen_address.h"

namespace faultlab::server {

core::Result<Principal> GuestsOnly::Authenticate(const RequestCredentials& credentials, WallTime) {
  const bool here = IsLoopbackHost(credentials.remote_address);
  if (from_ == "everywhere" || (from_ == "loopback" && here)) return Principal{};
  return core::Error{core::ErrorCode::kUnauthorized,
                     "Without an account this laboratory can be used only from its own machine; "
                     "the setting is 'guests'.",
                     {}};
}

}  // namespace faultlab::server
