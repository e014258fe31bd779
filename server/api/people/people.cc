// users, audit log.
#include <boost/json.hpp>

#include "server/api/people/handlers.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace json = boost::json;

json::object UserToJson(const Account& account) {
  return {{"id", account.id},
          {"login", account.login},
          {"name", account.name},
          {"role", Name(account.role)},
          {"disabled", account.disabled},
          {"has_password", account.has_password},
          {"version", account.version},
          {"created_at", Iso8601(account.created_at)}};
}

core::Result<HttpResponse> ListUsers(PeopleApi& api, const ApiRequest& request) {
  const auto page = PageOf(request.http);
  if (!page) return page.error();
  auto users = api.accounts.List(page.value().after, page.value().limit);
  if (!users) return users.error();
  json::array items;
  for (const Account& account : users.value()) items.push_back(UserToJson(account));
  return page.value().Answer(std::move(items), users.value().empty() ? 0 : users.value().back().id);
}

core::Result<HttpResponse> CreateUser(PeopleApi& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string login = in.Text("login", 64);
  const std::string name = in.TextOr("name", login, 200);
  const std::string_view role =
      in.WordOr("role", "student", {"student", "instructor", "operator", "admin"});
  if (auto error = in.Finish()) return *error;
  auto made =
      api.accounts.Create(login, name, ParseRole(role).value_or(Role::kStudent), api.clock.Wall());
  if (!made) return made.error();
  api.audit.Add(request.who, "create_user", "user:" + std::to_string(made.value().id), login);
  return JsonResponse(UserToJson(made.value()), 201);
}

core::Result<HttpResponse> ChangeUser(PeopleApi& api, const ApiRequest& request) {
  auto id = PathNumber(request);
  if (!id) return id.error();
  auto version = RequiredVersion(request);
  if (!version) return version.error();
  ObjectReader in(request.body, "");
  std::optional<std::string> name;
  std::optional<Role> role;
  std::optional<bool> disabled;
  if (in.Has("name")) name = in.Text("name", 200);
  if (in.Has("role")) {
    role = ParseRole(in.WordOr("role", "student", {"student", "instructor", "operator", "admin"}));
  }
  if (in.Has("disabled")) disabled = in.BooleanOr("disabled", false);
  if (auto error = in.Finish()) return *error;
  const bool self = id.value() == request.who.user_id;
  if (self && (role.value_or(Role::kAdmin) != Role::kAdmin || disabled.value_or(false))) {
    return core::Error{
        core::ErrorCode::kConflict, "An admin cannot take away their own rights.", ""};
  }
  std::string detail;
  if (role) detail += "role " + std::string(Name(*role)) + "; ";
  if (disabled) detail += *disabled ? "disabled; " : "enabled; ";
  if (name) detail += "name " + *name + "; ";
  detail.resize(detail.size() - std::min<std::size_t>(detail.size(), 2));
  auto changed = api.accounts.Change(id.value(), version.value(), name, role, disabled);
  if (!changed) return changed.error();
  api.audit.Add(request.who, "change_user", "user:" + std::to_string(id.value()), detail);
  return JsonResponse(UserToJson(changed.value()));
}

core::Result<HttpResponse> CreateResetLink(PeopleApi& api, const ApiRequest& request) {
  auto id = PathNumber(request);
  if (!id) return id.error();
  auto secret = api.accounts.CreateLink(id.value(), api.clock.Wall());
  if (!secret) return secret.error();
  api.audit.Add(request.who, "reset_link", "user:" + std::to_string(id.value()), "");
  return JsonResponse(
      json::object{{"link", "/reset?token=" + secret.value()}, {"expires_in_s", 86400}}, 201);
}

core::Result<HttpResponse> ListAuditLog(PeopleApi& api, const ApiRequest& request) {
  const auto page = PageOf(request.http);
  if (!page) return page.error();
  auto log = api.accounts.ListAudit(page.value().after, page.value().limit);
  if (!log) return log.error();
  json::array items;
  for (const AuditEntry& entry : log.value()) {
    items.push_back(json::object{{"id", entry.seq},
                                 {"at", Iso8601(entry.at)},
                                 {"actor", entry.actor},
                                 {"actor_login", entry.actor_login},
                                 {"verb", entry.verb},
                                 {"object", entry.object},
                                 {"object_login", entry.object_login},
                                 {"detail", entry.detail}});
  }
  return page.value().Answer(std::move(items), log.value().empty() ? 0 : log.value().back().seq);
}

}  // namespace faultlab::server
