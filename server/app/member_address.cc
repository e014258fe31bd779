#include "server/app/member_address.h"

#include <spdlog/spdlog.h>

#include "server/net/listen_address.h"

namespace faultlab::server {

core::Result<std::string> MemberAddress(const Config& config, const std::string& listening) {
  const bool said = !config.member_address.empty();
  const std::string& address = said ? config.member_address : listening;
  const auto parsed = ParseListenAddress(address);
  const bool one_place =
      parsed.ok() && parsed.value().port != 0 && !IsEveryHost(parsed.value().host);
  if (one_place) return address;
  if (said) {
    return core::Error{
        core::ErrorCode::kInvalid,
        "member_address '" + address +
            "' is no address to connect to: write IP:PORT, for example 10.0.0.2:8080",
        "member_address"};
  }
  if (!config.database_url.empty()) {
    spdlog::info(
        "member_address is not set: other servers of this database cannot pass requests on to this "
        "one");
  }
  return std::string();
}

}  // namespace faultlab::server
