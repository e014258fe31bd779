// courses, their members, invitations.
#include <algorithm>
#include <boost/json.hpp>
#include <utility>

#include "core/types/utf8.h"
#include "server/api/people/handlers.h"
#include "server/json/json_reader.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object CourseToJson(const Course& course) {
  return {{"id", course.id},
          {"name", course.name},
          {"teaches", course.teaches},
          {"members", course.members},
          {"ends", TimeOrNull(course.ends)}};
}

json::object InvitationToJson(const Invitation& invitation) {
  return {{"course", invitation.course_id},
          {"course_name", invitation.course_name},
          {"login", invitation.login},
          {"invited_by", invitation.invited_by},
          {"invited_at", Iso8601(invitation.at)}};
}

core::Result<std::string> CourseName(Api& api, std::int64_t course) {
  TRY(const auto found, api.accounts.FindCourse(course));
  return found ? found->name : std::string();
}

core::Result<HttpResponse> AnswerInvitation(Api& api, const ApiRequest& request, bool accept) {
  TRY(auto course, PathNumber(request, "course"));
  TRY_DONE(api.accounts.AnswerInvitation(request.who.user_id, course, accept));
  api.audit.Add(request.who,
                accept ? "accept_invitation" : "decline_invitation",
                "course:" + std::to_string(course),
                "");
  return NoContent();
}

core::Result<HttpResponse> ListCourses(Api& api, const ApiRequest& request) {
  TRY(const auto page, PageOf(request.http));
  const bool all = Authorize(request.who, Operation::kReadCourse, Ownership::kForeign).ok();
  TRY(auto courses, api.accounts.ListCourses(request.who.user_id, all, page.after, page.limit));
  return page.Answer(courses, CourseToJson, &Course::id);
}

core::Result<HttpResponse> CreateCourse(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string name = in.Text("name", 200);
  if (auto error = in.Finish()) return *error;
  TRY(auto made, api.accounts.CreateCourse(name, request.who.user_id, api.clock.Wall()));
  api.audit.Add(request.who, "create_course", "course:" + std::to_string(made.id), name);
  return JsonResponse(CourseToJson(made), 201);
}

core::Result<HttpResponse> SetCourseEnd(Api& api, const ApiRequest& request) {
  TRY(auto id, TaughtCourse(api, request));
  ObjectReader in(request.body, "");
  const std::string text = in.TextOr("ends", "", 40);
  if (auto error = in.Finish()) return *error;
  std::optional<WallTime> ends;
  if (!text.empty()) {
    TRY(ends, ParseIso8601(text, "/ends"));
  }
  TRY_DONE(api.accounts.SetCourseEnd(id, ends));
  api.audit.Add(request.who, "course_end", "course:" + std::to_string(id), text);
  return NoContent();
}

core::Result<HttpResponse> ListMembers(Api& api, const ApiRequest& request) {
  TRY(auto id, TaughtCourse(api, request));
  TRY(auto members, api.accounts.Members(id));
  return ListAnswer(ListOf(members, UserToJson));
}

core::Result<HttpResponse> EnrolMembers(Api& api, const ApiRequest& request) {
  TRY(auto course, TaughtCourse(api, request));
  if (!core::IsUtf8(request.http.body)) {
    return core::Refuse("list_not_utf8");
  }
  TRY(const auto look, QueryWord(request.http, "look", {"only"}));
  TRY(const auto undo, QueryWord(request.http, "undo", {"list"}));
  if (look && undo) return core::Refuse("query_unknown", "look", {{"member", "look"}});
  const WallTime now = api.clock.Wall();
  TRY(const auto enrolment,
      undo ? api.accounts.TakeBackCsv(request.who, course, request.http.body, now)
           : api.accounts.EnrolCsv(request.who, course, request.http.body, now, look.has_value()));
  json::object out{
      {"enrolled", enrolment.enrolled.size()},
      {"invited", enrolment.invited.size() + static_cast<std::size_t>(enrolment.invited_already)},
      {"members_already", enrolment.members_already},
      {"login_from", TextOrNull(enrolment.login_from)},
      {"name_from", TextOrNull(enrolment.name_from)},
      {"mail_from", TextOrNull(enrolment.mail_from)}};
  out["people"] = ListOf(enrolment.people, [](const Enrolment::Person& person) {
    return json::object{
        {"login", person.login}, {"name", person.name}, {"becomes", person.becomes}};
  });
  return JsonResponse(out);
}

/// Whether a sign-in service lets in whoever has an address of a class list.
bool ProvidersVouch(const Api& api) {
  return std::ranges::any_of(api.sign_in_flow.providers(),
                             [](const auto& each) { return each->settings().claim_class_list; });
}

core::Result<HttpResponse> MailClassLinks(Api& api, const ApiRequest& request) {
  TRY(const auto id, TaughtCourse(api, request));
  TRY(const auto language, QueryWord(request.http, "language", {"en", "sr"}));
  TRY(const auto name, CourseName(api, id));
  TRY(const auto queued,
      api.class_mail.Queue(
          request.who, id, name, ProvidersVouch(api), language == "sr", api.clock.Wall()));
  api.audit.Add(
      request.who, "mail_links", "course:" + std::to_string(id), std::to_string(queued.count));
  return JsonResponse(
      json::object{{"queued", queued.count},
                   {"without", json::array(queued.without.begin(), queued.without.end())}},
      202);
}

