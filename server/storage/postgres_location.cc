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

}  // namespace

core::Result<std::string> PostgresParameters(const std::string& location) {
  const bool uri = location.starts_with("postgresql://");
  const std::string text = uri ? location : location.substr(kPrefix.size());
  char* refusal = nullptr;
  const std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)> options(
      PQconninfoParse(text.c_str(), &refusal), &PQconninfoFree);
  const std::unique_ptr<char, decltype(&PQfreemem)> owned(refusal, &PQfreemem);
  if (options == nullptr) {
    std::string why = refusal == nullptr ? "out of memory" : refusal;
    while (why.ends_with('\n')) why.pop_back();
    return core::Error{
        core::ErrorCode::kInvalid, "the PostgreSQL location is not valid: " + why, "url"};
  }
  std::string out;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    out += std::string(option->keyword) + "=" + Quoted(option->val) + " ";
  }
  // SOCI loses a quoted value with spaces when it is the last one.
  return out + "fallback_application_name=faultlab";
}

}  // namespace faultlab::server
