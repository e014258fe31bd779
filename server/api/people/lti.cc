// lti/login, lti/launch, lti/window, lti/keys: links of learning platforms.
#include <boost/json.hpp>

#include "server/address_key.h"
#include "server/api/api.h"
#include "server/api/people/handlers.h"
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

/// What a person reads in the platform's frame, where none of this lab's pages can be.
struct Sentence {
  std::string_view reason;
  std::string_view english;
  std::string_view serbian;
};
constexpr auto kSentences = std::to_array<Sentence>({
    {"lti_window",
     "The laboratory opens in a window of its own.",
     "Laboratorija se otvara u posebnom prozoru."},
    {"lti_elsewhere",
     "The browser did not keep what this link needs. Open the link in a new window, or allow "
     "cookies of this laboratory.",
     "Pregledač nije sačuvao ono što je ovoj vezi potrebno. Otvorite je u novom prozoru ili "
     "dozvolite kolačiće ove laboratorije."},
    {"lti_unknown",
     "This learning platform is not registered here. The administrator of the laboratory can "
     "register it.",
     "Ova platforma za učenje nije ovde prijavljena. Može je prijaviti administrator "
     "laboratorije."},
    {"lti_away",
     "The learning platform does not answer. Try again in a minute.",
     "Platforma za učenje ne odgovara. Pokušajte ponovo za minut."},
    {"lti_teacher_unknown",
     "Your platform says that you teach, and no account here is connected with it. Sign in to the "
     "laboratory in this browser, then connect it; without an account, ask the administrator of "
     "the "
     "laboratory for one.",
     "Vaša platforma kaže da predajete, a nijedan nalog ovde nije povezan sa njom. Prijavite se u "
     "laboratoriju u ovom pregledaču, pa ga povežite; ako nemate nalog, zatražite ga od "
     "administratora laboratorije."},
    {"lti_sign_in_first",
     "Sign in to the laboratory in this browser as a teacher, then follow the link of the platform "
     "once more.",
     "Prijavite se u laboratoriju u ovom pregledaču kao nastavnik, pa ponovo otvorite vezu na "
     "platformi."},
    {"lti_choose", "Choose the exercise of the link.", "Izaberite zadatak na koji vodi veza."},
    {"lti_nothing_to_choose",
     "You teach no exercise here yet. Make one in the laboratory first.",
     "Ovde još nemate nijedan zadatak. Prvo ga napravite u laboratoriji."},
    {"lti_exercise",
     "The exercise of this link is not here any more. Tell your teacher.",
     "Zadatak na koji vodi ova veza više ne postoji. Obavestite nastavnika."},
    {"oidc_disabled", "Your account here is disabled.", "Vaš nalog je ovde isključen."},
    {"oidc_elsewhere",
     "This link has been used. Follow it on the platform once more.",
     "Ova veza je iskorišćena. Otvorite je ponovo na platformi."},
    {"",
     "This link could not be taken. Follow it on the platform once more; if that does not help, "
     "tell your teacher.",
     "Ova veza nije prihvaćena. Otvorite je ponovo na platformi; ako ni to ne pomogne, obavestite "
     "nastavnika."},
});

/// The page that has the frame may show this: it has posted here, or sent the browser.
std::string FrameOf(const ApiRequest& request) {
  const std::string_view origin = request.http.Header("Origin");
  const bool plain = origin.starts_with("https://") || origin.starts_with("http://");
  const bool safe = origin.size() < 300 &&
                    origin.find_first_not_of(
                        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-:/[]") ==
                        std::string_view::npos;
  return plain && safe ? std::string(origin) : "'none'";
}

bool IsSerbian(const ApiRequest& request) {
  return request.http.Header("Accept-Language").starts_with("sr");
}

std::string Escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const std::string_view safe = c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : "";
    if (safe.empty()) {
      out.push_back(c);
    } else {
      out.append(safe);
    }
  }
  return out;
}

