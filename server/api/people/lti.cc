// lti/login, lti/launch, lti/window, lti/keys: links of learning platforms.
#include <boost/json.hpp>

#include "server/address_key.h"
#include "server/api/api.h"
#include "server/api/people/handlers.h"
#include "server/api/people/lti_page.h"
#include "server/oidc/claims.h"
#include "server/oidc/login_state.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;

constexpr std::string_view kCookie = "faultlab_lti";
constexpr std::string_view kCookieOfHost = "__Host-faultlab_lti";
constexpr int kCookieS = 600;
constexpr const char* kTasks = "/tasks";
constexpr const char* kTeach = "/teach";
constexpr int kExercisesShown = 1000;

std::string_view CookieName(const ApiRequest& request) {
  return request.http.https ? kCookieOfHost : kCookie;
}

/// For a launch in a frame of another site too: only there, where the browser keeps such apart.
void SetLaunchCookie(const ApiRequest& request,
                     const std::string& value,
                     int age_s,
                     HttpResponse& response) {
  response.headers.emplace_back("Set-Cookie",
                                std::string(CookieName(request)) + "=" + value +
                                    "; Path=/; HttpOnly; Max-Age=" + std::to_string(age_s) +
                                    "; Secure; SameSite=None; Partitioned");
}

lti::Form FormOf(const ApiRequest& request) {
  if (request.http.method != HttpMethod::kPost) return request.http.QueryAll();
  HttpRequest form;
  form.query = request.http.body;
  return form.QueryAll();
}

/// What opens a window of the lab from a frame.
std::string WindowLink(const std::string& ticket, std::string_view words) {
  return "<p><a href=\"/api/v1/lti/window?ticket=" + ticket +
         "\" target=\"_blank\" rel=\"noopener\">" + std::string(words) + "</a></p>";
}

core::Result<HttpResponse> BeginLaunch(Api& api, const ApiRequest& request) {
  auto departure = api.launches.Begin(FormOf(request), lti::ToolAt(BaseUrl(api, request)).launch);
  if (!departure) return RefusePlainly(api, request, departure.error());
  HttpResponse response = GoTo(departure.value().location);
  SetLaunchCookie(request, departure.value().sealed, kCookieS, response);
  return response;
}

/// A teacher with an account here connects it, in a window where they are signed in.
core::Result<HttpResponse> Unadmitted(Api& api,
                                      const ApiRequest& request,
                                      const lti::Launch& launch,
                                      const Error& error) {
  const bool unknown = error.reason == "oidc_no_account" || error.reason == "oidc_no_login" ||
                       error.reason == "oidc_login_taken";
  if (!launch.teaches || !unknown) return error;
  return PlainPage(
      request,
      403,
      "lti_teacher_unknown",
      {.more = WindowLink(api.launches.TicketOf(launch, kTeach, /*connects=*/true),
                          IsSerbian(request) ? "Poveži moj nalog" : "Connect my account")});
}

/// A form for each exercise, which hands its link back to the platform.
core::Result<HttpResponse> OfferExercises(Api& api,
                                          const ApiRequest& request,
                                          const lti::Launch& launch,
                                          const Account& teacher) {
  const lti::Launch::Choice& choice = *launch.choice;
  TRY(const auto all, api.assignments.List(teacher.id, 0, kExercisesShown));
  std::string forms;
  for (auto each_of = all.rbegin(); each_of != all.rend(); ++each_of) {  // the newest first
    const course::Assignment& each = *each_of;
    TRY(const bool teaches, api.accounts.Teaches(teacher.id, each.course));
    if (!teaches) continue;
    forms +=
        "<form method=\"post\" action=\"" + Escaped(choice.return_url) +
        "\"><input type=\"hidden\" name=\"JWT\" value=\"" +
        api.launches.LinkOf(
            launch, api.tool_key, each.id, each.name, lti::ToolAt(BaseUrl(api, request)).launch) +
        "\"><p><button>" + Escaped(each.name) + "</button></p></form>";
  }
  return PlainPage(request,
                   200,
                   forms.empty() ? "lti_nothing_to_choose" : "lti_choose",
                   {.more = forms, .form_action = std::string(lti::OriginOf(choice.return_url))});
}

