#include "server/api/people/lti_page.h"

#include <array>

#include "server/address_key.h"
#include "server/api/api.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

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
    {"lti_registered",
     "The laboratory is registered here. You can close this window.",
     "Laboratorija je ovde prijavljena. Možete zatvoriti ovaj prozor."},
    {"lti_register_over",
     "This address has been used, or is older than an hour. The administrator of the laboratory "
     "can "
     "make another one.",
     "Ova adresa je iskorišćena ili je starija od sat vremena. Administrator laboratorije može "
     "napraviti novu."},
    {"lti_register_failed",
     "The laboratory could not be registered:",
     "Laboratorija nije mogla biti prijavljena:"},
    {"platforms_full",
     "This laboratory takes no more learning platforms. Its administrator can remove one.",
     "Ova laboratorija ne prima više platformi za učenje. Administrator može ukloniti neku."},
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

}  // namespace

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

HttpResponse PlainPage(const ApiRequest& request,
                       int status,
                       std::string_view reason,
                       const PlainPageParts& parts) {
  const auto* found = &kSentences.back();
  for (const Sentence& each : kSentences) {
    if (each.reason == reason) found = &each;
  }
  HttpResponse response;
  response.status = status;
  response.content_type = "text/html; charset=utf-8";
  response.body = std::string("<!doctype html><html lang=\"") +
                  (IsSerbian(request) ? "sr-Latn" : "en") +
                  "\"><meta charset=\"utf-8\"><title>faultlab</title><h1>faultlab</h1><p>" +
                  std::string(IsSerbian(request) ? found->serbian : found->english) + "</p>" +
                  parts.more + "</html>";
  std::string policy = "default-src 'none'; base-uri 'none'; form-action " + parts.form_action +
                       "; frame-ancestors " +
                       (parts.frame.empty() ? FrameOf(request) : parts.frame);
  if (!parts.script.empty()) policy += "; script-src " + parts.script;
  response.headers.emplace_back("Content-Security-Policy", std::move(policy));
  // Who has opened it in a window of its own hears from it.
  if (!parts.script.empty()) {
    response.headers.emplace_back("Cross-Origin-Opener-Policy", "unsafe-none");
  }
  return response;
}

HttpResponse RefusePlainly(Api& api,
                           const ApiRequest& request,
                           const Error& error,
                           const std::string& frame) {
  const std::string address(request.http.remote_address);
  if (api.refusal_lines.Try(AddressKey(address), api.clock.Wall()).ok()) {
    api.log("launch from " + address + ": " + error.reason + ": " + error.message);
  }
  const int status = error.code == ErrorCode::kTooMany                                     ? 429
                     : error.reason == "lti_away" || error.code == ErrorCode::kUnavailable ? 503
                                                                                           : 403;
  const bool to_an_admin = error.reason == "lti_register_failed";
  return PlainPage(
      request,
      status,
      error.reason,
      {.more = to_an_admin ? "<p>" + Escaped(error.message) + "</p>" : "", .frame = frame});
}

}  // namespace faultlab::server
