#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server::oidc {

/// RFC 4648 section 5 without padding. A text has one value and a value one text: padding, the
/// letters of plain base64 and bits that nobody needs are refused.
std::optional<std::string> DecodeBase64Url(std::string_view text);
std::string EncodeBase64Url(std::string_view bytes);

}  // namespace faultlab::server::oidc