core::Result<HttpResponse> ListClassMails(Api& api, const ApiRequest& request) {
  TRY(const auto course, TaughtCourse(api, request));
  TRY(const auto sent, api.class_mail.SentTo(course));
  return JsonResponse(json::object{{"from", TextOrNull(api.class_mail.from())},
                                   {"items", ListOf(sent, [](const mail::ClassMail::Sent& each) {
                                      return json::object{{"login", each.login},
                                                          {"at", Iso8601(each.at)},
                                                          {"state", each.state},
                                                          {"attempts", each.attempts},
                                                          {"error", each.error}};
                                    })}});
}

core::Result<HttpResponse> CreateClassLinks(Api& api, const ApiRequest& request) {
  TRY(auto course, TaughtCourse(api, request));
  const WallTime now = api.clock.Wall();
  TRY(const auto links,
      api.accounts.CreateClassLinks(request.who, course, ProvidersVouch(api), now));
  const auto audit = [&](const std::string& accounts) {
    api.audit.Add(request.who, "class_links", "course:" + std::to_string(course), accounts);
  };
  constexpr std::size_t kDetailBytes = 1000;
  std::string accounts;
  for (const Accounts::ClassLink& link : links) {
    accounts += (accounts.empty() ? "" : ", ") + OwnerKeyOf(link.account.id);
    if (accounts.size() > kDetailBytes) audit(std::exchange(accounts, {}));
  }
  if (!accounts.empty()) audit(accounts);
  const auto item = [](const Accounts::ClassLink& link) {
    return json::object{{"account", link.account.id},
                        {"login", link.account.login},
                        {"name", link.account.name},
                        {"link", "/reset?token=" + link.secret}};
  };
  return JsonResponse(json::object{{"items", ListOf(links, item)},
                                   {"expires_at", Iso8601(now + Accounts::kClassLinkLives)}},
                      201);
}

core::Result<HttpResponse> EndEnrolment(Api& api, const ApiRequest& request) {
  TRY(auto course, TaughtCourse(api, request));
  TRY(auto member, PathNumber(request, "user"));
  TRY(auto teaches, api.accounts.Teaches(member, course));
  if (teaches && request.who.role != Role::kAdmin) {
    return core::Refuse("teacher_stays");
  }
  TRY(auto name, CourseName(api, course));
  TRY_DONE(api.accounts.EndEnrolment(course, member));
  api.audit.Add(request.who, "end_enrolment", OwnerKeyOf(member), name);
  return NoContent();
}

core::Result<HttpResponse> ListCourseInvitations(Api& api, const ApiRequest& request) {
  TRY(auto course, TaughtCourse(api, request));
  TRY(auto invitations, api.accounts.InvitationsTo(course));
  return ListAnswer(ListOf(invitations, InvitationToJson));
}

core::Result<HttpResponse> ListInvitations(Api& api, const ApiRequest& request) {
  TRY(auto invitations, api.accounts.InvitationsOf(request.who.user_id));
  return ListAnswer(ListOf(invitations, InvitationToJson));
}

core::Result<HttpResponse> AcceptInvitation(Api& api, const ApiRequest& request) {
  return AnswerInvitation(api, request, /*accept=*/true);
}

core::Result<HttpResponse> DeclineInvitation(Api& api, const ApiRequest& request) {
  return AnswerInvitation(api, request, /*accept=*/false);
}

}  // namespace

core::Result<std::int64_t> TaughtCourse(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(const auto whose, api.accounts.InCourse(request.who.user_id, id));
  TRY_DONE(Authorize(request.who, Operation::kManageCourse, whose));
  return id;
}

std::span<const ApiRoute> CoursesRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "courses", kReadCourse, kRole, ListCourses}.Takes("cursor limit"),
      {kPost, "courses", kManageCourse, kRole, CreateCourse, kJson},
      {kPut, "courses/{id}/end", kReadCourse, kRole, SetCourseEnd, kJson},
      {kGet, "courses/{id}/members", kReadCourse, kRole, ListMembers},
      ApiRoute{kPost, "courses/{id}/members", kReadCourse, kRole, EnrolMembers, kClassList, kHeavy}
          .Takes("look undo"),
      ApiRoute{kPost,
               "courses/{id}/links",
               kReadCourse,
               kRole,
               CreateClassLinks,
               kEmptyForSecret,
               kHeavy}
          .ByPeople(),
      ApiRoute{kPost, "courses/{id}/mails", kReadCourse, kRole, MailClassLinks, kEmpty, kHeavy}
          .Takes("language")
          .ByPeople(),
      {kGet, "courses/{id}/mails", kReadCourse, kRole, ListClassMails},
      {kDelete, "courses/{id}/members/{user}", kReadCourse, kRole, EndEnrolment},
      {kGet, "courses/{id}/invitations", kReadCourse, kRole, ListCourseInvitations},
      {kGet, "invitations", kManageOwnAccount, kRole, ListInvitations},
      {kPost, "invitations/{course}/accept", kManageOwnAccount, kRole, AcceptInvitation, kEmpty},
      {kPost, "invitations/{course}/decline", kManageOwnAccount, kRole, DeclineInvitation, kEmpty},
  });
  return kRoutes;
}

}  // namespace faultlab::server