/// The student joins the course of the exercise; its column is where the grade goes.
core::Status TakeSeat(Api& api, const lti::Launch& launch, const Account& who) {
  if (!launch.exercise) return core::Done{};
  const auto assignment = api.assignments.Get(*launch.exercise);
  if (!assignment || assignment.value().deleted) {
    return Error{ErrorCode::kForbidden, "the exercise is gone", "", "lti_exercise"};
  }
  const std::int64_t course = assignment.value().course;
  if (!launch.roster.empty()) {
    TRY_DONE(api.rosters.Put({launch.platform.id, course, launch.roster}));
  }
  if (launch.teaches) return core::Done{};
  TRY(const auto whose, api.accounts.InCourse(who.id, course));
  if (whose == Ownership::kForeign) {
    TRY_DONE(api.accounts.Enrol(course, who.id, /*teaches=*/false));
    api.audit.Add(PrincipalOf(who),
                  "enrol",
                  "course:" + std::to_string(course),
                  "by a link of " + launch.platform.label);
  }
  if (launch.lineitem.empty()) return core::Done{};
  return api.seats.Put(
      {launch.platform.id, assignment.value().id, who.id, launch.subject, launch.lineitem});
}

SignInRequest AddressOf(const ApiRequest& request) {
  return {"",
          "",
          std::string(request.http.remote_address),
          std::string(CookieValue(request.http.Header("Cookie"), kDeviceCookieName))};
}

/// Somebody who has an account by this platform.
core::Result<HttpResponse> SignInAs(Api& api,
                                    const ApiRequest& request,
                                    const lti::LaunchFlow::Ticket& ticket) {
  NewcomerRules nobody_new;
  nobody_new.make_accounts = false;
  nobody_new.staff = false;
  SignInOutcome outcome =
      api.accounts.SignInByIdentity({ticket.issuer, ticket.subject, "", "", ticket.state},
                                    nobody_new,
                                    AddressOf(request),
                                    api.clock.Wall());
  if (!outcome.signed_in) return outcome.signed_in.error();
  if (outcome.note) {
    outcome.note->detail += " by " + ticket.issuer;
    api.audit.AddBounded(*outcome.note);
  }
  HttpResponse response = GoTo(ticket.next);
  AddSignInCookies(request, outcome.signed_in.value(), response);
  return response;
}

core::Result<HttpResponse> AnswerLaunch(Api& api,
                                        const ApiRequest& request,
                                        const lti::Launch& launch) {
  const VouchedPerson person{
      lti::NameOf(launch.platform.id), launch.subject, launch.login, launch.name, launch.state};
  const auto account = api.accounts.AdmitByIdentity(
      person, NewcomersOf(launch.platform, launch.subject, launch.teaches), api.clock.Wall());
  if (!account) return Unadmitted(api, request, launch, account.error());
  if (launch.choice) return OfferExercises(api, request, launch, account.value());
  TRY_DONE(TakeSeat(api, launch, account.value()));
  const char* next = launch.teaches ? kTeach : kTasks;
  // A frame has no cookies of its own site in most browsers: the lab gets a window.
  if (request.http.Header("Sec-Fetch-Dest") != "document") {
    return PlainPage(
        request,
        200,
        "lti_window",
        {.more = WindowLink(api.launches.TicketOf(launch, next),
                            IsSerbian(request) ? "Otvori laboratoriju" : "Open the laboratory")});
  }
  return SignInAs(api, request, {person.issuer, person.subject, oidc::RandomText(), next});
}

