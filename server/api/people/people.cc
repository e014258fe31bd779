// users, audit log.
#include <algorithm>
#include <boost/json.hpp>

#include "server/api/people/handlers.h"
#include "server/auth/audit_verbs.h"
#include "server/json/json_reader.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {

namespace json = boost::json;
namespace {

/// A key that may manage people must not become an admin by them: it makes none, and changes none.
core::Status KeyMayTouch(const ApiRequest& request, Role role) {
  if (request.who.proof != Proof::kApiKey || role != Role::kAdmin) return core::Done{};
  return core::Refuse("admins_by_key");
}

core::Status KeyMayChange(const Api& api, const ApiRequest& request, std::int64_t id) {
  if (request.who.proof != Proof::kApiKey) return core::Done{};
  TRY(const auto account, api.accounts.Get(id));
  return KeyMayTouch(request, account.role);
}

core::Result<HttpResponse> ListUsers(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  AccountFilter filter;
  TRY(const auto text, QuerySearch(request.http, "q"));
  filter.text = text.value_or("");
  if (const auto role = request.http.Query("role")) {
    filter.role = ParseRole(*role);
    if (!filter.role) {
      return core::Refuse("word_unknown",
                          "role",
                          {{"member", "role"}, {"words", "student, instructor, operator, admin"}});
    }
  }
  TRY(const auto course, QueryInteger(request.http, "course", 0, 1, INT64_MAX));
  if (course > 0) filter.course = course;
  TRY(auto users, api.accounts.List(filter, page.after, page.limit));
  return page.Answer(users, UserToJson, &Account::id);
}

core::Result<HttpResponse> CreateUser(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string login = in.Text("login", 64);
  const std::string name = in.TextOr("name", login, 200);
  const std::string_view role =
      in.WordOr("role", "student", {"student", "instructor", "operator", "admin"});
  if (auto error = in.Finish()) return *error;
  const Role wanted = ParseRole(role).value_or(Role::kStudent);
  TRY_DONE(KeyMayTouch(request, wanted));
  TRY(auto made, api.accounts.Create(login, name, wanted, api.clock.Wall()));
  api.audit.Add(request.who, "create_user", OwnerKeyOf(made.id), "");
  return JsonResponse(UserToJson(made), 201);
}

core::Result<HttpResponse> ChangeUser(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(auto version, RequiredVersion(request));
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
  core::Status may = KeyMayChange(api, request, id);
  if (may.ok() && role) may = KeyMayTouch(request, *role);
  if (!may.ok()) return may.error();
  const bool self = id == request.who.user_id;
  if (self && (role.value_or(Role::kAdmin) != Role::kAdmin || disabled.value_or(false))) {
    return core::Refuse("own_rights");
  }
  std::string detail;
  if (role) detail += "role " + std::string(Name(*role)) + "; ";
  if (disabled) detail += *disabled ? "disabled; " : "enabled; ";
  if (name) detail += "name; ";
  detail.resize(detail.size() - std::min<std::size_t>(detail.size(), 2));
  TRY(auto changed, api.accounts.Change(id, version, name, role, disabled));
  api.audit.Add(request.who, "change_user", OwnerKeyOf(id), detail);
  return JsonResponse(UserToJson(changed));
}

core::Result<HttpResponse> CreateResetLink(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY_DONE(KeyMayChange(api, request, id));
  TRY(auto secret, api.accounts.CreateLink(id, api.clock.Wall()));
  api.audit.Add(request.who, "reset_link", OwnerKeyOf(id), "");
  return JsonResponse(json::object{{"link", "/reset?token=" + secret}, {"expires_in_s", 86400}},
                      201);
}

/// ?verbs=quarantine,release
core::Result<std::vector<std::string>> QueryVerbs(const ApiRequest& request) {
  std::vector<std::string> verbs;
  const std::string text = request.http.Query("verbs").value_or("");
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    std::string verb = text.substr(at, end - at);
    at = end + 1;
    if (std::ranges::find(kAuditVerbs, verb) == kAuditVerbs.end()) {
      std::string known;
      for (const std::string_view each : kAuditVerbs) {
        known.append(known.empty() ? "" : ", ").append(each);
      }
      return core::Refuse("words_unknown", "verbs", {{"member", "verbs"}, {"words", known}});
    }
    if (std::ranges::find(verbs, verb) == verbs.end()) verbs.push_back(std::move(verb));
  }
  return verbs;
}

core::Result<HttpResponse> ListAuditLog(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  TRY(const auto verbs, QueryVerbs(request));
  TRY(const auto from, QueryTime(request.http, "from"));
  TRY(const auto to, QueryTime(request.http, "to"));
  TRY(const auto text, QuerySearch(request.http, "q"));
  TRY(const auto who, QuerySearch(request.http, "who"));
  const AuditFilter filter{
      .text = text.value_or(""), .verbs = verbs, .who = who.value_or(""), .from = from, .to = to};
  TRY(auto log, api.accounts.ListAudit(filter, page.after, page.limit));
  const auto to_json = [](const AuditEntry& entry) {
    return json::object{{"id", entry.seq},
                        {"at", Iso8601(entry.at)},
                        {"actor", entry.actor},
                        {"actor_login", entry.actor_login},
                        {"verb", entry.verb},
                        {"object", entry.object},
                        {"object_login", entry.object_login},
                        {"object_name", entry.object_name},
                        {"detail", entry.detail}};
  };
  return page.Answer(log, to_json, &AuditEntry::seq);
}

}  // namespace

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

std::span<const ApiRoute> PeopleRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "users", kReadUsers, kRole, ListUsers}.Takes("cursor limit q role course"),
      {kPost, "users", kManageUsers, kRole, CreateUser, kJson},
      {kPatch, "users/{id}", kManageUsers, kRole, ChangeUser, kJson},
      {kPost, "users/{id}/reset-link", kManageUsers, kRole, CreateResetLink, kEmptyForSecret},
      ApiRoute{kGet, "audit", kReadAudit, kRole, ListAuditLog}.Takes(
          "cursor limit q verbs who from to"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
