#include "server/api/security.h"

#include <array>
#include <boost/json.hpp>
#include <string>
#include <utility>
#include <vector>

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

/// "students, instructors and admins"; empty for none.
std::string RolesText(Operation operation, Ownership whose) {
  constexpr std::array kPeople = {
      std::pair{Role::kGuest, "guests"},
      std::pair{Role::kStudent, "students"},
      std::pair{Role::kInstructor, "instructors"},
      std::pair{Role::kOperator, "operators"},
      std::pair{Role::kAdmin, "admins"},
  };
  std::vector<std::string> names;
  for (const auto& [role, name] : kPeople) {
    if (Allowed(role, operation, whose)) names.emplace_back(name);
  }
  if (names.size() == kPeople.size()) return "everybody";
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool last = i + 1 == names.size();
    text += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  return text;
}

/// Who may, and what the gate does for this operation, in a sentence or two.
std::string RightsText(const ApiRoute& route, const json::object& operation) {
  if (route.guard != Guard::kRole) return "Needs no account.";
  const Operation what = route.operation;
  std::string own = RolesText(what, Ownership::kOwn);
  if (own.empty()) own = RolesText(what, Ownership::kNone);
  const std::string course = RolesText(what, Ownership::kCourse);
  const std::string all = RolesText(what, Ownership::kForeign);
  std::string text = "For " + (own.empty() ? all : own);
  if (!all.empty() && all != own) text += "; " + all + " also for what is others'";
  if (!course.empty() && course != own && course != all) {
    text += "; " + course + " for what is of their courses";
  }
  text += ".";
  const auto scope = ScopeOfKeys(what);
  if (!scope || route.by_people) text += " Not by a key.";
  if (scope && !route.by_people && !scope->empty()) {
    text += " A key needs the scope `" + std::string(*scope) + "`.";
  }
  const json::value* const parameters = operation.if_contains("parameters");
  if (parameters != nullptr &&
      json::serialize(*parameters).find("IdempotencyKey") != std::string::npos) {
    text += " Sent again with the same `Idempotency-Key` it gives the first answer.";
  }
  return text;
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
      if (operation == nullptr) continue;
      json::object& one = operation->as_object();
      one["security"] = SecurityOf(route);
      const json::value* const more = one.if_contains("description");
      const std::string rights = RightsText(route, one);
      one["description"] =
          more == nullptr ? rights : std::string(more->as_string()) + "\n\n" + rights;
    }
  }
  return json::serialize(document);
}

}  // namespace faultlab::server
