// sessions: the lease one works in.
#include <boost/json.hpp>

#include "server/api/sharing/lists.h"
#include "server/json/json_reader.h"
#include "server/lab/lab_store.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::SessionId;
using lab::SessionState;
using lab::UserId;

std::string LoginOf(Api& api, UserId user) {
  const auto account = api.accounts.Get(Number(user));
  return account.ok() ? account.value().login : "?";
}

const lab::Session* FindLive(const lab::LabState& state, std::int64_t id) {
  const auto found = state.sessions.find(SessionId{id});
  if (found == state.sessions.end() || found->second.state == SessionState::kClosed) return nullptr;
  return &found->second;
}

core::Error NoSession() {
  return core::Refuse("no_session");
}

/// Runs `input` on the session of the path as its user (or whom the matrix allows).
template <typename Input>
core::Result<HttpResponse> OnSession(Api& api, const ApiRequest& request, Input input) {
  TRY(auto id, PathNumber(request));
  TRY_DONE(api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    const lab::Session* session = FindLive(scheduler.state(), id);
    if (session == nullptr) return NoSession();
    const bool own = session->user == UserId{request.who.user_id};
    TRY_DONE(Authorize(
        request.who, Operation::kUseSession, own ? Ownership::kOwn : Ownership::kForeign));
    return input(scheduler, *session, now);
  }));
  const auto state = api.service.state();
  const lab::Session* session = FindLive(*state, id);
  if (session == nullptr) return NoContent();
  return JsonResponse(SessionToJson(api, *session));
}

core::Result<HttpResponse> ListSessions(Api& api, const ApiRequest& request) {
  const auto state = api.service.state();
  TRY(const auto asked, QueryWord(request.http, "all", {"1", "0", "true", "false"}));
  const std::string all = asked.value_or("0");
  if (all == "0" || all == "false") {
    json::array own = SessionsOf(api, *state, UserId{request.who.user_id});
    const bool none = own.empty();
    HttpResponse response = ListAnswer(std::move(own));
    response.unsettled = !none;
    return response;
  }
  if (!Authorize(request.who, Operation::kSpectate, Ownership::kCourse).ok()) {
    return core::Refuse("others_sessions", "all");
  }
  json::array items;
  for (const auto& [id, session] : state->sessions) {
    if (session.state == SessionState::kClosed || session.kind == lab::TicketKind::kPractice) {
      continue;
    }
    TRY(auto relation, api.accounts.Relation(request.who, Number(session.user)));
    if (!Authorize(request.who, Operation::kSpectate, relation).ok()) continue;
    items.push_back(SessionToJson(api, session));
  }
  return ListAnswer(std::move(items));
}

core::Result<HttpResponse> ListPastSessions(Api& api, const ApiRequest& request) {
  TRY(const Page page, PageOf(request.http));
  const SessionId before{page.after > 0 ? page.after : INT64_MAX};
  TRY(const auto sessions, api.database.Read([&](Transaction& tx) {
    return lab::lab_store::PastSessions(tx, UserId{request.who.user_id}, before, page.limit);
  }));
  const auto to_json = [](const lab::Session& session) {
    return json::object{{"id", Number(session.id)},
                        {"rig", session.rig},
                        {"rig_class", session.rig_class},
                        {"start", Iso8601(session.start)},
                        {"end", TimeOrNull(session.ended)},
                        {"why", Name(session.end_reason)}};
  };
  const std::int64_t last = sessions.empty() ? 0 : Number(sessions.back().id);
  return page.Answer(ListOf(sessions, to_json), last);
}

core::Result<HttpResponse> ExtendSession(Api& api, const ApiRequest& request) {
  return OnSession(
      api,
      request,
      [](lab::Scheduler& scheduler, const lab::Session& session, WallTime now) -> core::Status {
        const auto extended = scheduler.Extend(session.id, now);
        if (extended.ok()) return core::Done{};
        return core::Error(extended.error()).As(core::ErrorCode::kConflict);
      });
}

core::Result<HttpResponse> EndSession(Api& api, const ApiRequest& request) {
  bool foreign = false;
  auto ended = OnSession(
      api,
      request,
      [&](lab::Scheduler& scheduler, const lab::Session& session, WallTime now) -> core::Status {
        foreign = session.user != UserId{request.who.user_id};
        const auto reason = foreign ? lab::EndReason::kOperator : lab::EndReason::kEnded;
        const char* text = foreign ? "ended by an operator" : "ended";
        return scheduler.EndSession(session.id, reason, text, now);
      });
  if (ended.ok() && foreign) {
    api.audit.Add(request.who, "end_session", "session:" + request.http.PathParameter("id"), "");
  }
  return ended;
}

core::Result<HttpResponse> StillThere(Api& api, const ApiRequest& request) {
  return OnSession(
      api,
      request,
      [](lab::Scheduler& scheduler, const lab::Session& session, WallTime now) -> core::Status {
        return scheduler.StillThere(session.id, now);
      });
}

