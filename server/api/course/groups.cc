// groups: students who share their trials.
#include <boost/json.hpp>

#include "server/api/course/handlers.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// Of the path's {id}, if the caller is of its course and it is for groups.
core::Result<SeenAssignment> ForGroups(Api& api, const ApiRequest& request) {
  TRY(const auto id, PathNumber(request));
  TRY(auto seen, AssignmentFor(api, request.who, id));
  if (!seen.member()) {
    return core::Refuse("not_in_course");
  }
  if (seen.assignment.group_max > 1) return seen;
  return core::Refuse("groups_none");
}

core::Result<HttpResponse> EnterGroup(Api& api, const ApiRequest& request) {
  constexpr std::size_t kCodeBytesMax = 40;
  TRY(const auto seen, ForGroups(api, request));
  ObjectReader in(request.body, "");
  const std::string code = in.TextOr("code", "", kCodeBytesMax);
  if (auto error = in.Finish()) return *error;
  const std::int64_t of = seen.assignment.id;
  TRY(const auto group,
      code.empty()
          ? api.groups.Form(of, request.who.user_id)
          : api.groups.Join(
                of, request.who.user_id, code, seen.assignment.group_max, api.clock.Wall()));
  return JsonResponse(ToJson(api, group));
}

core::Result<HttpResponse> LeaveGroup(Api& api, const ApiRequest& request) {
  TRY(const auto seen, ForGroups(api, request));
  TRY_DONE(api.groups.Leave(seen.assignment.id, request.who.user_id));
  return NoContent();
}

}  // namespace

json::object ToJson(Api& api, const course::Group& group) {
  const auto member_to_json = [&](std::int64_t id) {
    const auto account = api.accounts.Get(id);
    return json::object{{"account", id}, {"name", account ? account.value().name : std::string()}};
  };
  return json::object{{"code", group.code}, {"members", ListOf(group.members, member_to_json)}};
}

std::span<const ApiRoute> GroupsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kPost, "assignments/{id}/group", kReadCourse, kRole, EnterGroup, kJson},
      {kDelete, "assignments/{id}/group", kReadCourse, kRole, LeaveGroup},
  });
  return kRoutes;
}

}  // namespace faultlab::server
