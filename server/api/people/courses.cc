// courses, their members, invitations.
#include <boost/json.hpp>
#include <utility>

#include "core/types/utf8.h"
#include "server/api/people/handlers.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object CourseToJson(const Course& course) {
  json::object out{{"id", course.id},
                   {"name", course.name},
                   {"teaches", course.teaches},
                   {"members", course.members},
                   {"ends", nullptr}};
  if (course.ends) out["ends"] = Iso8601(*course.ends);
  return out;
}

json::object InvitationToJson(const Invitation& invitation) {
  return {{"course", invitation.course_id},
          {"course_name", invitation.course_name},
          {"login", invitation.login},
          {"invited_by", invitation.invited_by},
          {"invited_at", Iso8601(invitation.at)}};
}

HttpResponse InvitationPage(const std::vector<Invitation>& invitations) {
  json::array items;
  for (const Invitation& invitation : invitations) items.push_back(InvitationToJson(invitation));
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

/// May the caller do this in the course? Teachers own their courses, members attend them.
core::Status MayInCourse(PeopleApi& api,
                         const Principal& who,
                         Operation operation,
                         std::int64_t course) {
  auto teaches = api.accounts.Teaches(who.user_id, course);
  if (!teaches) return teaches.error();
  auto attends = api.accounts.Attends(who.user_id, course);
  if (!attends) return attends.error();
  const Ownership ownership = teaches.value()   ? Ownership::kOwn
                              : attends.value() ? Ownership::kCourse
                                                : Ownership::kForeign;
  return Authorize(who, operation, ownership);
}

/// The course of the path's {id}, if the caller teaches or runs it.
core::Result<std::int64_t> TaughtCourse(PeopleApi& api, const ApiRequest& request) {
  auto id = PathNumber(request);
  if (!id) return id.error();
  const core::Status allowed = MayInCourse(api, request.who, Operation::kManageCourse, id.value());
  if (!allowed.ok()) return allowed.error();
  return id.value();
}

core::Result<std::string> CourseName(PeopleApi& api, std::int64_t course) {
  constexpr bool kAll = true;
  auto found = api.accounts.ListCourses(0, kAll, course - 1, 1);
  if (!found) return found.error();
  return found.value().empty() ? std::string() : found.value().front().name;
}

core::Result<HttpResponse> AnswerInvitation(PeopleApi& api,
                                            const ApiRequest& request,
                                            bool accept) {
  auto course = PathNumber(request, "course");
  if (!course) return course.error();
  const core::Status done =
      api.accounts.AnswerInvitation(request.who.user_id, course.value(), accept);
  if (!done.ok()) return done.error();
  api.audit.Add(request.who,
                accept ? "accept_invitation" : "decline_invitation",
                "course:" + std::to_string(course.value()),
                request.who.login);
  return NoContent();
}

}  // namespace

core::Result<HttpResponse> ListCourses(PeopleApi& api, const ApiRequest& request) {
  const auto page = PageOf(request.http);
  if (!page) return page.error();
  const bool all = Allowed(request.who.role, Operation::kReadCourse, Ownership::kForeign);
  auto courses =
      api.accounts.ListCourses(request.who.user_id, all, page.value().after, page.value().limit);
  if (!courses) return courses.error();
  json::array items;
  for (const Course& course : courses.value()) items.push_back(CourseToJson(course));
  const std::int64_t last = courses.value().empty() ? 0 : courses.value().back().id;
  return page.value().Answer(std::move(items), last);
}

core::Result<HttpResponse> CreateCourse(PeopleApi& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string name = in.Text("name", 200);
  if (auto error = in.Finish()) return *error;
  auto made = api.accounts.CreateCourse(name, request.who.user_id, api.clock.Wall());
  if (!made) return made.error();
  api.audit.Add(request.who, "create_course", "course:" + std::to_string(made.value().id), name);
  return JsonResponse(CourseToJson(made.value()), 201);
}

