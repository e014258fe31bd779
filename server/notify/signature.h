#pragma once

#include <string>
#include <string_view>

namespace faultlab::server::notify {

/// A new secret of a webhook: "whsec_" and 32 random bytes in base64.
std::string NewHookSecret();

/// The value of webhook-signature, as https://www.standardwebhooks.com has it: "v1," and the base64
/// of HMAC-SHA256 over "ID.SECONDS.BODY", its key the bytes that the secret stands for.
std::string Sign(std::string_view secret,
                 std::string_view id,
                 std::string_view seconds,
                 std::string_view body);

}  // namespace faultlab::server::notify
