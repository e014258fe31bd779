// users, courses, audit log.
#include <boost/json.hpp>

#include "server/api/json_reader.h"
#include "server/api/lab_api.h"

namespace faultlab::server {
namespace {

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

json::object CourseToJson(const Course& course) {
  json::object out{{"id", course.id},
                   {"name", course.name},
                   {"teaches", course.teaches},
                   {"members", course.members},
                   {"ends", nullptr}};
  if (course.ends) out["ends"] = Iso8601(*course.ends);
  return out;
}

json::object Page(json::array items, bool full, std::int64_t last) {
  json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (full) out["next_cursor"] = std::to_string(last);
  return out;
}

core::Result<std::int64_t> Cursor(const ApiRequest& request) {
  return QueryInteger(request.http, "cursor", 0, 0, INT64_MAX);
}

/// May the caller do this in the course? Teachers own their courses, members attend them.
core::Status MayInCourse(LabApi& lab,
                         const Principal& who,
                         Operation operation,
                         std::int64_t course) {
  auto teaches = lab.accounts.Teaches(who.user_id, course);
  if (!teaches) return teaches.error();
  auto attends = lab.accounts.Attends(who.user_id, course);
  if (!attends) return attends.error();
  const Ownership ownership = teaches.value()   ? Ownership::kOwn
                              : attends.value() ? Ownership::kCourse
                                                : Ownership::kForeign;
  return Authorize(who, operation, ownership);
}

}  // namespace

core::Result<HttpResponse> ListUsers(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  const core::Status known = OnlyQuery(request.http, {"cursor", "limit"});
  if (!known.ok()) return known.error();
  auto after = Cursor(request);
  if (!after) return after.error();
  auto limit = PageLimit(request.http);
  if (!limit) return limit.error();
  auto users = lab.value()->accounts.List(after.value(), limit.value());
  if (!users) return users.error();
  json::array items;
  for (const Account& account : users.value()) items.push_back(UserToJson(account));
  const bool full = users.value().size() == static_cast<std::size_t>(limit.value());
  return JsonResponse(Page(std::move(items), full, full ? users.value().back().id : 0));
}

core::Result<HttpResponse> CreateUser(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  const std::string login = in.Text("login", 64);
  const std::string name = in.TextOr("name", login, 200);
  const std::string_view role =
      in.WordOr("role", "student", {"student", "instructor", "operator", "admin"});
  if (auto error = in.Finish()) return *error;
  auto made = lab.value()->accounts.Create(
      login, name, ParseRole(role).value_or(Role::kStudent), api.clock.Wall());
  if (!made) return made.error();
  Audit(api, request.who, "create_user", "user:" + std::to_string(made.value().id), login);
  return JsonResponse(UserToJson(made.value()), 201);
}

core::Result<HttpResponse> ChangeUser(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  auto version = RequiredVersion(request);
  if (!version) return version.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
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
  auto changed = lab.value()->accounts.Change(id.value(), version.value(), name, role, disabled);
  if (!changed) return changed.error();
  Audit(api,
        request.who,
        "change_user",
        "user:" + std::to_string(id.value()),
        std::string(request.http.body).substr(0, 500));
  return JsonResponse(UserToJson(changed.value()));
}

core::Result<HttpResponse> CreateResetLink(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  if (const core::Status empty = NoBody(request); !empty.ok()) return empty.error();
  auto secret = lab.value()->accounts.CreateLink(id.value(), api.clock.Wall());
  if (!secret) return secret.error();
  Audit(api, request.who, "reset_link", "user:" + std::to_string(id.value()), "");
  return JsonResponse(
      json::object{{"link", "/reset?token=" + secret.value()}, {"expires_in_s", 86400}}, 201);
}

core::Result<HttpResponse> ListCourses(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  const bool all = Allowed(request.who.role, Operation::kReadCourse, Ownership::kForeign);
  auto courses = lab.value()->accounts.ListCourses(request.who.user_id, all);
  if (!courses) return courses.error();
  json::array items;
  for (const Course& course : courses.value()) items.push_back(CourseToJson(course));
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

core::Result<HttpResponse> CreateCourse(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  const std::string name = in.Text("name", 200);
  if (auto error = in.Finish()) return *error;
  auto made = lab.value()->accounts.CreateCourse(name, request.who.user_id, api.clock.Wall());
  if (!made) return made.error();
  Audit(api, request.who, "create_course", "course:" + std::to_string(made.value().id), name);
  return JsonResponse(CourseToJson(made.value()), 201);
}

core::Result<HttpResponse> SetCourseEnd(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  const core::Status allowed =
      MayInCourse(*lab.value(), request.who, Operation::kManageCourse, id.value());
  if (!allowed.ok()) return allowed.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  const std::string text = in.TextOr("ends", "", 40);
  if (auto error = in.Finish()) return *error;
  std::optional<WallTime> ends;
  if (!text.empty()) {
    auto time = ParseIso8601(text, "/ends");
    if (!time) return time.error();
    ends = time.value();
  }
  const core::Status set = lab.value()->accounts.SetCourseEnd(id.value(), ends);
  if (!set.ok()) return set.error();
  Audit(api, request.who, "course_end", "course:" + std::to_string(id.value()), text);
  return NoContent();
}

core::Result<HttpResponse> ListMembers(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  // Who sits in a course is for those who teach or run it.
  const core::Status allowed =
      MayInCourse(*lab.value(), request.who, Operation::kManageCourse, id.value());
  if (!allowed.ok()) return allowed.error();
  auto members = lab.value()->accounts.Members(id.value());
  if (!members) return members.error();
  json::array items;
  for (const Account& account : members.value()) items.push_back(UserToJson(account));
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

core::Result<HttpResponse> EnrolMembers(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto id = PathNumber(request);
  if (!id) return id.error();
  const core::Status allowed =
      MayInCourse(*lab.value(), request.who, Operation::kManageCourse, id.value());
  if (!allowed.ok()) return allowed.error();
  auto count = lab.value()->accounts.EnrolCsv(id.value(), request.http.body, api.clock.Wall());
  if (!count) return count.error();
  Audit(api,
        request.who,
        "enrol",
        "course:" + std::to_string(id.value()),
        std::to_string(count.value()) + " lines");
  return JsonResponse(json::object{{"enrolled", count.value()}});
}

core::Result<HttpResponse> ListAuditLog(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  const core::Status known = OnlyQuery(request.http, {"cursor", "limit"});
  if (!known.ok()) return known.error();
  auto before = Cursor(request);
  if (!before) return before.error();
  auto limit = PageLimit(request.http);
  if (!limit) return limit.error();
  auto log = lab.value()->accounts.ListAudit(before.value(), limit.value());
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
  const bool full = log.value().size() == static_cast<std::size_t>(limit.value());
  return JsonResponse(Page(std::move(items), full, full ? log.value().back().seq : 0));
}

}  // namespace faultlab::server