/// @param more  HTML below the sentence
/// @param form_action  where its forms go
HttpResponse PlainPage(const ApiRequest& request,
                       int status,
                       std::string_view reason,
                       const std::string& more = {},
                       const std::string& form_action = "'none'") {
  const auto* found = &kSentences.back();
  for (const Sentence& each : kSentences) {
    if (each.reason == reason) found = &each;
  }
  HttpResponse response;
  response.status = status;
  response.content_type = "text/html; charset=utf-8";
  response.body =
      std::string("<!doctype html><html lang=\"") + (IsSerbian(request) ? "sr-Latn" : "en") +
      "\"><meta charset=\"utf-8\"><title>faultlab</title><h1>faultlab</h1><p>" +
      std::string(IsSerbian(request) ? found->serbian : found->english) + "</p>" + more + "</html>";
  response.headers.emplace_back("Content-Security-Policy",
                                "default-src 'none'; base-uri 'none'; form-action " + form_action +
                                    "; frame-ancestors " + FrameOf(request));
  return response;
}

/// What opens a window of the lab from a frame.
std::string WindowLink(const std::string& ticket, std::string_view words) {
  return "<p><a href=\"/api/v1/lti/window?ticket=" + ticket +
         "\" target=\"_blank\" rel=\"noopener\">" + std::string(words) + "</a></p>";
}

HttpResponse Refuse(Api& api, const ApiRequest& request, const Error& error) {
  const std::string address(request.http.remote_address);
  if (api.refusal_lines.Try(AddressKey(address), api.clock.Wall()).ok()) {
    api.log("launch from " + address + ": " + error.reason + ": " + error.message);
  }
  const int status = error.code == ErrorCode::kTooMany                                     ? 429
                     : error.reason == "lti_away" || error.code == ErrorCode::kUnavailable ? 503
                                                                                           : 403;
  return PlainPage(request, status, error.reason);
}

core::Result<HttpResponse> BeginLaunch(Api& api, const ApiRequest& request) {
  auto departure =
      api.launches.Begin(FormOf(request), BaseUrl(api, request) + "/api/v1/lti/launch");
  if (!departure) return Refuse(api, request, departure.error());
  HttpResponse response = GoTo(departure.value().location);
  SetLaunchCookie(request, departure.value().sealed, kCookieS, response);
  return response;
}

NewcomerRules RulesOf(const lti::Launch& launch) {
  NewcomerRules rules;
  rules.make_accounts = !launch.teaches || launch.makes_teachers;
  rules.claim_class_list = launch.claims_class_lists && !launch.teaches;
  rules.staff = false;
  rules.role = launch.teaches ? Role::kInstructor : Role::kStudent;
  // Logins of people who have no login, or that of somebody else.
  const std::string name = lti::NameOf(launch.platform);
  rules.other_login = "lti" + std::to_string(launch.platform) + "-" +
                      HashSecret(name + launch.subject).substr(0, 10);
  return rules;
}

/// A teacher with an account here connects it, in a window where they are signed in.
core::Result<HttpResponse> Unadmitted(Api& api,
                                      const ApiRequest& request,
                                      const lti::Launch& launch,
                                      const Error& error) {
  const bool unknown = error.reason == "oidc_no_account" || error.reason == "oidc_no_login" ||
                       error.reason == "oidc_login_taken";
  if (!launch.teaches || !unknown) return error;
  return PlainPage(request,
                   403,
                   "lti_teacher_unknown",
                   WindowLink(api.launches.TicketOf(launch, kTeach, /*connects=*/true),
                              IsSerbian(request) ? "Poveži moj nalog" : "Connect my account"));
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
    forms += "<form method=\"post\" action=\"" + Escaped(choice.return_url) +
             "\"><input type=\"hidden\" name=\"JWT\" value=\"" +
             api.launches.LinkOf(choice,
                                 api.tool_key,
                                 each.id,
                                 each.name,
                                 BaseUrl(api, request) + "/api/v1/lti/launch") +
             "\"><p><button>" + Escaped(each.name) + "</button></p></form>";
  }
  const std::size_t origin_end = choice.return_url.find('/', choice.return_url.find("://") + 3);
  return PlainPage(request,
                   200,
                   forms.empty() ? "lti_nothing_to_choose" : "lti_choose",
                   forms,
                   choice.return_url.substr(0, origin_end));
}