core::Result<HttpResponse> FinishLaunch(Api& api, const ApiRequest& request) {
  const std::string network = AddressKey(request.http.remote_address);
  const core::Status patience = api.failed_launches.Try(network, api.clock.Wall());
  if (!patience.ok()) return RefusePlainly(api, request, patience.error());
  const auto launch = api.launches.Finish(
      FormOf(request), CookieValue(request.http.Header("Cookie"), CookieName(request)));
  core::Result<HttpResponse> answer = launch.ok() ? AnswerLaunch(api, request, launch.value())
                                                  : core::Result<HttpResponse>(launch.error());
  if (answer.ok() || answer.error().reason != "lti_failed") api.failed_launches.Forgive(network);
  HttpResponse response =
      answer.ok() ? std::move(answer).value() : RefusePlainly(api, request, answer.error());
  SetLaunchCookie(request, "", 0, response);
  return response;
}

/// Only for a teacher who is signed in in this browser: whoever runs the lab is not a platform's.
core::Result<HttpResponse> Connect(Api& api,
                                   const ApiRequest& request,
                                   const lti::LaunchFlow::Ticket& ticket) {
  RequestCredentials credentials;
  credentials.cookie = request.http.Header("Cookie");
  const auto who = api.accounts.Authenticate(credentials, api.clock.Wall());
  if (!who || who.value().proof != Proof::kSessionCookie || who.value().role != Role::kInstructor) {
    return RefusePlainly(
        api, request, {ErrorCode::kForbidden, "no teacher", "", "lti_sign_in_first"});
  }
  const core::Status added = api.accounts.AddIdentity(
      who.value().user_id, {ticket.issuer, ticket.subject, "", "", ticket.state}, api.clock.Wall());
  if (!added.ok()) return RefusePlainly(api, request, added.error());
  api.audit.Add(who.value(), "add_identity", who.value().owner_key(), ticket.issuer);
  return GoTo(ticket.next);
}

/// Only a click in this lab's own frame comes here: nobody signs somebody else in as themselves.
core::Result<HttpResponse> OpenWindow(Api& api, const ApiRequest& request) {
  const std::string_view site = request.http.Header("Sec-Fetch-Site");
  const auto ticket = api.launches.Open(request.http.Query("ticket").value_or(""));
  if (!ticket) return RefusePlainly(api, request, ticket.error());
  if (!site.empty() && site != "same-origin") {
    return RefusePlainly(
        api, request, {ErrorCode::kForbidden, "another site", "", "lti_elsewhere"});
  }
  if (ticket.value().connects) {
    if (site != "same-origin") {
      return RefusePlainly(
          api, request, {ErrorCode::kForbidden, "another site", "", "lti_elsewhere"});
    }
    return Connect(api, request, ticket.value());
  }
  const auto id = lti::PlatformOf(ticket.value().issuer);
  const auto platform = api.platforms.Get(id.value_or(0));
  if (!platform) return RefusePlainly(api, request, platform.error());
  auto response = SignInAs(api, request, ticket.value());
  return response.ok() ? response : RefusePlainly(api, request, response.error());
}

core::Result<HttpResponse> ShowKeys(Api& api, const ApiRequest&) {
  HttpResponse response;
  response.body = api.tool_key.KeySet();
  return response;
}

}  // namespace

std::span<const ApiRoute> LtiRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "lti/login", kReadPublic, kAnybody, BeginLaunch}.Takes("*"),
      ApiRoute{kPost, "lti/login", kReadPublic, kAnybody, BeginLaunch, kForeignForm}.Takes("*"),
      ApiRoute{kPost, "lti/launch", kReadPublic, kAnybody, FinishLaunch, kForeignForm, kOutside}
          .Takes("*"),
      ApiRoute{kGet, "lti/window", kReadPublic, kAnybody, OpenWindow}.Takes("ticket"),
      {kGet, "lti/keys", kReadPublic, kOpen, ShowKeys},
  });
  return kRoutes;
}

}  // namespace faultlab::server
