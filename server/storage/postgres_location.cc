#include "server/storage/postgres_location.h"

#include <libpq-fe.h>

#include <memory>
#include <string_view>

namespace faultlab::server {
namespace {

constexpr std::string_view kPrefix = "postgresql:";

std::string Quoted(std::string_view value) {
  std::string out = "'";
  for (const char c : value) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

/// If a password contains an unescaped '/', libpq takes its beginning for the port.
bool PortIsNumber(const PQconninfoOption* options) {
  for (const PQconninfoOption* option = options; option->keyword != nullptr; ++option) {
    if (std::string_view(option->keyword) != "port" || option->val == nullptr) continue;
    return std::string_view(option->val).find_first_not_of("0123456789,") == std::string_view::npos;
  }
  return true;
}

}  // namespace

bool IsPostgres(const std::string& location) {
  return location.starts_with(kPrefix) || location.starts_with("postgres://");
}

core::Result<std::string> PostgresParameters(const std::string& location) {
  const bool uri = location.starts_with("postgresql://") || location.starts_with("postgres://");
  const std::string text = uri ? location : location.substr(kPrefix.size());
  const std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)> options(
      PQconninfoParse(text.c_str(), nullptr), &PQconninfoFree);
  if (options == nullptr || !PortIsNumber(options.get())) {
    return core::Error{core::ErrorCode::kInvalid,
                       "the PostgreSQL location cannot be parsed; write it as "
                       "postgresql://user:password@host:port/name (reserved characters as %XX) or "
                       "postgresql:host=/run/pg user=me dbname=lab",
                       "url"};
  }
  std::string out;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    out += std::string(option->keyword) + "=" + Quoted(option->val) + " ";
  }
  // SOCI loses a quoted value with spaces if it is the last one.
  return out + "fallback_application_name=faultlab";
}

}  // namespace faultlab::server
