#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server::oidc {

/// RFC 4648 section 5 without padding. Each text has one value and each value one text: padding,
/// the letters of plain base64 and unused bits that are not zero are refused.
std::optional<std::string> DecodeBase64Url(std::string_view text);
std::string EncodeBase64Url(std::string_view bytes);

}  // namespace faultlab::server::oidc
