#pragma once

#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server::mail {

/// One mail to one person, UTF-8.
struct Letter {
  std::string to;       ///< IsAddress
  std::string to_name;  ///< CleanName
  std::string subject;
  std::string text;
  std::string id;  ///< of letters and digits; the same at every attempt
  WallTime date{};
};

/// Whether mail can be sent there: one @, printable ASCII without blanks, quotes, brackets and
/// commas, at most 254 bytes.
bool IsAddress(std::string_view text);

/// A header of a mail: ASCII as it is, else encoded words (RFC 2047, at most 75 characters each,
/// cut between letters).
std::string HeaderText(std::string_view utf8);
/// A name before an address: in encoded words unless it is of letters, digits and blanks.
std::string NameText(std::string_view utf8);
/// "Mon, 30 Nov 2026 07:23:45 +0000" (RFC 5322)
std::string DateText(WallTime time);

}  // namespace faultlab::server::mail
