// groups: students who share their trials.
#include <boost/json.hpp>
#include <optional>

#include "server/api/course/handlers.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

using core::Error;
using core::ErrorCode;

/// Of the path's {id}, if the caller is of its course and it is for groups.
core::Result<SeenAssignment> ForGroups(CourseApi& api, const ApiRequest& request) {
  const auto id = PathNumber(request);
  if (!id) return id.error();
  auto seen = AssignmentFor(api, request.who, id.value());
  if (!seen) return seen;
  if (!seen.value().member) {
    return Error{
        ErrorCode::kForbidden, "Only members of the course have groups.", "", "not_in_course"};
  }
  if (seen.value().assignment.group_max > 1) return seen;
  return Error{
      ErrorCode::kConflict, "Everybody works on this assignment alone.", "", "groups_none"};
}

}  // namespace

json::object ToJson(CourseApi& api, const course::Group& group) {
  json::array members;
  for (const std::int64_t each : group.members) {
    const auto account = api.accounts.Get(each);
    members.push_back(
        json::object{{"account", each}, {"name", account ? account.value().name : std::string()}});
  }
  return json::object{{"code", group.code}, {"members", std::move(members)}};
}

core::Result<HttpResponse> EnterGroup(CourseApi& api, const ApiRequest& request) {
  constexpr std::size_t kCodeBytesMax = 40;
  const auto seen = ForGroups(api, request);
  if (!seen) return seen.error();
  ObjectReader in(request.body, "");
  const std::string code = in.TextOr("code", "", kCodeBytesMax);
  if (auto error = in.Finish()) return *error;
  const std::int64_t of = seen.value().assignment.id;
  const auto group =
      code.empty()
          ? api.groups.Form(of, request.who.user_id)
          : api.groups.Join(
                of, request.who.user_id, code, seen.value().assignment.group_max, api.clock.Wall());
  if (!group) return group.error();
  return JsonResponse(ToJson(api, group.value()));
}

core::Result<HttpResponse> LeaveGroup(CourseApi& api, const ApiRequest& request) {
  const auto seen = ForGroups(api, request);
  if (!seen) return seen.error();
  const core::Status left = api.groups.Leave(seen.value().assignment.id, request.who.user_id);
  if (!left.ok()) return left.error();
  return NoContent();
}

}  // namespace faultlab::server