/// The student joins the course of the exercise; its column is where the grade goes.
core::Status TakeSeat(Api& api, const lti::Launch& launch, const Principal& who) {
  if (!launch.exercise) return core::Done{};
  const auto assignment = api.assignments.Get(*launch.exercise);
  if (!assignment || assignment.value().deleted) {
    return Error{ErrorCode::kForbidden, "the exercise is gone", "", "lti_exercise"};
  }
  if (launch.teaches) return core::Done{};
  TRY(const bool attends, api.accounts.Attends(who.user_id, assignment.value().course));
  if (!attends) {
    TRY_DONE(api.accounts.Enrol(assignment.value().course, who.user_id, /*teaches=*/false));
    api.audit.Add(who,
                  "enrol",
                  "course:" + std::to_string(assignment.value().course),
                  "by a link of " + launch.label);
  }
  if (launch.lineitem.empty()) return core::Done{};
  return api.seats.Put(
      {launch.platform, assignment.value().id, who.user_id, launch.subject, launch.lineitem});
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
      lti::NameOf(launch.platform), launch.subject, launch.login, launch.name, launch.state};
  const auto account = api.accounts.AdmitByIdentity(person, RulesOf(launch), api.clock.Wall());
  if (!account) return Unadmitted(api, request, launch, account.error());
  if (launch.choice) return OfferExercises(api, request, launch, account.value());
  TRY_DONE(TakeSeat(api, launch, PrincipalOf(account.value())));
  const char* next = launch.teaches ? kTeach : kTasks;
  // A frame has no cookies of its own site in most browsers: the lab gets a window.
  if (request.http.Header("Sec-Fetch-Dest") != "document") {
    return PlainPage(
        request,
        200,
        "lti_window",
        WindowLink(api.launches.TicketOf(launch, next),
                   IsSerbian(request) ? "Otvori laboratoriju" : "Open the laboratory"));
  }
  return SignInAs(api, request, {person.issuer, person.subject, oidc::RandomText(), next});
}

core::Result<HttpResponse> FinishLaunch(Api& api, const ApiRequest& request) {
  const std::string network = AddressKey(request.http.remote_address);
  const core::Status patience = api.failed_launches.Try(network, api.clock.Wall());
  if (!patience.ok()) return Refuse(api, request, patience.error());
  const auto launch = api.launches.Finish(
      FormOf(request), CookieValue(request.http.Header("Cookie"), CookieName(request)));
  core::Result<HttpResponse> answer = launch.ok() ? AnswerLaunch(api, request, launch.value())
                                                  : core::Result<HttpResponse>(launch.error());
  if (answer.ok() || answer.error().reason != "lti_failed") api.failed_launches.Forgive(network);
  HttpResponse response =
      answer.ok() ? std::move(answer).value() : Refuse(api, request, answer.error());
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
    return Refuse(api, request, {ErrorCode::kForbidden, "no teacher", "", "lti_sign_in_first"});
  }
  const core::Status added = api.accounts.AddIdentity(
      who.value().user_id, {ticket.issuer, ticket.subject, "", "", ticket.state}, api.clock.Wall());
  if (!added.ok()) return Refuse(api, request, added.error());
  api.audit.Add(who.value(), "add_identity", who.value().owner_key(), ticket.issuer);
  return GoTo(ticket.next);
}

/// Only a click in this lab's own frame comes here: nobody signs somebody else in as themselves.
core::Result<HttpResponse> OpenWindow(Api& api, const ApiRequest& request) {
  const std::string_view site = request.http.Header("Sec-Fetch-Site");
  const auto ticket = api.launches.Open(request.http.Query("ticket").value_or(""));
  if (!ticket) return Refuse(api, request, ticket.error());
  if (!site.empty() && site != "same-origin") {
    return Refuse(api, request, {ErrorCode::kForbidden, "another site", "", "lti_elsewhere"});
  }
  if (ticket.value().connects) {
    if (site != "same-origin") {
      return Refuse(api, request, {ErrorCode::kForbidden, "another site", "", "lti_elsewhere"});
    }
    return Connect(api, request, ticket.value());
  }
  const auto id = lti::PlatformOf(ticket.value().issuer);
  const auto platform = api.platforms.Get(id.value_or(0));
  if (!platform) return Refuse(api, request, platform.error());
  auto response = SignInAs(api, request, ticket.value());
  return response.ok() ? response : Refuse(api, request, response.error());
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