core::Result<HttpResponse> SetCourseEnd(PeopleApi& api, const ApiRequest& request) {
  auto id = TaughtCourse(api, request);
  if (!id) return id.error();
  ObjectReader in(request.body, "");
  const std::string text = in.TextOr("ends", "", 40);
  if (auto error = in.Finish()) return *error;
  std::optional<WallTime> ends;
  if (!text.empty()) {
    auto time = ParseIso8601(text, "/ends");
    if (!time) return time.error();
    ends = time.value();
  }
  const core::Status set = api.accounts.SetCourseEnd(id.value(), ends);
  if (!set.ok()) return set.error();
  api.audit.Add(request.who, "course_end", "course:" + std::to_string(id.value()), text);
  return NoContent();
}

core::Result<HttpResponse> ListMembers(PeopleApi& api, const ApiRequest& request) {
  auto id = TaughtCourse(api, request);
  if (!id) return id.error();
  auto members = api.accounts.Members(id.value());
  if (!members) return members.error();
  json::array items;
  for (const Account& account : members.value()) items.push_back(UserToJson(account));
  return JsonResponse(json::object{{"items", std::move(items)}, {"next_cursor", nullptr}});
}

core::Result<HttpResponse> EnrolMembers(PeopleApi& api, const ApiRequest& request) {
  auto course = TaughtCourse(api, request);
  if (!course) return course.error();
  if (!core::IsUtf8(request.http.body)) {
    return core::Error{core::ErrorCode::kInvalid,
                       "The list is not UTF-8; save it again as CSV UTF-8.",
                       "",
                       "list_not_utf8"};
  }
  auto done =
      api.accounts.EnrolCsv(request.who, course.value(), request.http.body, api.clock.Wall());
  if (!done) return done.error();
  const Enrolment& enrolment = done.value();
  return JsonResponse(json::object{
      {"enrolled", enrolment.enrolled.size()},
      {"invited", enrolment.invited.size() + static_cast<std::size_t>(enrolment.invited_already)},
      {"members_already", enrolment.members_already}});
}

core::Result<HttpResponse> EndEnrolment(PeopleApi& api, const ApiRequest& request) {
  auto course = TaughtCourse(api, request);
  if (!course) return course.error();
  auto member = PathNumber(request, "user");
  if (!member) return member.error();
  auto teaches = api.accounts.Teaches(member.value(), course.value());
  if (!teaches) return teaches.error();
  if (teaches.value() && request.who.role != Role::kAdmin) {
    return core::Error{core::ErrorCode::kConflict,
                       "An admin takes a teacher out of a course.",
                       "",
                       "teacher_stays"};
  }
  auto name = CourseName(api, course.value());
  if (!name) return name.error();
  const core::Status ended = api.accounts.EndEnrolment(course.value(), member.value());
  if (!ended.ok()) return ended.error();
  api.audit.Add(
      request.who, "end_enrolment", "user:" + std::to_string(member.value()), name.value());
  return NoContent();
}

core::Result<HttpResponse> ListCourseInvitations(PeopleApi& api, const ApiRequest& request) {
  auto course = TaughtCourse(api, request);
  if (!course) return course.error();
  auto invitations = api.accounts.InvitationsTo(course.value());
  if (!invitations) return invitations.error();
  return InvitationPage(invitations.value());
}

core::Result<HttpResponse> ListInvitations(PeopleApi& api, const ApiRequest& request) {
  auto invitations = api.accounts.InvitationsOf(request.who.user_id);
  if (!invitations) return invitations.error();
  return InvitationPage(invitations.value());
}

core::Result<HttpResponse> AcceptInvitation(PeopleApi& api, const ApiRequest& request) {
  return AnswerInvitation(api, request, /*accept=*/true);
}

core::Result<HttpResponse> DeclineInvitation(PeopleApi& api, const ApiRequest& request) {
  return AnswerInvitation(api, request, /*accept=*/false);
}

}  // namespace faultlab::server
