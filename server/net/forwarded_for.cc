#include "server/net/forwarded_for.h"

#include "server/net/listen_address.h"

namespace faultlab::server {

std::string_view LastListEntry(std::string_view list) {
  std::string_view entry = list.substr(list.rfind(',') + 1);  // npos + 1 is 0
  while (entry.starts_with(' ') || entry.starts_with('\t')) entry.remove_prefix(1);
  while (entry.ends_with(' ') || entry.ends_with('\t')) entry.remove_suffix(1);
  return entry;
}

std::string_view ForwardedAddress(std::string_view entry) {
  // Without brackets an IPv6 address has several colons; with an IPv4 address the only colon
  // precedes the port.
  const bool bare_v6 = !entry.starts_with('[') && entry.find(':') != entry.rfind(':');
  std::string_view address = entry;
  if (!bare_v6) {
    const auto name = HostName(entry);
    if (!name) return kUnknownClient;
    address = *name;
  }
  if (address.find(':') != std::string_view::npos) address = address.substr(0, address.find('%'));
  return IsIpLiteral(address) ? address : kUnknownClient;
}

}  // namespace faultlab::server
