#include "server/api/security.h"

#include <boost/json.hpp>

#include "server/api/gate.h"
#include "server/api/routes.h"
#include "server/auth/authorization.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::array SecurityOf(const ApiRoute& route) {
  json::array out;
  const Operation operation = route.operation;
  const bool open = route.guard == Guard::kOpen || route.guard == Guard::kAnybody;
  if (open) return out;
  for (const Ownership whose : {Ownership::kNone, Ownership::kOwn}) {
    if (out.empty() && Allowed(Role::kGuest, operation, whose)) out.push_back(json::object{});
  }
  const auto scope = ScopeOfKeys(operation);
  if (scope && !route.by_people) {
    json::array scopes;
    if (!scope->empty()) scopes.push_back(json::string(*scope));
    out.push_back(json::object{{"key", std::move(scopes)}});
  }
  json::object session{{"session", json::array{}}};
  if (route.method != HttpMethod::kGet) session["csrf"] = json::array{};
  out.push_back(std::move(session));
  return out;
}

std::string LowerCase(std::string_view name) {
  std::string out(name);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

}  // namespace

std::string WithSecurity(std::string_view description) {
  json::value document = json::parse(description);
  json::object& paths = document.at("paths").as_object();
  for (const auto table : ApiTables()) {
    for (const ApiRoute& route : table()) {
      const bool whole = route.pattern.starts_with('/');
      json::value* path = paths.if_contains((whole ? "" : "/api/v1/") + std::string(route.pattern));
      if (path == nullptr) continue;
      json::value* operation = path->as_object().if_contains(LowerCase(Name(route.method)));
      if (operation != nullptr) operation->as_object()["security"] = SecurityOf(route);
    }
  }
  return json::serialize(document);
}

}  // namespace faultlab::server