core::Result<HttpResponse> OfferControl(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string to = in.Text("to", 64);
  if (auto error = in.Finish()) return *error;
  auto account = api.accounts.GetByLogin(to);
  if (!account) {
    return core::Refuse("no_login", "/to");
  }
  const UserId target{account.value().id};
  return OnSession(
      api,
      request,
      [&](lab::Scheduler& scheduler, const lab::Session& session, WallTime now) -> core::Status {
        return scheduler.OfferControl(session.id, target, now);
      });
}

core::Result<HttpResponse> AcceptControl(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  const UserId me{request.who.user_id};
  TRY(const auto courses, api.accounts.CoursesOf(request.who.user_id));
  TRY(const auto session,
      api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
        const lab::Session* live = FindLive(scheduler.state(), id);
        // A session that was not offered looks as if it were not there.
        if (live == nullptr || live->offered_to != me) return NoSession();
        return scheduler.AcceptControl(live->id, me, now, courses);
      }));
  return JsonResponse(SessionToJson(api, session));
}

core::Result<HttpResponse> TakeOverSession(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  ObjectReader in(request.body, "");
  const std::string reason = in.Text("reason", 500);
  if (auto error = in.Finish()) return *error;
  const auto state = api.service.state();
  const lab::Session* live = FindLive(*state, id);
  if (live == nullptr) return NoSession();
  const UserId holder = live->user;
  TRY(auto relation, api.accounts.Relation(request.who, Number(holder)));
  TRY_DONE(Authorize(request.who, Operation::kTakeOverSession, relation));
  TRY(const auto taken,
      api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
        const lab::Session* current = FindLive(scheduler.state(), id);
        if (current == nullptr || current->user != holder) return NoSession();
        return scheduler.TakeOver(current->id, UserId{request.who.user_id}, reason, now);
      }));
  api.audit.Add(request.who, "take_over", "session:" + std::to_string(id), reason);
  return JsonResponse(SessionToJson(api, taken));
}

}  // namespace

json::object SessionToJson(Api& api, const lab::Session& session) {
  json::object out{{"id", Number(session.id)},
                   {"rig", session.rig},
                   {"rig_class", session.rig_class},
                   {"epoch", session.epoch},
                   {"state", Name(session.state)},
                   {"user", LoginOf(api, session.user)},
                   {"start", Iso8601(session.start)},
                   {"end", Iso8601(session.hard_end)},
                   {"run_in_progress", session.run_in_progress}};
  if (session.run_in_progress) {
    for (const RunSnapshot& run : api.runs.Running()) {
      if (run.rig == session.rig) out["run"] = run.id;
    }
    if (!out.contains("run")) {  // of another server
      const auto run = api.store.RunningOn(session.rig);
      if (run.ok() && run.value()) out["run"] = *run.value();
    }
  }
  if (session.state == SessionState::kHeld) out["claim_until"] = Iso8601(session.claim_until);
  if (session.idle_answer_until) out["still_there_until"] = Iso8601(*session.idle_answer_until);
  if (session.offered_to != UserId{}) out["offered_to"] = LoginOf(api, session.offered_to);
  if (session.booking != lab::BookingId{}) out["booking"] = Number(session.booking);
  if (session.ticket != lab::TicketId{}) out["ticket"] = Number(session.ticket);
  return out;
}

json::array SessionsOf(Api& api, const lab::LabState& state, UserId user) {
  json::array items;
  for (const auto& [id, session] : state.sessions) {
    if (session.state == SessionState::kClosed || session.kind == lab::TicketKind::kPractice) {
      continue;
    }
    // Whoever is offered the control must see what to accept.
    if (session.user == user || session.offered_to == user) {
      items.push_back(SessionToJson(api, session));
    }
  }
  return items;
}

std::span<const ApiRoute> SessionsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "sessions", kUseSession, kRole, ListSessions}.Takes("all wait"),
      ApiRoute{kGet, "sessions/past", kUseSession, kRole, ListPastSessions}.Takes("cursor limit"),
      {kPost, "sessions/{id}/extend", kUseSession, kRole, ExtendSession, kEmpty},
      {kPost,
       "sessions/{id}/end",
       kUseSession,
       kRole,
       EndSession,
       kEmptyToEnd,
       kQuick,
       kSessionsMember},
      {kPost, "sessions/{id}/still-there", kUseSession, kRole, StillThere, kEmpty},
      {kPost, "sessions/{id}/handover", kUseSession, kRole, OfferControl, kJson},
      {kPost,
       "sessions/{id}/handover/accept",
       kUseSession,
       kRole,
       AcceptControl,
       kEmpty,
       kQuick,
       kSessionsMember},
      {kPost,
       "sessions/{id}/take-over",
       kSpectate,
       kRole,
       TakeOverSession,
       kJson,
       kQuick,
       kSessionsMember},
  });
  return kRoutes;
}

}  // namespace faultlab::server
